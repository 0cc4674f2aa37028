//! Errors of a comparison are those of the scene, the size and the settings.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

const SMALL: [&str; 9] = [
    "--size",
    "32x18",
    "--map",
    "64",
    "--backend",
    "cpu",
    "--json",
    // What is compared are the rows of methods.
    "--studies",
    "none",
];

/// The rows of a comparison on so many threads: their errors by what was measured.
fn errors(place: &Path, threads: usize, arguments: &[&str]) -> BTreeMap<String, Vec<String>> {
    let output = Command::new(env!("CARGO_BIN_EXE_crepuscular"))
        .current_dir(place)
        .env("RAYON_NUM_THREADS", threads.to_string())
        .arg("compare")
        .args(arguments)
        .args(SMALL)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    // With little time on a busy machine there may be nothing.
    let code = output.status.code();
    assert!(matches!(code, Some(0 | 1)), "{arguments:?}: {message}");
    let csv = std::fs::read_to_string(place.join("crepuscular-report/results.csv")).unwrap();
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let column = |name: &str| header.iter().position(|column| *column == name).unwrap();
    let pick = |line: &[&str], columns: &[&str]| -> Vec<String> {
        columns
            .iter()
            .map(|name| line[column(name)].to_owned())
            .collect()
    };
    let row = |line: Vec<&str>| {
        let what = pick(
            &line,
            &["visibility", "airlight", "quality", "map", "map_refined"],
        );
        let how_wrong = [
            "error_rmse",
            "error_max",
            "error_rel_p99",
            "error_relmse",
            "error_flip",
            "error_map",
        ];
        (what.join(" "), pick(&line, &how_wrong))
    };
    lines.map(row).collect()
}

#[test]
fn the_same_command_gives_the_same_errors_whatever_the_time_and_the_threads() {
    let place = tempfile::tempdir().unwrap();
    let only = ["fence", "--methods", "march,exact,voxel-average"];
    let all = errors(place.path(), 2, &[&only[..], &["--fixed"]].concat());
    assert!(all.len() >= 8, "{all:?}");
    let long = ["--time-budget", "900"];
    let again = errors(place.path(), 1, &[&only[..], &long].concat());
    assert_eq!(again, all);
    // Whatever there is time for is the same; what is dropped may be much.
    for seconds in ["1", "3"] {
        let some = errors(
            place.path(),
            3,
            &[&only[..], &["--time-budget", seconds]].concat(),
        );
        for (row, errors) in &some {
            for (error, expected) in errors.iter().zip(&all[row]) {
                assert!(
                    error.is_empty() || error == expected,
                    "{row}: {error} {expected}"
                );
            }
        }
    }
}

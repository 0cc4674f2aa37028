//! Comparisons on several backends.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output};

use gpu_backend::gpu::Context;

const QUICK: [&str; 10] = [
    "compare",
    "fence",
    "--quick",
    "--size",
    "32x18",
    "--map",
    "64",
    "--time-budget",
    "600",
    "--backend",
];

fn crepuscular(place: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_crepuscular"));
    command.current_dir(place);
    command
}

fn errors_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The columns of a line; quotes may hold commas.
fn columns(line: &str) -> Vec<String> {
    let mut columns = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => columns.push(String::new()),
            _ => columns.last_mut().unwrap().push(c),
        }
    }
    columns
}

/// The rows of the table in `place`, without the header.
fn rows(place: &Path) -> Vec<Vec<String>> {
    let csv = std::fs::read_to_string(place.join("crepuscular-report/results.csv")).unwrap();
    csv.lines().skip(1).map(columns).collect()
}

/// The GPU; without one the test of that name says that it is skipped.
pub(crate) fn gpu(test: &str) -> Option<Context> {
    match Context::request() {
        Ok(context) => Some(context),
        Err(error) => {
            let required = std::env::var("REQUIRE_GPU").is_ok_and(|value| value == "1");
            assert!(!required, "REQUIRE_GPU is 1, but {error}");
            // Past the capture of the test runner; a closed stderr is no
            // reason to fail.
            writeln!(std::io::stderr(), "SKIPPED {test}: {error}").ok();
            None
        }
    }
}

#[test]
fn both_backends_have_rows_that_agree() {
    let Some(context) = gpu("both_backends_have_rows_that_agree") else {
        return;
    };
    let place = tempfile::tempdir().unwrap();
    let output = crepuscular(place.path())
        .args(QUICK)
        .arg("cpu,gpu")
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", errors_of(&output));

    let rows = rows(place.path());
    assert!(rows.iter().all(|row| row.len() == 23), "{rows:?}");
    let software = if context.is_software() {
        ", software"
    } else {
        ""
    };
    let gpu = format!("gpu ({}{software})", context.adapter().name);
    let of = |backend: &str| -> Vec<&Vec<String>> {
        rows.iter().filter(|row| row[4] == backend).collect()
    };
    let (on_cpu, on_gpu) = (of("cpu"), of(&gpu));
    assert_eq!(on_cpu.len() + on_gpu.len(), rows.len(), "{rows:?}");
    assert!(on_cpu.iter().any(|row| row[2] == "exact"));
    for visibility in ["none", "exact", "march", "march-merged", "equi-angular"] {
        assert!(on_gpu.iter().any(|row| row[2] == visibility), "{rows:?}");
    }
    for row in on_gpu {
        let twin = on_cpu
            .iter()
            .find(|other| other[2..4] == row[2..4] && other[5] == row[5]);
        let rmse = |row: &[String]| row[6].parse::<f64>().unwrap();
        let (a, b) = (rmse(twin.unwrap()), rmse(row));
        // Texels and steps that fall on the other side of an edge differ.
        assert!((a - b).abs() < 0.1 * a.max(b), "{row:?} {twin:?}");
        assert!(row[10].parse::<f64>().unwrap() > 0.0, "{row:?}");
    }

    let html = std::fs::read_to_string(place.path().join("crepuscular-report/index.html")).unwrap();
    assert!(html.contains(&gpu) && html.contains("It has no shader"));
    assert_eq!(
        html.contains("not representative"),
        context.is_software(),
        "the report names a software adapter as such"
    );
}

#[test]
fn without_an_adapter_the_comparison_goes_on_unless_one_is_asked_for() {
    let place = tempfile::tempdir().unwrap();
    let without = |arguments: &[&str]| {
        let mut command = crepuscular(place.path());
        command
            .args(arguments)
            .env("CREPUSCULAR_ADAPTER", "an adapter that nobody has")
            .env_remove("REQUIRE_GPU");
        command
    };
    let output = without(&QUICK[..9])
        .args(["--studies", "none"])
        .output()
        .unwrap();
    let text = errors_of(&output);
    assert!(output.status.success(), "{text}");
    assert_eq!(text.matches("gpu: skipped, ").count(), 1, "{text}");
    assert!(rows(place.path()).iter().all(|row| row[4] == "cpu"));
    let html = std::fs::read_to_string(place.path().join("crepuscular-report/index.html")).unwrap();
    let html = html.to_lowercase();
    assert_eq!(html.matches("skipped, no gpu adapter").count(), 1);

    let asked = without(&[&QUICK[..], &["gpu"]].concat()).output().unwrap();
    let required = without(&QUICK[..9])
        .env("REQUIRE_GPU", "1")
        .output()
        .unwrap();
    for output in [asked, required] {
        assert_eq!(output.status.code(), Some(2));
        let text = errors_of(&output);
        assert!(text.contains("no GPU adapter"), "{text}");
    }
}

#[test]
fn a_picture_by_the_gpu_needs_no_method() {
    if gpu("a_picture_by_the_gpu_needs_no_method").is_none() {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    for airlight in [&[][..], &["--airlight", "table"]] {
        let render = ["render", "fence", "--size", "32x18", "-o", "a.png"];
        let arguments = [&render[..], &["--backend", "gpu"], airlight].concat();
        let output = crepuscular(place.path()).args(arguments).output().unwrap();
        assert!(output.status.success(), "{}", errors_of(&output));
    }
}

/// Of two lights one or both have shadows in files; those are lit by the GPU.
#[test]
fn surfaces_with_precomputed_shadows_are_those_of_both_backends() {
    if gpu("surfaces_with_precomputed_shadows_are_those_of_both_backends").is_none() {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    let succeeds = |arguments: &[&str]| {
        let output = crepuscular(place.path()).args(arguments).output().unwrap();
        assert!(output.status.success(), "{}", errors_of(&output));
        errors_of(&output)
    };
    let bake = ["bake", "stiff", "--resolution", "512"];
    succeeds(&[&bake[..], &["--light", "1", "-o", "one.cpvs"]].concat());
    succeeds(&[&bake[..], &["--light", "all", "-o", "all.cpvs"]].concat());
    let surfaces = |backend: &str, shadows: &[&str]| {
        let render = ["render", "stiff", "--size", "64x36", "--layers"];
        let how = ["--backend", backend, "-o", "a.exr"];
        let light = ["--visibility", "march", "--airlight", "midpoint"];
        let notes = succeeds(&[&render[..], &how, &light, shadows].concat());
        assert!(!notes.contains("lit on the CPU"), "{notes}");
        let image = exr::prelude::read_all_flat_layers_from_file(place.path().join("a.exr"));
        let image = image.unwrap();
        let channels = image.layer_data[0].channel_data.list.iter();
        let surfaces = channels.filter(|channel| channel.name.to_string() == "surfaces.G");
        surfaces
            .flat_map(|channel| channel.sample_data.values_as_f32().collect::<Vec<_>>())
            .collect::<Vec<f32>>()
    };
    let differing = |a: &[f32], b: &[f32]| {
        let differ = |(a, b): &(&f32, &f32)| (*a - *b).abs() > 1e-5 * (1e-3 + a.abs().max(b.abs()));
        a.iter().zip(b).filter(differ).count()
    };
    let traced = surfaces("cpu", &[]);
    for shadows in [
        &["--shadows", "one.cpvs"][..],
        &["--shadows", "all.cpvs", "--filter", "3"],
    ] {
        let [on_cpu, on_gpu] = ["cpu", "gpu"].map(|backend| surfaces(backend, shadows));
        assert_eq!(on_cpu.len(), 64 * 36);
        let different = differing(&on_cpu, &on_gpu);
        println!("{different} of {} pixels", on_cpu.len());
        assert!(100 * different <= on_cpu.len(), "{different}");
        assert!(differing(&on_cpu, &traced) > different);
    }
}

//! What is foreseen of a scene, and the choices that are made by it.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use crate::backends::gpu;
use crate::common::{fails, names, notes, run, succeeds};
use serde_json::{Value, json};

const SMALL: [&str; 6] = ["--size", "64x36", "--map", "128", "--backend", "cpu"];

/// A profile of a machine of which nothing is known, so that that of the user has no part.
fn profile(place: &Path) {
    let text = r#"{"format": "crepuscular machine profile", "version": 1, "methods": []}"#;
    std::fs::write(place.join("none.json"), text).unwrap();
}

fn plan(place: &Path, scene: &str, options: &[&str]) -> String {
    let all = [
        &["plan", scene, "--profile", "none.json"][..],
        &SMALL,
        options,
    ]
    .concat();
    succeeds(place, &all)
}

#[test]
fn a_plan_says_what_runs_what_it_takes_and_what_to_choose() {
    let place = tempfile::tempdir().unwrap();
    profile(place.path());
    let some = [
        "--methods",
        "march x midpoint,hybrid x gauss",
        "--error",
        "30%",
    ];
    let text = plan(place.path(), "fence", &some);
    assert!(text.contains("runs: airlight of emitter 0"), "{text}");
    assert!(
        text.contains("frame ms") && text.contains("RMSE %"),
        "{text}"
    );
    assert!(
        text.lines()
            .any(|line| line.starts_with("march x midpoint")),
        "{text}"
    );
    let last = text.lines().last().unwrap();
    assert!(last.starts_with("for an error of 30.000 %: "), "{last}");
    assert_eq!(names(place.path()), ["none.json"]);
}

#[test]
fn errors_are_foreseen_alike_whenever_and_as_json() {
    let place = tempfile::tempdir().unwrap();
    profile(place.path());
    let options = [
        "--methods",
        "march x midpoint,exact x gauss",
        "--time",
        "1s",
        "--json",
    ];
    let read = || -> Value { serde_json::from_str(&plan(place.path(), "coil", &options)).unwrap() };
    let first = read();
    assert_eq!(
        (&first["scene"], &first["width"]),
        (&Value::from("coil"), &Value::from(64))
    );
    let rows = first["rows"].as_array().unwrap();
    assert!(rows.len() > 6, "{first:#}");
    for row in rows {
        for number in [
            "seconds_build",
            "seconds_frame",
            "bytes",
            "error_rmse",
            "error_rmse_spread",
        ] {
            assert!(
                row[number].as_f64().is_some_and(|x| x >= 0.0),
                "{number}: {row:#}"
            );
        }
        for text in ["method", "backend", "quality_unit", "known"] {
            assert!(row[text].is_string(), "{text}: {row:#}");
        }
        assert!(row["actual"].is_null() && row["quality"].is_u64());
    }
    assert_eq!(first["choice"]["met"], true);
    assert_eq!(first["choice"]["time"], 1.0);
    assert!(first["choice"]["error"].is_null() && first["analysis"].is_null());
    let passes = first["passes"].as_array().unwrap().iter();
    assert!(
        passes
            .clone()
            .any(|pass| pass.as_str().unwrap().contains("airlight of"))
    );
    assert!(!first["passes"].to_string().contains("left out"));
    let left_out = first["left_out"].as_array().unwrap();
    let is_named = |part: &Value| {
        part["what"]
            .as_str()
            .unwrap()
            .contains("(hybrid x gauss-8)")
    };
    assert!(left_out.iter().any(is_named), "{left_out:?}");
    let errors = |value: &Value| -> Vec<Value> {
        let rows = value["rows"].as_array().unwrap().iter();
        rows.map(|row| row["error_rmse"].clone()).collect()
    };
    assert_eq!(errors(&first), errors(&read()));
}

#[test]
fn an_analysis_has_what_came_out_beside_what_was_foreseen() {
    let place = tempfile::tempdir().unwrap();
    profile(place.path());
    let options = ["--methods", "march x midpoint", "--analyze"];
    let text = plan(place.path(), "fence", &options);
    assert!(text.contains("q-errors of time, median"), "{text}");
    let json: Value = serde_json::from_str(&plan(
        place.path(),
        "fence",
        &[&options[..], &["--json"]].concat(),
    ))
    .unwrap();
    for row in json["rows"].as_array().unwrap() {
        let actual = &row["actual"];
        assert!(actual["q_time"].as_f64().unwrap() >= 1.0, "{row:#}");
        // The whole picture is small enough for the sample.
        assert!(actual["q_error"].as_f64().unwrap() < 1.5, "{row:#}");
        assert!(actual["seconds_frame_min"].as_f64().unwrap() > 0.0);
    }
    assert!(json["analysis"]["copy_spread"].as_f64().unwrap() >= 0.0);
}

#[test]
fn a_profile_is_learned_read_and_never_put_in_place_of_something_else() {
    let place = tempfile::tempdir().unwrap();
    let learn = |file: &str| {
        let all = [
            &[
                "plan",
                "--calibrate",
                "fence",
                "coil",
                "--methods",
                "march x midpoint",
            ][..],
            &["--profile", file],
            &SMALL,
        ];
        run(place.path(), &all.concat())
    };
    let done = learn("machine.json");
    let text = String::from_utf8_lossy(&done.stdout).into_owned();
    assert_eq!(text, "machine.json: 1 method from 2 scenes\n");
    let read: Value =
        serde_json::from_slice(&std::fs::read(place.path().join("machine.json")).unwrap()).unwrap();
    assert_eq!(read["methods"][0]["method"], "march x midpoint");
    let with = [
        "plan",
        "fence",
        "--profile",
        "machine.json",
        "--methods",
        "march x midpoint",
    ];
    assert!(succeeds(place.path(), &[&with[..], &SMALL].concat()).contains("march x midpoint"));

    std::fs::write(place.path().join("notes.json"), "[]").unwrap();
    let refused = learn("notes.json");
    let why = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        why.contains("is no machine profile, and is not overwritten"),
        "{why}"
    );
    let damaged = ["plan", "fence", "--profile", "notes.json"];
    fails(place.path(), &damaged, "is not a valid machine profile");
    fails(
        place.path(),
        &["plan", "fence", "--profile", "none"],
        "none",
    );
}

#[test]
fn what_cannot_be_asked_for_is_said() {
    let place = tempfile::tempdir().unwrap();
    let fence = |options: &[&'static str]| [&["plan", "fence"][..], options].concat();
    for (options, cause) in [
        (&["--error", "0"][..], "above 0 and at most 100 %"),
        (&["--error", "101%"], "above 0 and at most 100 %"),
        (&["--error", "1ms"], "such as 1% or 0.01"),
        (&["--error", "nan"], "such as 1% or 0.01"),
        (&["--time", "-1s"], "above 0 and at most a day"),
        (&["--time", "1%"], "such as 16ms, 2s or 0.016"),
        (&["--time", "1s", "--error", "1%"], "cannot be used with"),
        (&["--frames", "0"], "0 is not in"),
        (&["--analyze", "--calibrate"], "cannot be used with"),
        (&["--methods", "no such method"], "no such method"),
        (&["coil"], "expected one scene"),
    ] {
        fails(place.path(), &fence(options), cause);
    }
    fails(place.path(), &["plan"], "SCENE");
    let render = ["render", "fence", "-o", "a.exr", "--error", "1%"];
    for other in [
        ["--method", "march"],
        ["--quality", "8"],
        ["--visibility", "exact"],
        ["--shadows", "a.cpvs"],
    ] {
        fails(
            place.path(),
            &[&render[..], &other].concat(),
            "cannot be used with",
        );
    }
    assert!(names(place.path()).is_empty());
}

#[test]
fn a_target_that_nothing_meets_is_an_exit_code_of_1_and_the_nearest() {
    let place = tempfile::tempdir().unwrap();
    profile(place.path());
    let all = [
        &[
            "plan",
            "fence",
            "--profile",
            "none.json",
            "--methods",
            "none x gauss",
            "--error",
            "0.1%",
        ][..],
        &SMALL,
    ];
    let output = run(place.path(), &all.concat());
    let why = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{why}");
    assert!(
        why.contains(
            "nothing is expected to meet an error of 0.100 %; the nearest is none x gauss"
        ),
        "{why}"
    );
    let never = ["render", "fence", "-o", "a.exr", "--time", "0.000000001"];
    let output = run(place.path(), &[&never[..], &SMALL].concat());
    assert_eq!(output.status.code(), Some(1));
    let unwritable = ["render", "fence", "-o", "no/a.exr", "--time", "0.000000001"];
    fails(
        place.path(),
        &[&unwritable[..], &SMALL].concat(),
        "no/a.exr",
    );
    let vacuum = [
        &[
            "render",
            "fence",
            "-o",
            "a.exr",
            "--error",
            "1%",
            "--sigma-s",
            "0",
        ][..],
        &SMALL,
    ]
    .concat();
    fails(place.path(), &vacuum, "nothing to choose");
}

/// The channels of the fog of an EXR file with layers.
fn fog(path: &Path) -> Vec<f64> {
    let image = exr::prelude::read_all_flat_layers_from_file(path).unwrap();
    let list = image.layer_data[0].channel_data.list.iter();
    let all: BTreeMap<String, Vec<f32>> = list
        .map(|channel| {
            (
                channel.name.to_string(),
                channel.sample_data.values_as_f32().collect(),
            )
        })
        .collect();
    ["fog.R", "fog.G", "fog.B"]
        .iter()
        .flat_map(|name| all[*name].iter().map(|x| f64::from(*x)))
        .collect()
}

#[test]
fn a_picture_is_about_as_far_off_as_was_asked_for() {
    let place = tempfile::tempdir().unwrap();
    for scene in ["fence", "coil"] {
        let render = |file: &str, options: &[&str]| {
            let common = ["render", scene, "--size", "192x108", "--layers", "-o", file];
            let said = notes(place.path(), &[&common[..], options].concat());
            (fog(&place.path().join(file)), said)
        };
        let (truth, _) = render("truth.exr", &[]);
        let mean = truth.iter().sum::<f64>() / truth.len() as f64;
        let target = 0.05;
        let (found, said) = render("chosen.exr", &["--error", &target.to_string()]);
        let squares: f64 = found.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum();
        let error = (squares / truth.len() as f64).sqrt() / mean;
        assert!(error <= 1.5 * target, "{scene}: {error}: {said}");
        assert!(said.contains("note: for an error of"), "{said}");
    }
}

#[test]
fn a_comparison_of_what_is_worth_it_keeps_the_baseline() {
    let place = tempfile::tempdir().unwrap();
    let all = [
        "compare",
        "fence",
        "--auto",
        "--methods",
        "march x midpoint,slices,hybrid x gauss",
        "--plan",
        "--backend",
        "cpu",
        "--size",
        "64x36",
        "--map",
        "128",
    ];
    let text = succeeds(place.path(), &all);
    // What others are compared with stays, whatever the times are.
    let marches = text
        .lines()
        .find(|line| line.starts_with("runs: ray marching"));
    assert!(marches.unwrap().contains("8, "), "{text}");
}

/// A picture of `fence` on the backend that is left open, on a machine with this list of starts
/// and these costs of a march: the file, and what is said about it.
fn left_open(options: &[&str], starts: &Value, on_gpu: &str) -> (Vec<u8>, String) {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("cache/crepuscular");
    std::fs::create_dir_all(&folder).unwrap();
    let costs = |backend: &str, seconds: f64| {
        json!({
            "backend": backend,
            "method": "march x midpoint",
            "seconds_once_per_unit": seconds,
            "seconds_frame_per_unit": seconds,
        })
    };
    let profile = json!({
        "format": "crepuscular machine profile",
        "version": 1,
        "methods": [costs("cpu", 1e-8), costs(on_gpu, 1e-12)],
        "starts": starts,
    });
    std::fs::write(folder.join("profile.json"), profile.to_string()).unwrap();
    let common = [
        "render", "fence", "--size", "64x36", "--map", "128", "-o", "a.exr",
    ];
    let output = Command::new(env!("CARGO_BIN_EXE_crepuscular"))
        .current_dir(place.path())
        .env("XDG_CACHE_HOME", place.path().join("cache"))
        .args([&common[..], options].concat())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    (std::fs::read(place.path().join("a.exr")).unwrap(), said)
}

const MARCH: [&str; 4] = ["--method", "march x midpoint", "--backend", "auto"];

#[test]
fn a_gpu_that_starts_for_longer_than_a_picture_takes_stays_off() {
    let slow = json!([{"backend": "gpu (slow)", "seconds": 100}]);
    let on_cpu = ["--method", "march x midpoint", "--backend", "cpu"];
    let (expected, _) = left_open(&on_cpu, &slow, "gpu (slow)");
    let (same, said) = left_open(&MARCH, &slow, "gpu (slow)");
    assert!(
        said.contains("left out: gpu (slow) (starting it takes 100 s, and all of the picture "),
        "{said}"
    );
    assert!(said.contains("saves 100 s"), "{said}");
    assert_eq!(same, expected);
    let (same, said) = left_open(&MARCH, &json!([]), "gpu (slow)");
    assert!(said.contains("see plan --calibrate"), "{said}");
    assert_eq!(same, expected);
    for target in [["--error", "20%"], ["--time", "10s"]] {
        let options = [&target[..], &["--backend", "auto"]].concat();
        let (_, said) = left_open(&options, &slow, "gpu (slow)");
        assert!(
            said.contains("left out: gpu (slow) (starting it takes 100 s, and"),
            "{said}"
        );
        assert!(said.contains(" on cpu: "), "{said}");
    }
}

#[test]
fn a_gpu_that_pays_is_started() {
    let Some(context) = gpu("a_gpu_that_pays_is_started") else {
        return;
    };
    let software = if context.is_software() {
        ", software"
    } else {
        ""
    };
    let name = format!("gpu ({}{software})", context.adapter().name);
    let quick = json!([{"backend": &name, "seconds": 1e-9}]);
    let (_, said) = left_open(&MARCH, &quick, &name);
    assert!(
        said.contains(&format!("on {name}: expected after ")),
        "{said}"
    );
    // One that is gone is no reason to fail.
    let gone = json!([{"backend": "gpu (gone)", "seconds": 1e-9}]);
    let (_, said) = left_open(&MARCH, &gone, "gpu (gone)");
    assert!(
        said.contains("left out: gpu (gone) (it is not here)"),
        "{said}"
    );
}

//! What a user expects of any program: where text goes, names that are nearly right,
//! output for other programs.

use crate::common::{names, run, succeeds};
use serde_json::Value;

#[test]
fn notes_go_to_stderr_and_nowhere_if_nobody_wants_them() {
    let place = tempfile::tempdir().unwrap();
    for (more, lines) in [(&[][..], 1), (&["--quiet"], 0), (&["-q"], 0)] {
        let render = ["render", "fence", "--size", "8x8", "-o", "a.png"];
        let output = run(place.path(), &[&render[..], more].concat());
        assert!(output.status.success());
        let out = String::from_utf8(output.stdout).unwrap();
        let notes = String::from_utf8(output.stderr).unwrap();
        assert!(!out.contains("note:"), "{out}");
        assert_eq!(out.lines().count(), lines, "{out}");
        assert_eq!(notes.contains("note: exposure"), lines > 0, "{notes}");
        assert!(lines > 0 || notes.is_empty(), "{notes}");
    }
    // What was asked for comes nevertheless, and so do errors.
    assert!(succeeds(place.path(), &["--quiet", "methods"]).contains("HPG 2013"));
    let output = run(place.path(), &["-q", "render", "nowhere", "-o", "a.png"]);
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("error: "));
}

#[test]
fn names_that_are_nearly_right_are_suggested() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("bunny.ply"), "ply").unwrap();
    let render = |scene: &'static str, more: &[&'static str]| {
        [&["render", scene, "--size", "8x8", "-o", "a.png"], more].concat()
    };
    for (arguments, meant) in [
        (render("citty", &[]), "\"city\""),
        (render("buny.ply", &[]), "\"bunny.ply\""),
        (
            render("city", &["--method", "marhc x midpoint"]),
            "\"march x midpoint\"",
        ),
        (render("city", &["--visibility", "exat"]), "'exact'"),
        (render("city", &["--bakend", "cpu"]), "'--backend'"),
        (vec!["rendr", "city"], "'render'"),
        (vec!["man", "bke"], "\"bake\""),
        (
            vec!["bake", "city", "--light", "dircetional", "-o", "a"],
            "\"directional\"",
        ),
    ] {
        let output = run(place.path(), &arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(meant), "{arguments:?}: {message}");
    }
    assert_eq!(names(place.path()), ["bunny.ply"]);
}

#[test]
fn lists_and_files_are_told_as_json() {
    let place = tempfile::tempdir().unwrap();
    let json = |arguments: &[&str]| -> Value {
        serde_json::from_str(&succeeds(place.path(), arguments)).unwrap()
    };
    let methods = json(&["methods", "--json"]);
    let find = |list: &str, name: &str| {
        let list = methods[list].as_array().unwrap();
        list.iter().find(|one| one["name"] == name).unwrap().clone()
    };
    let march = find("methods", "march x midpoint");
    assert_eq!(march["role"], "baseline");
    assert!(march["qualities"].as_array().unwrap().len() > 1);
    find("visibilities", "exact");
    find("evaluators", "quadrature");

    let scenes = json(&["scenes", "--map", "64", "--json"]);
    let city = &scenes["scenes"][0];
    assert_eq!(city["name"], "city");
    assert!(city["lights"][0]["triangles"].as_u64().unwrap() > 100);

    let bake = ["bake", "coil", "--resolution", "64", "-o", "a.cpvs"];
    succeeds(place.path(), &bake);
    let file = json(&["inspect", "a.cpvs", "--json"]);
    let size = std::fs::metadata(place.path().join("a.cpvs"))
        .unwrap()
        .len();
    assert_eq!(file["bytes"], size);
    assert_eq!(file["grids"].as_array().unwrap().len(), 6);
    let grid = &file["grids"][0];
    assert_eq!(
        (&grid["side"], &grid["light"]["kind"]),
        (&64.into(), &"point".into())
    );
    let levels = grid["levels"].as_array().unwrap();
    assert!(levels.iter().any(|level| level["side"] == 8), "{levels:?}");
}

#[test]
fn shells_and_man_know_every_command() {
    let place = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = succeeds(place.path(), &["completions", shell]);
        for known in ["compare", "inspect", "visibility"] {
            assert!(script.contains(known), "{shell}: {known}");
        }
        let knows_values = ["bash", "zsh", "fish"].contains(&shell);
        assert!(!knows_values || script.contains("equi-angular"), "{shell}");
    }
    let page = succeeds(place.path(), &["man"]);
    assert!(page.contains(".TH crepuscular 1") && page.contains("compare"));
    let page = succeeds(place.path(), &["man", "bake"]);
    assert!(page.contains(".TH crepuscular-bake 1"), "{page}");
    assert!(page.contains("resolution"), "{page}");
}

#[cfg(target_os = "linux")]
#[test]
fn what_never_ends_is_not_read() {
    let place = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("/dev/zero", place.path().join("a.exr")).unwrap();
    let render = |more: &[&'static str]| {
        [&["render", "fence", "--size", "8x8", "-o", "b.png"], more].concat()
    };
    for arguments in [
        vec!["inspect", "/dev/zero"],
        vec!["render", "/dev/zero", "-o", "b.png"],
        render(&["--shadows", "/dev/zero"]),
        render(&["--environment", "a.exr"]),
    ] {
        let output = run(place.path(), &arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains("regular file"), "{arguments:?}: {message}");
    }
    assert_eq!(names(place.path()), ["a.exr"]);
}

#[test]
fn drivers_have_no_say_on_stderr() {
    let place = tempfile::tempdir().unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_crepuscular"))
        .current_dir(place.path())
        .args(["compare", "fence", "--quick", "--plan"])
        .env_remove("XDG_RUNTIME_DIR")
        .env_remove("REQUIRE_GPU")
        .output()
        .unwrap();
    assert!(output.status.success());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    // If there is no GPU, that is said, by the program.
    let chatter = message
        .lines()
        .find(|line| !line.starts_with("gpu: skipped"));
    assert_eq!(chatter, None, "{message}");
}

//! What the commands write when nothing is wrong.

use std::process::Command;

use crate::common::{names, notes, run, succeeds};

const SMALL: [&str; 9] = [
    "--quick",
    "--size",
    "40x24",
    "--map",
    "128",
    "--time-budget",
    "600",
    "--backend",
    "cpu",
];

/// Methods are compared without the studies.
const NO_STUDY: [&str; 2] = ["--studies", "none"];

#[test]
fn a_scene_of_smoke_and_hair_is_compared_with_what_they_let_through() {
    let place = tempfile::tempdir().unwrap();
    succeeds(
        place.path(),
        &[
            &["compare", "translucent", "--methods", "translucent,none"][..],
            &["--smoke-unseen", "--studies", "curves"],
            &SMALL,
        ]
        .concat(),
    );
    let report = place.path().join("crepuscular-report");
    let csv = std::fs::read_to_string(report.join("results.csv")).unwrap();
    let error = |visibility: &str| {
        let rows = csv.lines().filter(|row| row.contains(visibility));
        let errors = rows.map(|row| row.split(',').nth(6).unwrap().parse::<f64>().unwrap());
        errors.fold(f64::INFINITY, f64::min)
    };
    let (with, without) = (error(",translucent,"), error(",none,"));
    assert!(with < 0.05 && without > 0.2, "{with} {without}");
    let study = |name: &str| std::fs::read_to_string(report.join(name)).unwrap();
    let curves = study("curves.csv");
    assert!(curves.contains("1500 strands") && curves.contains("600 particles"));
    // Nobody asked for this one.
    assert_eq!(study("hair.csv").lines().count(), 1);
}

#[test]
fn smoke_that_is_seen_is_compared_by_the_methods_that_see_it() {
    let place = tempfile::tempdir().unwrap();
    let plan = succeeds(
        place.path(),
        &["compare", "smoke-columns", "--plan", "--backend", "cpu"],
    );
    assert!(
        plan.contains("fog that thins out by e every 0.9 m and smoke"),
        "{plan}"
    );
    assert!(plan.contains("runs: reference: exact visibility × quadrature through the media"));
    assert!(!plan.contains("runs: ray marching"), "{plan}");
    let left_out = plan
        .lines()
        .find(|line| line.contains("(march x midpoint)"));
    assert!(left_out.unwrap().contains("--smoke-unseen"), "{plan}");

    let text = succeeds(
        place.path(),
        &[
            &[
                "compare",
                "smoke-columns",
                "--methods",
                "media-area-8,media-unshadowed,double",
            ][..],
            &SMALL,
            &NO_STUDY,
        ]
        .concat(),
    );
    assert!(
        text.contains("Without shadows the error would be"),
        "{text}"
    );
    let report = place.path().join("crepuscular-report");
    let csv = std::fs::read_to_string(report.join("results.csv")).unwrap();
    let error = |method: &str| {
        let rows = csv.lines().filter(|row| row.contains(method));
        let errors = rows.map(|row| row.split(',').nth(6).unwrap().parse::<f64>().unwrap());
        errors.fold(f64::INFINITY, f64::min)
    };
    let (with, without) = (error("media-area-8"), error("media-unshadowed"));
    assert!(with < 0.05 && without > 0.2, "{with} {without}");
    assert!(error("media-double-march") > with);
    let page = std::fs::read_to_string(report.join("index.html")).unwrap();
    assert!(page.contains("differ by less than 0.5 % per pixel"));
}

#[test]
fn a_quality_alone_is_that_of_the_method_that_sees_smoke() {
    let place = tempfile::tempdir().unwrap();
    let text = succeeds(
        place.path(),
        &[
            &["render", "smoke-columns", "--size", "16x9", "--map", "64"][..],
            &["--quality", "8", "-o", "smoke.png"],
        ]
        .concat(),
    );
    assert!(text.contains("media-exact-area-8 with 8 steps"), "{text}");
}

#[test]
fn smoke_and_hair_of_other_files_stand_in_any_scene() {
    let place = tempfile::tempdir().unwrap();
    // Two cubes of a metre: 8 per metre on the right.
    let mut vol = b"VOL\x03".to_vec();
    for word in [1_u32, 2, 1, 1, 1] {
        vol.extend(word.to_le_bytes());
    }
    for number in [0.0_f32, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 8.0] {
        vol.extend(number.to_le_bytes());
    }
    std::fs::write(place.path().join("puff.vol"), vol).unwrap();
    let plan = |options: &[&str]| {
        let all = [
            &["compare", "coil", "--plan", "--backend", "cpu"][..],
            options,
        ]
        .concat();
        run(place.path(), &all)
    };
    let with = plan(&[
        "--smoke",
        "puff.vol@-0.5,1,0,0.5",
        "--smoke",
        "puff.vol",
        "--smoke-emission",
        "puff.vol@5,2,1",
    ]);
    let text = String::from_utf8_lossy(&with.stdout).into_owned();
    assert!(
        with.status.success() && text.contains("and smoke"),
        "{text}"
    );
    assert_eq!(
        text.matches("a density grid of 2 x 1 x 1").count(),
        2,
        "{text}"
    );
    for (options, why) in [
        (&["--smoke", "none.vol"][..], "there is no such file"),
        (&["--hair", "puff.vol"], "there is no hair in it"),
        (&["--smoke", "puff.vol@1,2"], "X,Y,Z"),
        (&["--smoke-emission", "puff.vol"], "more --smoke-emission"),
        (
            &["--smoke", "puff.vol", "--smoke-emission", "2"],
            "smoke that emits",
        ),
        (
            &["--smoke", "puff.vol", "--smoke-emission", "none.vol@2"],
            "none.vol",
        ),
        (
            &["--smoke", "puff.vol", "--smoke-albedo", "puff.vol"],
            "albedo",
        ),
        (&["--smoke", "puff.vol@nan,0,0"], "expected finite numbers"),
        (&["--smoke", "puff.vol@1,2,z"], "a place after an @ is"),
    ] {
        let failed = plan(options);
        let text = String::from_utf8_lossy(&failed.stderr).into_owned();
        assert!(!failed.status.success() && text.contains(why), "{text}");
    }
}

#[test]
fn a_quick_comparison_writes_a_report_that_needs_nothing_else() {
    let place = tempfile::tempdir().unwrap();
    let text = succeeds(place.path(), &[&["compare", "fence"][..], &SMALL].concat());
    assert!(text.contains("crepuscular-report"), "{text}");
    assert_eq!(names(place.path()), ["crepuscular-report"]);
    let report = place.path().join("crepuscular-report");
    let is_airlight = |name: &String| name.starts_with("airlight-");
    let (pictures, others): (Vec<_>, Vec<_>) = names(&report).into_iter().partition(is_airlight);
    assert_eq!(
        others,
        [
            "airlight.csv",
            "area-lights.csv",
            "curves.csv",
            "hair.csv",
            "index.html",
            "many-lights.csv",
            "marching.csv",
            "precomputed-voxelized-shadows.csv",
            "results.csv",
            "shadowed-lights.csv",
            "surfaces.exr",
            "voxels.csv"
        ]
    );
    assert!(pictures.contains(&"airlight-reference.exr".to_owned()));
    assert!(pictures.contains(&"airlight-march-x-midpoint-32-cpu.exr".to_owned()));

    let csv = std::fs::read_to_string(report.join("results.csv")).unwrap();
    let mut lines = csv.lines();
    assert_eq!(
        lines.next(),
        Some(
            "scene,light,visibility,airlight,backend,quality,error_rmse,error_max,error_rel_p99,\
             seconds_build,seconds_frame,bytes,quality_unit,width,height,map,map_refined,error_map,\
             error_relmse,error_flip,repetitions,seconds_frame_min,seconds_frame_max"
        )
    );
    let mut pairs = Vec::new();
    for line in lines {
        let columns: Vec<&str> = line.split(',').collect();
        assert_eq!(columns.len(), 23, "{line}");
        pairs.push(format!("{} x {}", columns[2], columns[3]));
        let number = |column: usize| -> f64 { columns[column].parse().unwrap() };
        let has_map = !columns[15].is_empty();
        for (column, text) in columns.iter().enumerate().skip(5) {
            // Its unit; and what only shadow maps have.
            if column == 12 || [15, 17].contains(&column) && !has_map {
                continue;
            }
            let value: f64 = text.parse().unwrap();
            assert!(value.is_finite() && value >= 0.0, "{line}");
        }
        assert!(number(10) > 0.0, "{line}");
        assert_eq!((number(13), number(14)), (40.0, 24.0), "{line}");
        assert!(
            number(21) <= number(10) && number(10) <= number(22),
            "{line}"
        );
        assert!(number(20) >= 1.0, "{line}");
        assert_eq!(
            has_map,
            !["none", "exact", "precomputed"].contains(&columns[2])
        );
        assert!(
            !has_map || number(15) == 128.0 && number(17) > 0.0,
            "{line}"
        );
    }
    pairs.dedup();
    // One of each method, and what they are compared with.
    assert_eq!(pictures.len(), pairs.len() + 1, "{pictures:?}");
    assert_eq!(
        pairs,
        [
            "none x gauss",
            "exact x gauss",
            "exact x quadrature",
            "exact x table",
            "exact x double",
            "march x midpoint",
            "march quarter x ",
            "march 2x2 x ",
            "march-merged x gauss-8",
            "march-merged x frame-table-128",
            "equi-angular x gauss-1",
            "equi-angular-merged x gauss-8",
            "equi-angular-merged x table-64",
            "slices x midpoint",
            "hybrid x gauss-8",
            "hybrid x quadrature-4",
            "hybrid x table-64",
            "hybrid-filtered x gauss-8",
            "variance x midpoint",
            "exponential-variance x midpoint",
            "moments-4 x midpoint",
            "moments-6 x midpoint",
            "map-runs x gauss",
            "map-runs x table",
            "epipolar-sampling x ",
            "light-volumes x gauss-8",
            "light-volumes x table-64",
            "froxels x ",
            "froxels-engine x ",
            "froxels-history x ",
            "voxel-average x gauss-8",
            "per-voxel x gauss-1",
            "voxel-runs x gauss-8",
            "voxel-runs x table-64",
            "precomputed x gauss-8",
            "precomputed x table-64"
        ]
    );

    let html = std::fs::read_to_string(report.join("index.html")).unwrap();
    for absent in ["http://", "https://", "<script ", "NaN", ">inf"] {
        assert!(!html.contains(absent), "{absent}");
    }
    for present in [
        "<svg",
        "data:image/png;base64,",
        "Left out",
        "Error against the time of a frame",
    ] {
        assert!(html.contains(present), "{present}");
    }

    // A second run replaces the first.
    succeeds(
        place.path(),
        &[&["compare", "fence"][..], &SMALL, &NO_STUDY].concat(),
    );
    assert_eq!(names(place.path()), ["crepuscular-report"]);
}

#[test]
fn more_quality_is_less_error() {
    let place = tempfile::tempdir().unwrap();
    succeeds(
        place.path(),
        &[&["compare", "coil"][..], &SMALL, &NO_STUDY].concat(),
    );
    let csv = std::fs::read_to_string(place.path().join("crepuscular-report/results.csv")).unwrap();
    let error = |visibility: &str, quality: &str| -> f64 {
        let mut rows = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let row = rows
            .find(|c| c[2] == visibility && c[5] == quality)
            .unwrap();
        row[6].parse().unwrap()
    };
    assert!(error("exact", "8") < 1e-2);
    assert!(error("march", "128") < error("march", "8"));
    assert!(error("equi-angular", "128") < error("equi-angular", "8"));
    assert!(error("exact", "8") < error("march-merged", "128"));
}

#[test]
fn a_vacuum_is_reported_as_one() {
    let place = tempfile::tempdir().unwrap();
    let vacuum = ["--sigma-s", "0", "--sigma-a", "0"];
    let arguments = [&["compare", "fence"][..], &SMALL, &vacuum].concat();
    let output = run(place.path(), &arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("nothing was measured"), "{message}");
    assert!(message.contains("--sigma-s"), "{message}");
    let report = place.path().join("crepuscular-report");
    let html = std::fs::read_to_string(report.join("index.html")).unwrap();
    assert!(html.to_lowercase().contains("no medium"));
    let csv = std::fs::read_to_string(report.join("results.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1, "only the header");

    let plan = succeeds(place.path(), &[&arguments[..], &["--plan"]].concat());
    assert!(plan.contains("left out: airlight (no medium"), "{plan}");
}

#[test]
fn what_measures_nothing_for_want_of_time_says_so_and_returns_1() {
    let place = tempfile::tempdir().unwrap();
    let short = [
        "--quick",
        "--size",
        "16x9",
        "--backend",
        "cpu",
        "--time-budget",
        "1e-3",
    ];
    let output = run(place.path(), &[&["compare", "fence"][..], &short].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    for what in [
        "nothing was measured",
        "--time-budget",
        "--fixed",
        "index.html",
    ] {
        assert!(message.contains(what), "{message}");
    }
    assert!(place.path().join("crepuscular-report/index.html").exists());
}

#[test]
fn a_plan_says_why_a_sun_is_not_sampled_by_angle() {
    let place = tempfile::tempdir().unwrap();
    let plan = succeeds(place.path(), &["compare", "city", "--quick", "--plan"]);
    assert!(plan.contains("no equi-angular variable"), "{plan}");
    assert!(
        plan.contains("runs: ray marching with 8, 32, 128 steps on cpu"),
        "{plan}"
    );
    assert!(
        plan.contains("runs: if precomputed, once for all frames, shadows of emitter 0"),
        "{plan}"
    );
    assert_eq!(
        names(place.path()),
        Vec::<String>::new(),
        "nothing is written"
    );
}

#[test]
fn a_mesh_without_anything_else_is_lit_and_filled_and_said_so() {
    let place = tempfile::tempdir().unwrap();
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    std::fs::write(place.path().join("a.ply"), ply).unwrap();
    let common = ["a.ply", "--size", "32x18", "-o"];
    let text = notes(
        place.path(),
        &[&["render"][..], &common, &["a.png"]].concat(),
    );
    for what in ["no camera", "no light", "no floor", "no medium"] {
        assert!(text.contains(what), "{text}");
    }
    let marched = ["a.exr", "--visibility", "equi-angular", "--samples", "16"];
    succeeds(place.path(), &[&["render"][..], &common, &marched].concat());
    assert_eq!(names(place.path()), ["a.exr", "a.ply", "a.png"]);
    let start = |name: &str| std::fs::read(place.path().join(name)).unwrap()[..4].to_vec();
    assert_eq!(start("a.png"), b"\x89PNG");
    assert_eq!(start("a.exr"), [0x76, 0x2f, 0x31, 0x01]);
}

#[test]
fn lists_name_everything() {
    let place = tempfile::tempdir().unwrap();
    let methods = succeeds(place.path(), &["methods"]);
    assert!(methods.contains("equi-angular x gauss-1") && methods.contains("HPG 2013"));
    let scenes = succeeds(place.path(), &["scenes", "--map", "64"]);
    for name in [
        "city",
        "landscape",
        "hairball",
        "smoke",
        "stiff",
        "smoke-room",
        "traffic",
    ] {
        assert!(
            scenes.lines().any(|line| line.starts_with(name)),
            "{scenes}"
        );
    }
    assert!(scenes.contains("solids"), "{scenes}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_reader_that_goes_away_is_no_failure_and_a_full_disk_is_one() {
    use std::fs::File;
    use std::process::Stdio;

    let place = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str], out: Stdio| {
        let output = Command::new(env!("CARGO_BIN_EXE_crepuscular"))
            .current_dir(place.path())
            .args(arguments)
            .stdout(out)
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        let lines = message.lines().filter(|line| !line.starts_with("note: "));
        (output.status.code(), lines.collect::<Vec<_>>().join("\n"))
    };
    let plan = ["compare", "fence", "--quick", "--plan", "--backend", "cpu"];
    let render = ["render", "fence", "--size", "8x8", "-o", "a.png"];
    for arguments in [&["methods"][..], &["--help"], &["man"], &plan, &render] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let (code, message) = run(arguments, writer.into());
        assert_eq!((code, message.as_str()), (Some(0), ""), "{arguments:?}");
        let full = File::options().write(true).open("/dev/full").unwrap();
        let (code, message) = run(arguments, full.into());
        assert_eq!(code, Some(2), "{arguments:?}: {message}");
        assert!(message.contains("standard output"), "{message}");
    }
}

#[test]
fn a_pair_is_accepted_as_it_is_listed() {
    let place = tempfile::tempdir().unwrap();
    let only = ["compare", "fence", "--quick", "--plan", "--methods"];
    for pair in ["march × midpoint", "march x midpoint"] {
        let plan = succeeds(place.path(), &[&only[..], &[pair]].concat());
        assert!(plan.contains("runs: ray marching with"), "{plan}");
    }
}

#[test]
fn methods_that_the_scene_rules_out_do_not_cost_an_earlier_report() {
    let place = tempfile::tempdir().unwrap();
    let only = |names: &'static str| {
        let names = ["--methods", names];
        [&["compare", "city"][..], &SMALL, &NO_STUDY, &names].concat()
    };
    succeeds(place.path(), &only("none"));
    let page = place.path().join("crepuscular-report/index.html");
    let before = std::fs::read(&page).unwrap();
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_crepuscular"))
            .current_dir(place.path())
            .args(arguments)
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), message)
    };
    let (code, message) = run(&only("equi-angular"));
    assert_eq!(code, Some(2), "{message}");
    assert!(message.contains("no equi-angular variable"), "{message}");
    assert_eq!(std::fs::read(&page).unwrap(), before);
    let (code, message) = run(&only("none,equi-angular"));
    assert_eq!(code, Some(0), "{message}");
    assert!(message.starts_with("warning: "), "{message}");
}

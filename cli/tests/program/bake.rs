//! Precomputed shadows from the command line: whole, interrupted, damaged.

use std::process::Output;

use crate::common::{fails, names, notes, run, succeeds};

#[test]
fn a_bake_is_one_file_that_inspect_understands() {
    let place = tempfile::tempdir().unwrap();
    let bake = |out: &str, more: &[&str]| {
        let arguments = ["bake", "city", "--resolution", "1024", "-o", out];
        succeeds(place.path(), &[&arguments, more].concat())
    };
    let text = bake("a.cpvs", &[]);
    assert!(text.contains("1 grid of 1024³ voxels"), "{text}");
    bake("b.cpvs", &["--light", "sun", "--form", "plain"]);
    bake("c.cpvs", &["--light", "0"]);
    assert_eq!(names(place.path()), ["a.cpvs", "b.cpvs", "c.cpvs"]);
    let read = |name: &str| std::fs::read(place.path().join(name)).unwrap();
    assert_eq!(read("a.cpvs"), read("c.cpvs"));
    assert!(2 * read("a.cpvs").len() < read("b.cpvs").len());
    bake("d.cpvs", &["--form", "compressed"]);
    assert!(read("d.cpvs").len() < read("a.cpvs").len());
    // What is said of the grids of a compressed file is of what they are decoded to.
    let inspected = |name, head: usize| {
        let text = succeeds(place.path(), &["inspect", name]);
        assert_eq!(
            text.contains(" compressed, sound\nthe following"),
            head == 2
        );
        text.lines()
            .skip(head)
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    assert_eq!(inspected("d.cpvs", 2), inspected("a.cpvs", 1));

    let text = succeeds(place.path(), &["inspect", "a.cpvs"]);
    for what in [
        "1024³",
        "sound",
        "directional",
        "packed",
        "level of 8³",
        "level of 1024³",
    ] {
        assert!(text.contains(what), "{what}: {text}");
    }
    // A lamp inside of its scene has six grids.
    let arguments = ["bake", "coil", "--resolution", "128", "-o", "coil.cpvs"];
    succeeds(place.path(), &arguments);
    let text = succeeds(place.path(), &["inspect", "coil.cpvs"]);
    assert!(
        text.contains("6 grids") && text.contains("grid 5"),
        "{text}"
    );
}

#[test]
fn all_lights_are_one_file() {
    let place = tempfile::tempdir().unwrap();
    let bake = |out: &str, more: &[&str]| {
        let arguments = ["bake", "stiff", "--resolution", "256", "-o", out];
        succeeds(place.path(), &[&arguments, more].concat())
    };
    let text = bake("all.cpvs", &["--light", "all"]);
    assert!(text.contains("grids of 2 lights of 256³ voxels"), "{text}");
    bake("each.cpvs", &["--light", "0", "--light", "1"]);
    bake("one.cpvs", &["--light", "1", "--bias", "2.5"]);
    let read = |name: &str| std::fs::read(place.path().join(name)).unwrap();
    assert!(read("all.cpvs") == read("each.cpvs"));

    let inspect = |name: &str| -> serde_json::Value {
        let text = succeeds(place.path(), &["inspect", name, "--json"]);
        serde_json::from_str(&text).unwrap()
    };
    let (all, one) = (inspect("all.cpvs"), inspect("one.cpvs"));
    assert_eq!((&all["lights"], &one["lights"]), (&2.into(), &1.into()));
    let [first, second] = [0, 1].map(|light| &all["directory"][light]);
    assert_eq!(first["bytes"][1], second["bytes"][0]);
    assert_eq!(second["bytes"][1], read("all.cpvs").len());
    assert_eq!(second["first_grid"], first["grids"]);
    assert_eq!(
        (&first["bias"], &one["directory"][0]["bias"]),
        (&1.0.into(), &2.5.into())
    );
    let text = succeeds(place.path(), &["inspect", "all.cpvs"]);
    assert!(text.contains("light 1: grid"), "{text}");

    let picture = [
        "render",
        "stiff",
        "--size",
        "24x14",
        "--shadows",
        "all.cpvs",
        "-o",
        "a.png",
    ];
    let text = succeeds(place.path(), &picture);
    assert!(text.ends_with("precomputed shadows\n"), "{text}");

    // A light is as fine as what it shines on asks for.
    bake("coarse.cpvs", &["--light", "all", "--texel", "10m"]);
    let coarse = inspect("coarse.cpvs");
    for light in 0..2 {
        let side = &coarse["directory"][light]["side"];
        assert!((8..256).contains(&side.as_u64().unwrap()), "{side}");
    }
    bake("fine.cpvs", &["--light", "all", "--texel", "0.001mm"]);
    assert!(read("all.cpvs") == read("fine.cpvs"));
}

#[test]
fn parts_of_a_bake_are_merged_to_the_same_bytes() {
    let place = tempfile::tempdir().unwrap();
    let bake = |scene: &'static str, out: &'static str, more: &[&'static str]| {
        let arguments = [
            "bake",
            scene,
            "--light",
            "all",
            "--resolution",
            "256",
            "-o",
            out,
        ];
        succeeds(place.path(), &[&arguments, more].concat())
    };
    bake("stiff", "whole.cpvs", &[]);
    for (part, out) in [("1/3", "a"), ("2/3", "b"), ("3/3", "c"), ("2/4", "other")] {
        let text = bake("stiff", out, &["--part", part]);
        assert!(text.contains(&format!("part {part} of")), "{text}");
    }
    bake("fence", "fence", &["--part", "2/3"]);
    succeeds(place.path(), &["merge", "c", "a", "b", "-o", "merged.cpvs"]);
    let read = |name: &str| std::fs::read(place.path().join(name)).unwrap();
    assert!(read("merged.cpvs") == read("whole.cpvs"));
    bake("stiff", "small.cpvs", &["--form", "compressed"]);
    let small = ["merge", "a", "b", "c", "--form", "compressed", "-o", "d"];
    succeeds(place.path(), &small);
    assert!(read("d") == read("small.cpvs"));

    for (parts, cause) in [
        (&["a", "c"][..], "1 of 3 parts missing: 2"),
        (&["a", "b", "c", "b"], "b and b are both part 2/3"),
        (&["a", "other", "c"], "of another bake"),
        (&["a", "fence", "c"], "of another bake"),
        (&["a", "whole.cpvs"], "whole.cpvs: not a checkpoint"),
        (&["a", "nowhere"], "nowhere"),
    ] {
        let arguments = [&["merge"], parts, &["-o", "out.cpvs"]].concat();
        fails(place.path(), &arguments, cause);
    }
    fails(place.path(), &["inspect", "a"], "merge its parts");
    let replacing = ["merge", "a", "b", "c", "-o", "a"];
    fails(place.path(), &replacing, "would replace what is read");
}

#[test]
fn holes_are_reported() {
    let place = tempfile::tempdir().unwrap();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    std::fs::write(place.path().join("a.ply"), ply).unwrap();
    let arguments = ["bake", "a.ply", "--resolution", "64", "-o", "a.cpvs"];
    let text = notes(place.path(), &arguments);
    assert!(
        text.contains("1 of 1 part have holes (3 open edges)"),
        "{text}"
    );
}

#[test]
fn what_is_wrong_with_a_bake_is_said_before_it_begins() {
    let place = tempfile::tempdir().unwrap();
    let bake = |scene: &'static str, more: &[&'static str]| {
        [&["bake", scene, "-o", "a.cpvs"], more].concat()
    };
    for (more, cause) in [
        (&["--resolution", "1000"][..], "power of two"),
        (&["--resolution", "4"], "power of two"),
        (&["--resolution", "2097152"], "power of two"),
        (&["--resolution", "-8"], "--resolution"),
        (&["--light", "1"], "the lights are 0 directional"),
        (&["--light", "spot"], "there is no such light"),
        (&["--light", "-1"], "--light"),
        (&["--light", "0", "--light", "sun"], "given twice"),
        (&["--texel", "0cm"], "--texel"),
        (&["--bias", "-1"], "--bias"),
        (&["--part", "4/3"], "--part"),
        (&["--part", "half"], "--part"),
        (&["--form", "round"], "round"),
    ] {
        fails(place.path(), &bake("city", more), cause);
    }
    fails(place.path(), &bake("area-light", &[]), "area light");
    fails(
        place.path(),
        &bake("area-light", &["--light", "all"]),
        "no lights to bake",
    );
    fails(place.path(), &bake("stiff", &[]), "choose one or all");
    fails(
        place.path(),
        &bake("stiff", &["--light", "point"]),
        "there are 2 of them",
    );
    fails(place.path(), &bake("nowhere.glb", &[]), "nowhere.glb");
    let nowhere = ["bake", "city", "-o", "no/a.cpvs"];
    fails(place.path(), &nowhere, "its folder does not exist");
}

#[test]
fn pictures_take_their_shadows_from_files_of_their_own_lights() {
    let place = tempfile::tempdir().unwrap();
    let bake = |scene: &str, out: &str, more: &[&str]| {
        let arguments = ["bake", scene, "--resolution", "512", "-o", out];
        succeeds(place.path(), &[&arguments, more].concat());
    };
    bake("fence", "fence.cpvs", &[]);
    bake("stiff", "one.cpvs", &["--light", "1"]);
    let render = |scene: &str, more: &[&str]| {
        let arguments = ["render", scene, "--size", "24x14"];
        run(place.path(), &[&arguments, more].concat())
    };
    let text = |output: Output| {
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let all = render("fence", &["--shadows", "fence.cpvs", "-o", "a.png"]);
    assert!(text(all).ends_with("precomputed shadows\n"));
    let some = [
        "--shadows",
        "one.cpvs",
        "--visibility",
        "march",
        "-o",
        "b.png",
    ];
    let some = text(render("stiff", &some));
    assert!(
        some.contains("precomputed shadows of 1 light, march"),
        "{some}"
    );
    let baked = [
        "--visibility",
        "precomputed",
        "--samples",
        "256",
        "-o",
        "c.png",
    ];
    let baked = text(render("fence", &baked));
    assert!(baked.contains("with 256 voxels per axis"), "{baked}");

    let picture = ["render", "fence", "--size", "24x14", "-o", "d.png"];
    for (more, cause) in [
        (&["--shadows", "one.cpvs"][..], "another scene or light"),
        (
            &["--seed", "2", "--shadows", "fence.cpvs"],
            "another scene or light",
        ),
        (&["--shadows", "no.cpvs"], "no.cpvs"),
        (&["--shadows", "a.png"], "not a file of shadows"),
        (&["--shadows", "fence.cpvs", "--filter", "2"], "odd"),
        (&["--shadows", "fence.cpvs", "--filter", "-3"], "--filter"),
        (
            &["--visibility", "precomputed", "--samples", "1000"],
            "power of two",
        ),
    ] {
        fails(place.path(), &[&picture, more].concat(), cause);
    }
}

#[test]
fn files_that_are_not_sound_are_not_read() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("a.cpvs");
    fails(place.path(), &["inspect", "a.cpvs"], "a.cpvs");
    succeeds(
        place.path(),
        &["bake", "fence", "--resolution", "64", "-o", "a.cpvs"],
    );
    let sound = std::fs::read(&path).unwrap();
    for (content, cause) in [
        (sound[..sound.len() / 2].to_vec(), "cut off"),
        (Vec::new(), "a.cpvs"),
        (b"CPVSCUBE".to_vec(), "cut off"),
        (b"not at all".to_vec(), "not a file of shadows"),
        ([&sound[..], b"!"].concat(), "expected"),
        (
            {
                let mut changed = sound.clone();
                let last = changed.len() - 1;
                changed[last / 2] ^= 1;
                changed
            },
            "grid",
        ),
    ] {
        std::fs::write(&path, content).unwrap();
        fails(place.path(), &["inspect", "a.cpvs"], cause);
    }
}

#[test]
fn a_checkpoint_is_of_its_own_bake_or_refused() {
    let place = tempfile::tempdir().unwrap();
    let part = place.path().join("a.cpvs.part");
    let resume = [
        "bake",
        "fence",
        "--resolution",
        "64",
        "-o",
        "a.cpvs",
        "--resume",
    ];
    std::fs::write(&part, b"CPVSGRID or so").unwrap();
    fails(place.path(), &resume, "a.cpvs.part");
    std::fs::write(&part, [&b"CPVSGRID"[..], &[0; 8], b"CPVSPART"].concat()).unwrap();
    fails(place.path(), &resume, "a.cpvs.part");
    std::fs::remove_file(&part).unwrap();
    let text = notes(place.path(), &resume);
    assert!(
        text.contains("there is no a.cpvs.part to continue from"),
        "{text}"
    );
    assert_eq!(names(place.path()), ["a.cpvs"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_bake_leaves_a_checkpoint_and_is_resumed_to_the_same_bytes() {
    use std::process::{Child, Command, Stdio};
    use std::time::Duration;

    let place = tempfile::tempdir().unwrap();
    let start = |arguments: &[&str]| -> Child {
        Command::new(env!("CARGO_BIN_EXE_crepuscular"))
            .current_dir(place.path())
            .args(arguments)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    // A machine that is done before it is interrupted gets more to do.
    let mut signals = [("-INT", 130), ("-TERM", 143)].iter().peekable();
    for resolution in ["2048", "8192", "32768", "131072"] {
        let Some((signal, code)) = signals.peek() else {
            return;
        };
        let bake = ["bake", "city", "--resolution", resolution, "-o", "a.cpvs"];
        let resume = [&bake[..], &["--resume"]].concat();
        let child = start(&bake);
        // It hears an interruption once it has begun its file, however long it takes
        // to get there.
        let has_begun = || {
            let names = names(place.path());
            names.iter().any(|name| name.starts_with(".crepuscular-"))
        };
        while !has_begun() {
            std::thread::sleep(Duration::from_millis(5));
        }
        let pid = child.id().to_string();
        Command::new("kill").args([signal, &*pid]).status().unwrap();
        let output = child.wait_with_output().unwrap();
        if output.status.success() {
            continue;
        }
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(*code), "{message}");
        assert!(
            message.contains("--resume continues from a.cpvs.part"),
            "{message}"
        );
        let left: Vec<String> = names(place.path());
        assert!(left.contains(&"a.cpvs.part".into()), "{left:?}");

        // Of another bake it is refused, and stays.
        let other = [
            "bake",
            "city",
            "--seed",
            "2",
            "--resolution",
            resolution,
            "-o",
            "a.cpvs",
            "--resume",
        ];
        fails(place.path(), &other, "a.cpvs.part");

        succeeds(place.path(), &resume);
        let whole = ["bake", "city", "--resolution", resolution, "-o", "b.cpvs"];
        succeeds(place.path(), &whole);
        let read = |name: &str| std::fs::read(place.path().join(name)).unwrap();
        assert!(read("a.cpvs") == read("b.cpvs"), "{resolution}");
        assert_eq!(names(place.path()), ["a.cpvs", "b.cpvs"]);
        std::fs::remove_file(place.path().join("a.cpvs")).unwrap();
        signals.next();
    }
    let heard = signals.next().is_none();
    assert!(
        heard,
        "the largest bake was done before it heard the signal"
    );
}

/// What moves is in no file, so that one file serves the scene wherever that has moved.
#[test]
fn a_file_of_what_stays_is_that_of_the_scene_with_and_without_what_moves() {
    let place = tempfile::tempdir().unwrap();
    let bake = |scene: &str, out: &str, more: &[&str]| {
        let arguments = ["bake", scene, "--resolution", "256", "-o", out];
        notes(place.path(), &[&arguments, more].concat())
    };
    assert!(!bake("city", "city.cpvs", &[]).contains("dynamic"));
    let noted = bake("traffic", "traffic.cpvs", &[]);
    assert!(noted.contains("dynamic triangles left out"), "{noted}");
    let read = |name: &str| std::fs::read(place.path().join(name)).unwrap();
    assert!(read("city.cpvs") == read("traffic.cpvs"));
    let noted = bake("city", "crowns.cpvs", &["--dynamic", "crown"]);
    assert!(noted.contains("dynamic triangles left out"), "{noted}");
    assert!(read("city.cpvs") != read("crowns.cpvs"));

    let render = |scene: &str, file: &str, out: &str, more: &[&str]| {
        let arguments = ["render", scene, "--size", "32x18"];
        let arguments = [&arguments, &["--shadows", file, "-o", out][..], more].concat();
        let noted = notes(place.path(), &arguments);
        (noted, read(out))
    };
    let (noted, moving) = render("traffic", "city.cpvs", "traffic.exr", &["--map", "128"]);
    assert!(
        noted.contains("dynamic triangles are those of shadow maps"),
        "{noted}"
    );
    let (_, crowns) = render("city", "crowns.cpvs", "crowns.exr", &["--dynamic", "crown"]);
    let (noted, city) = render("city", "city.cpvs", "city.exr", &[]);
    assert!(!noted.contains("dynamic"), "{noted}");
    assert!(moving != city && crowns != city);

    let refused = ["bake", "city", "-o", "none.cpvs", "--dynamic", "street"];
    fails(place.path(), &refused, "--dynamic street");
    let all = [
        "bake",
        "coil",
        "-o",
        "none.cpvs",
        "--dynamic",
        "coil",
        "--dynamic",
        "floor",
    ];
    fails(place.path(), &all, "all triangles are dynamic");
    // Nor is there anything to bake of the ground that a model is given.
    let triangle = "o kite\nv 0 1 0\nv 1 1 0\nv 0 2 1\nf 1 2 3\n";
    std::fs::write(place.path().join("kite.obj"), triangle).unwrap();
    let kite = ["bake", "kite.obj", "-o", "none.cpvs", "--dynamic", "kite"];
    fails(place.path(), &kite, "all triangles are dynamic");
    let kite = ["render", "kite.obj", "-o", "none.exr", "--dynamic", "kite"];
    let kite = [&kite[..], &["--size", "8x8", "--shadows", "city.cpvs"]].concat();
    fails(place.path(), &kite, "all triangles are dynamic");

    let pair = |scene| {
        let arguments = [
            "render", scene, "--size", "8x8", "--map", "64", "-o", "pair.exr",
        ];
        let method = [
            "--visibility",
            "precomputed",
            "--airlight",
            "gauss",
            "--samples",
            "64",
        ];
        [&arguments[..], &method].concat()
    };
    succeeds(place.path(), &pair("traffic"));
    std::fs::remove_file(place.path().join("pair.exr")).unwrap();
    fails(
        place.path(),
        &pair("city"),
        "--map is the size of shadow maps",
    );
}

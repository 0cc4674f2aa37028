//! Where results go: files, links, pipes, devices; and what a signal leaves behind.

use std::fs;
use std::os::unix::fs::{FileTypeExt, symlink};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::common::{fails, names, notes, run, succeeds};

const BAKE: [&str; 5] = ["bake", "fence", "--resolution", "64", "-o"];

#[cfg(target_os = "linux")]
#[test]
fn a_device_is_written_into_and_stays_what_it_is() {
    let place = tempfile::tempdir().unwrap();
    let device = |name: &str| fs::metadata(name).unwrap().file_type().is_char_device();
    let output = run(place.path(), &[&BAKE[..], &["/dev/full"]].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("/dev/full: No space left"), "{message}");
    assert!(device("/dev/full") && !Path::new("/dev/full.part").exists());

    succeeds(place.path(), &[&BAKE[..], &["/dev/null"]].concat());
    assert!(device("/dev/null") && !Path::new("/dev/null.part").exists());
    let resumed = [&BAKE[..], &["/dev/null", "--resume"]].concat();
    assert!(notes(place.path(), &resumed).contains("nothing to continue from"));

    // Whatever a name leads to.
    symlink("/dev/full", place.path().join("a.png")).unwrap();
    let render = ["render", "fence", "--size", "8x8", "-o", "a.png"];
    let output = run(place.path(), &render);
    assert_eq!(output.status.code(), Some(2));
    assert!(device("/dev/full") && place.path().join("a.png").is_symlink());
}

#[test]
fn a_pipe_passes_on_what_a_file_would_hold() {
    let place = tempfile::tempdir().unwrap();
    succeeds(place.path(), &[&BAKE[..], &["a.cpvs"]].concat());
    let pipe = place.path().join("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || fs::read(pipe).unwrap()
    });
    succeeds(place.path(), &[&BAKE[..], &["pipe"]].concat());
    let passed = reader.join().unwrap();
    assert!(passed == fs::read(place.path().join("a.cpvs")).unwrap());
    assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
    assert_eq!(names(place.path()), ["a.cpvs", "pipe"]);
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_passes_on_nothing_else() {
    let place = tempfile::tempdir().unwrap();
    succeeds(place.path(), &[&BAKE[..], &["a.cpvs"]].concat());
    let output = run(place.path(), &[&BAKE[..], &["/dev/stdout"]].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}");
    assert!(output.stdout == fs::read(place.path().join("a.cpvs")).unwrap());
    assert!(message.contains("/dev/stdout: 6 grids"), "{message}");
}

#[test]
fn what_is_read_is_not_replaced() {
    let place = tempfile::tempdir().unwrap();
    let model = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    fs::write(place.path().join("a.ply"), model).unwrap();
    symlink("a.ply", place.path().join("b.ply")).unwrap();
    for output in ["a.ply", "./a.ply", "b.ply"] {
        let bake = ["bake", "a.ply", "--resolution", "64", "-o", output];
        fails(place.path(), &bake, "would replace what is read");
    }
    let environment = ["--environment", "sky.png", "--size", "8x8", "-o", "sky.png"];
    fs::write(place.path().join("sky.png"), "kept").unwrap();
    let render = [&["render", "fence"], &environment[..]].concat();
    fails(place.path(), &render, "would replace what is read");
    assert_eq!(
        fs::read_to_string(place.path().join("a.ply")).unwrap(),
        model
    );
    assert_eq!(
        fs::read_to_string(place.path().join("sky.png")).unwrap(),
        "kept"
    );
}

#[test]
fn a_link_leads_to_the_file_that_is_written() {
    let place = tempfile::tempdir().unwrap();
    fs::create_dir(place.path().join("deep")).unwrap();
    symlink("deep/real.cpvs", place.path().join("link.cpvs")).unwrap();
    for _ in 0..2 {
        succeeds(place.path(), &[&BAKE[..], &["link.cpvs"]].concat());
        assert!(place.path().join("link.cpvs").is_symlink());
        assert_eq!(names(place.path()), ["deep", "link.cpvs"]);
        assert_eq!(names(&place.path().join("deep")), ["real.cpvs"]);
    }
    succeeds(place.path(), &["inspect", "deep/real.cpvs"]);
}

fn start(place: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_crepuscular"))
        .current_dir(place)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

#[test]
fn a_signal_leaves_nothing_behind() {
    let place = tempfile::tempdir().unwrap();
    let end = |arguments: &[&str], signal: &str, code: i32| {
        let child = start(place.path(), arguments);
        // It has begun as soon as there is something to leave behind.
        while names(place.path()).is_empty() {
            std::thread::sleep(Duration::from_millis(2));
        }
        let pid = child.id().to_string();
        Command::new("kill").args([signal, &pid]).status().unwrap();
        let output = child.wait_with_output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        assert_eq!(names(place.path()), Vec::<String>::new(), "{arguments:?}");
    };
    // Both take minutes.
    let render = [
        "render",
        "city",
        "--size",
        "1920x1080",
        "--spp",
        "16",
        "-o",
        "a.png",
    ];
    let compare = [
        "compare",
        "city",
        "--time-budget",
        "600",
        "--backend",
        "cpu",
    ];
    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        end(&render, signal, code);
        end(&compare, signal, code);
    }
}

#[test]
fn what_a_process_was_told_to_ignore_does_not_end_it() {
    let place = tempfile::tempdir().unwrap();
    let program = env!("CARGO_BIN_EXE_crepuscular");
    let script = format!(
        "trap '' HUP; {program} bake city --resolution 4096 -o a.cpvs & \
         while ! ls .crepuscular-* >/dev/null 2>&1 && ! test -e a.cpvs; do sleep 0.01; done; \
         kill -HUP $!; wait $!"
    );
    let shell = Command::new("sh")
        .current_dir(place.path())
        .args(["-c", &script])
        .output();
    let output = shell.unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}");
    assert_eq!(names(place.path()), ["a.cpvs"]);
}

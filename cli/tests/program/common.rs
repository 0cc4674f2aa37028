//! The program as a user starts it.

use std::path::Path;
use std::process::{Command, Output};

/// Runs it in `place`, with an empty cache.
pub(crate) fn run(place: &Path, arguments: &[&str]) -> Output {
    let cache = tempfile::tempdir().unwrap();
    Command::new(env!("CARGO_BIN_EXE_crepuscular"))
        .current_dir(place)
        .env("XDG_CACHE_HOME", cache.path())
        .args(arguments)
        .output()
        .unwrap()
}

/// What it prints when nothing is wrong.
pub(crate) fn succeeds(place: &Path, arguments: &[&str]) -> String {
    let output = run(place, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {message}");
    String::from_utf8(output.stdout).unwrap()
}

/// What it notes beside that.
pub(crate) fn notes(place: &Path, arguments: &[&str]) -> String {
    let output = run(place, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {message}");
    message
}

/// Makes sure that it fails for this cause, says so in a few lines, and leaves nothing behind.
pub(crate) fn fails(place: &Path, arguments: &[&str], cause: &str) {
    let before = names(place);
    let output = run(place, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    let context = format!("{arguments:?}: {message}");
    assert_eq!(output.status.code(), Some(2), "{context}");
    let [said, cause] = [message.as_str(), cause].map(str::to_lowercase);
    assert!(said.contains(&cause), "{cause}: {context}");
    assert!(message.starts_with("error: "), "{context}");
    assert!(!message.contains("panicked"), "{context}");
    assert!(message.lines().count() <= 8, "{context}");
    assert_eq!(names(place), before, "{context}");
}

/// The names of all files in a folder.
pub(crate) fn names(place: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(place).unwrap();
    let mut names: Vec<_> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

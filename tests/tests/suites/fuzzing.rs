//! What fuzzing tries, over its seeds and a fixed number of damaged copies of them.
//!
//! `tests/scripts/fuzz.sh` goes on from there; see `tests/fuzz`.

#[path = "../../fuzz/src/lib.rs"]
pub mod fuzz;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use fuzz::TARGETS;
use reference::damage::{copies, damaged};
use reference::random::Random;

/// Runs a target over its seeds and `usual` copies, and says at which input it failed.
fn holds(name: &str, usual: usize) {
    let target = TARGETS.iter().find(|target| target.name == name);
    let target = target.expect("a target of this name");
    let seeds = (target.seeds)();
    let mut random = Random::new(1);
    let copies = (0..copies(usual)).map(|_| {
        let seed = random.below(seeds.len() as u32) as usize;
        damaged(&seeds[seed], &mut random)
    });
    for input in seeds.iter().cloned().chain(copies.collect::<Vec<_>>()) {
        if catch_unwind(AssertUnwindSafe(|| (target.run)(&input))).is_err() {
            panic!("{name} does not hold of {input:?}");
        }
    }
}

/// The folder of cargo-fuzz.
const FUZZ: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz");

/// The names of the files of targets.
fn target_files() -> Vec<String> {
    let entries = fs::read_dir(Path::new(FUZZ).join("fuzz_targets")).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let stem = |path: PathBuf| Some(path.file_stem()?.to_str()?.to_owned());
    paths.filter_map(stem).collect()
}

/// The names of the programs in the manifest.
fn target_programs() -> Vec<String> {
    let manifest = fs::read_to_string(Path::new(FUZZ).join("Cargo.toml")).expect("a manifest");
    let name = |program: &str| {
        Some(
            program
                .split_once("name = \"")?
                .1
                .split_once('"')?
                .0
                .to_owned(),
        )
    };
    manifest.split("[[bin]]").skip(1).filter_map(name).collect()
}

/// A test of each target, with the number of copies that takes a second or so.
macro_rules! targets_hold {
    ($($name:ident: $copies:literal),+ $(,)?) => {
        $(#[test]
        fn $name() {
            holds(stringify!($name), $copies);
        })+

        #[test]
        fn no_target_is_left_out() {
            let names: Vec<&str> = TARGETS.iter().map(|target| target.name).collect();
            assert_eq!(names, [$(stringify!($name)),+]);
            let [mut files, mut programs] = [target_files(), target_programs()];
            files.sort();
            programs.sort();
            assert_eq!(files, names);
            assert_eq!(programs, names);
        }
    };
}

targets_hold!(
    airlight: 3000,
    atlas: 900,
    curves: 2000,
    depths: 800,
    epipolar: 2000,
    plan: 300,
    precomputed: 1000,
    scene: 200,
);

//! What fuzzing tries: for each target a function that takes any bytes and panics if
//! something does not hold that must hold of all of them, and seeds to begin with.
//!
//! | target | what |
//! |---|---|
//! | [`airlight`] | tables and quadratures against the exact value |
//! | [`atlas`] | grids of voxelized shadows and atlases of them, against brute force |
//! | [`curves`] | transmittance of blockers in any order, against their product |
//! | [`depths`] | graphs of depth maps, against the depths |
//! | [`epipolar`] | coordinates there and back |
//! | [`plan`] | what a plan leaves out of a frame |
//! | [`precomputed`] | files of precomputed shadows |
//! | [`scene`] | scene files of every format, through to a tiny picture |
//!
//! The targets of cargo-fuzz are one line each, in `fuzz_targets`. The tests of the main
//! workspace run the same functions over the seeds and a fixed number of changes to them.

pub mod airlight;
pub mod atlas;
mod bytes;
pub mod curves;
pub mod depths;
pub mod epipolar;
mod frame;
pub mod plan;
pub mod precomputed;
pub mod scene;

use std::path::PathBuf;
use std::{env, fs, io};

pub use bytes::Bytes;

/// What is tried.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Its name.
    pub name: &'static str,
    /// Panics if something does not hold.
    pub run: fn(&[u8]),
    /// Inputs to begin with.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

/// A [`Target`] of the module of each name.
macro_rules! targets {
    ($($name:ident),+ $(,)?) => {
        /// All of them.
        pub const TARGETS: &[Target] = &[$(Target {
            name: stringify!($name),
            run: $name::run,
            seeds: $name::seeds,
        }),+];
    };
}

targets!(
    airlight,
    atlas,
    curves,
    depths,
    epipolar,
    plan,
    precomputed,
    scene,
);

/// Writes the seeds of a target into the folder that the environment variable `FUZZ_SEEDS`
/// names, if there is one: a target does so before it reads its corpus.
///
/// # Panics
/// If there is no such target, or the folder cannot be written.
pub fn write_seeds(name: &str) {
    let Some(folder) = env::var_os("FUZZ_SEEDS").map(PathBuf::from) else {
        return;
    };
    let target = TARGETS.iter().find(|target| target.name == name);
    let seeds = (target.expect("a target").seeds)();
    let write = || -> io::Result<()> {
        fs::create_dir_all(&folder)?;
        let mut seeds = seeds.iter().enumerate();
        seeds.try_for_each(|(i, seed)| fs::write(folder.join(format!("seed-{i:02}")), seed))
    };
    write().expect("a folder for seeds that can be written");
}

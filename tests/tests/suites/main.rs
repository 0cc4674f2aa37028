//! Suites that cross the borders of crates, on every backend: one program, because what they
//! share would otherwise be compiled anew for each.
//!
//! `cargo test --package=crepuscular-tests registry::` runs one of them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

mod agreement;
mod area;
mod casters;
mod culling;
mod devices;
mod dynamic;
mod evaluators;
// What is fuzzed is a library of its own elsewhere.
pub mod fuzzing;
mod house;
mod light_volumes;
mod map_runs;
mod march;
mod media;
mod methods;
mod patterns;
mod plan;
mod precomputed;
mod prediction;
mod registry;
mod surface_light;
mod translucent;
mod translucent_files;
mod voxels;

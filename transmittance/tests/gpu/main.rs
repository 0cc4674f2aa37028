//! Maps made and asked on a GPU, against the CPU and against the truth.

#![cfg(feature = "wgpu")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

mod candidates;
mod capture;
mod lookups;
mod made;
mod questions;
mod rules;
mod segments;
#[path = "../support/mod.rs"]
mod support;

//! Internal: not published. Suites that run on every backend.
//!
//! | module | what |
//! |---|---|
//! | [`frames`] | methods on test scenes |
//! | [`map_cases`] | rays past lights with shadow maps |
//! | [`suite`] | one test body for every backend |
//! | [`scenes`] | the embedded scenes as methods take them |
//!
//! The crate `reference` holds the truth that results are compared with.

pub mod frames;
pub mod map_cases;
pub mod scenes;
pub mod suite;

/// The workspace README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
pub struct Readme;

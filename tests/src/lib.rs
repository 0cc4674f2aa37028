//! Suites that run on every backend.
//!
//! | module | what |
//! |---|---|
//! | [`suite`] | one test body for every backend |
//! | [`scenes`] | the embedded scenes as methods take them |
//!
//! What judges the results is the crate `reference`.

pub mod scenes;
pub mod suite;

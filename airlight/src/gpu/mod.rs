//! Airlight on a GPU: parts for any shader.
//!
//! A part is WGSL text that holds only functions, structures and constants
//! whose names start with `air_`; concatenate those that are needed, in the
//! order of their numbers in this table, with a shader of one's own.
//!
//! | part | what | needs |
//! |---|---|---|
//! | [`PHASE`] | phase functions | |

mod phase;

pub use phase::PhaseRecord;

/// Phase functions: `air_phase`, `air_phase_from_foot`.
pub const PHASE: &str = include_str!("phase.wgsl");

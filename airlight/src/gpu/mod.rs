//! Airlight on a GPU: parts for any shader.
//!
//! A part is WGSL text that holds only functions, structures and constants
//! whose names start with `air_`; concatenate those that are needed, in the
//! order of their numbers in this table, with a shader of one's own.
//!
//! | part | what | needs |
//! |---|---|---|
//! | [`PHASE`] | phase functions | |
//! | [`SEGMENT`] | `air_Segment`, the shader's side of [`Segment`](crate::Segment) | |
//!
//! An evaluator with a shader implements [`WgslEvaluator`]; then a GPU has the
//! step [`EvaluateAirlight`](crate::EvaluateAirlight) for it. Endless segments
//! have the length `f32::MAX` there, because shaders may assume that there are
//! no infinities.

mod batch;
mod phase;

pub use batch::WgslEvaluator;
pub use phase::PhaseRecord;

/// Phase functions: `air_phase`, `air_phase_from_foot`.
pub const PHASE: &str = include_str!("phase.wgsl");
/// A segment, and the largest number.
pub const SEGMENT: &str = include_str!("segment.wgsl");

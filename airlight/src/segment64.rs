//! A part of an eye ray in double precision.

use crate::Segment;

/// A [`Segment`] in double precision: the same four lengths.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Segment64 {
    /// Way from the eye to the start of the part, at least 0; see [`Segment::x`]
    /// for less.
    pub x: f64,
    /// Position of the start behind the foot point of the light.
    pub s: f64,
    /// Distance between the light and the line of the ray, at least 0.
    pub h: f64,
    /// Length of the part, at least 0, may be infinite.
    pub length: f64,
}

impl From<Segment> for Segment64 {
    fn from(segment: Segment) -> Self {
        Self {
            x: segment.x.into(),
            s: segment.s.into(),
            h: segment.h.into(),
            length: segment.length.into(),
        }
    }
}

//! What adaptive curves are compared with, with the same interface.
//!
//! | method | memory per ray | error |
//! |---|---|---|
//! | [`Uncompressed`] | 8 bytes per end of a segment | rounding |
//! | [`DeepCurve`] | as many vertices as ε takes | at most ε |
//! | [`OpacityCurve`] | `4 N` bytes | grows with the range of depths |
//! | [`FourierCurve`] | `8 N` bytes | grows with the range, rings at steps |
//! | [`MomentCurve`] | 20, 28 or 36 bytes | within an interval that it knows |
//!
//! The last three need to know a [`Range`] of depths beforehand, and none of
//! these has a channel to spare: a map of three channels is three maps.

mod deep;
mod fourier;
mod moments;
mod opacity;
mod uncompressed;

pub use deep::{Deep, DeepCurve};
pub use fourier::FourierCurve;
pub use moments::{MomentCurve, Moments};
pub use opacity::OpacityCurve;
pub use uncompressed::{Captured, Uncompressed};

use crate::{BlockerSegment, Error};

/// Depths between which the blockers of a map lie.
///
/// What lies outside counts as being at the nearer end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    near: f32,
    far: f32,
}

impl Range {
    /// The depths from `near` to `far`.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless both are finite and `near < far`.
    pub fn new(near: f32, far: f32) -> Result<Self, Error> {
        let bad = |what, value: f32, expected| Error::BadValue {
            what,
            value: value.into(),
            expected,
        };
        if !near.is_finite() {
            return Err(bad("the near end of the range", near, "a finite depth"));
        }
        if !(far.is_finite() && near < far) {
            return Err(bad(
                "the far end of the range",
                far,
                "a finite depth behind the near end",
            ));
        }
        Ok(Self { near, far })
    }

    /// Its near end.
    pub fn near(&self) -> f32 {
        self.near
    }

    /// Its far end.
    pub fn far(&self) -> f32 {
        self.far
    }

    /// Where `depth` lies, from 0 to 1; 0 for NaN.
    fn share(&self, depth: f32) -> f64 {
        let (near, far) = (f64::from(self.near), f64::from(self.far));
        let share = (f64::from(depth) - near) / (far - near);
        if share > 0.0 { share.min(1.0) } else { 0.0 }
    }

    /// Where a segment lies, both ends from 0 to 1.
    fn shares(&self, segment: &BlockerSegment) -> [f64; 2] {
        [self.share(segment.entry()), self.share(segment.exit())]
    }
}

/// The optical depth at which a method with a fixed set of basis functions cuts
/// off a blocker: an opaque one would drown everything else in its own error.
/// `exp(−8) = 3e-4` is less than one step of an 8-bit picture.
const OPAQUE_ENOUGH: f32 = 8.0;

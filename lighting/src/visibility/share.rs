//! How much of a light arrives: one number, or one for each colour.

use std::fmt::Debug;
use std::ops::Mul;

use glam::Vec3;

use crate::Interval;

/// The share of a light that gets to a point, from 0 to 1: an `f32` where all
/// colours are blocked alike, a [`Vec3`] behind coloured glass or smoke.
///
/// A source says at compile time which of the two it yields. On a GPU the share
/// always has three channels.
pub trait Share: Copy + PartialEq + Debug + Send + Sync + Mul<Vec3, Output = Vec3> {
    /// Nothing is in the way.
    const ALL: Self;

    /// True if nothing gets through in any colour.
    fn is_dark(self) -> bool;

    /// The share of something that counts so many times.
    #[must_use]
    fn weighted(self, weight: f32) -> Self;
}

impl Share for f32 {
    const ALL: Self = 1.0;

    fn is_dark(self) -> bool {
        self <= 0.0
    }

    fn weighted(self, weight: f32) -> Self {
        weight * self
    }
}

impl Share for Vec3 {
    const ALL: Self = Vec3::ONE;

    fn is_dark(self) -> bool {
        self.max_element() <= 0.0
    }

    fn weighted(self, weight: f32) -> Self {
        weight * self
    }
}

/// What is left of a light behind two things that are in its way.
pub trait Behind<S: Share>: Share {
    /// One number if both are, else one for each colour.
    type Share: Share;

    /// The product of the two.
    fn behind(self, other: S) -> Self::Share;
}

impl Behind<f32> for f32 {
    type Share = f32;

    fn behind(self, other: f32) -> f32 {
        self * other
    }
}

impl Behind<Vec3> for f32 {
    type Share = Vec3;

    fn behind(self, other: Vec3) -> Vec3 {
        self * other
    }
}

impl<S: Share + Mul<Vec3, Output = Vec3>> Behind<S> for Vec3 {
    type Share = Vec3;

    fn behind(self, other: S) -> Vec3 {
        other * self
    }
}

/// A part of a ray that the light reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LitInterval<S = f32> {
    /// Which part.
    pub interval: Interval,
    /// Share of the light that gets there: 1 where nothing is in the way, less
    /// behind translucent blockers. Times the [weight](crate::Part::weight) of the part
    /// where rays share parts.
    pub visibility: S,
}

impl<S: Share> LitInterval<S> {
    /// A part that nothing hides from the light.
    pub const fn unshadowed(start: f32, end: f32) -> Self {
        Self {
            interval: Interval::new(start, end),
            visibility: S::ALL,
        }
    }
}

/// Joins the parts of `lit`, from `first` on, that touch and are equally visible.
///
/// A march yields one part per lit step, which is right for an evaluator that
/// takes one sample of each. An evaluator that is accurate over an interval of
/// any length does better with whole runs: fewer calls, and no error from the
/// number of steps but at the ends of the runs.
pub fn join_touching<S: Share>(lit: &mut Vec<LitInterval<S>>, first: usize) {
    let mut last = first;
    for next in first + 1..lit.len() {
        if lit[last].interval.end == lit[next].interval.start
            && lit[last].visibility == lit[next].visibility
        {
            lit[last].interval.end = lit[next].interval.end;
        } else {
            last += 1;
            lit[last] = lit[next];
        }
    }
    lit.truncate((last + 1).min(lit.len()));
}

//! The share of a light that arrives: one number, or one for each colour.

use std::fmt::Debug;
use std::ops::Mul;

use glam::Vec3;

use crate::Interval;

/// The share of a light that reaches a point, from 0 to 1: an `f32` where all colours are
/// blocked alike, a [`Vec3`] behind coloured glass or smoke.
///
/// A source says at compile time which of the two it yields. On a GPU a share always has three
/// channels.
pub trait Share: Copy + PartialEq + Debug + Send + Sync + Mul<Vec3, Output = Vec3> {
    /// The share where nothing blocks the light.
    const ALL: Self;

    /// True if nothing gets through in any colour.
    fn is_dark(self) -> bool;

    /// The share times a weight.
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

/// Shares that can be multiplied: of light that passes two blockers in turn.
pub trait Behind<S: Share>: Share {
    /// One number if both shares are, else one for each colour.
    type Share: Share;

    /// The product of the two shares.
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
    /// Where it begins and ends on the ray.
    pub interval: Interval,
    /// The share of the light that arrives there: 1 where nothing blocks it, less behind
    /// translucent blockers. Where rays share their parts, it is multiplied by the
    /// [weight](crate::Part::weight) of the part.
    pub visibility: S,
}

impl<S: Share> LitInterval<S> {
    /// A part that nothing blocks from the light.
    pub const fn unshadowed(start: f32, end: f32) -> Self {
        Self {
            interval: Interval::new(start, end),
            visibility: S::ALL,
        }
    }
}

/// Joins the parts of `lit`, from index `first` on, that touch and are equally visible.
///
/// A march yields one part per lit step, which is right for an evaluator that takes one sample
/// of each. An evaluator that is accurate over intervals of any length does better with whole
/// runs: it is called less often, and the number of steps causes errors only at the ends of the
/// runs.
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

//! All of a ray's segments, composed exactly.

use crate::numeric::exp_neg;
use crate::numeric::{fraction, mix};
use crate::{Accumulate, BlockerSegment, Evaluate};

/// Collects segments for an [`Uncompressed`] curve. Memory grows with them.
#[derive(Debug, Clone, Default)]
pub struct Captured {
    segments: Vec<BlockerSegment>,
}

impl Captured {
    /// A clear ray.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The sum of the optical depths: points of depth and value, ordered, at
    /// most two at a depth.
    ///
    /// Halves of the segments are summed first, so that each value is a sum of
    /// positive numbers without differences, rounded `log₂ n` times.
    pub(super) fn sum(&self) -> Vec<(f32, f64)> {
        fn sum(segments: &[BlockerSegment]) -> Vec<(f32, f64)> {
            match segments {
                [] => Vec::new(),
                [one] => vec![
                    (one.entry(), 0.0),
                    (one.exit(), f64::from(one.optical_depth()[0])),
                ],
                _ => {
                    let (a, b) = segments.split_at(segments.len() / 2);
                    add(&sum(a), &sum(b))
                }
            }
        }
        sum(&self.segments)
    }
}

/// The value that a curve has at `depth`, where `next` is the first of its
/// points that is not used up.
fn value_at(points: &[(f32, f64)], next: usize, depth: f32) -> f64 {
    let Some(before) = next.checked_sub(1).map(|index| points[index]) else {
        return 0.0;
    };
    match points.get(next) {
        Some(after) => before.1 + (after.1 - before.1) * fraction(before.0, after.0, depth),
        None => before.1,
    }
}

/// The sum of two curves.
fn add(a: &[(f32, f64)], b: &[(f32, f64)]) -> Vec<(f32, f64)> {
    let mut sum = Vec::with_capacity(a.len() + b.len());
    let mut next = [0, 0];
    loop {
        let first = |points: &[(f32, f64)], next: usize| points.get(next).map(|point| point.0);
        let depth = match (first(a, next[0]), first(b, next[1])) {
            (None, None) => return sum,
            (Some(depth), None) | (None, Some(depth)) => depth,
            (Some(a), Some(b)) => a.min(b),
        };
        let mut value = 0.0;
        for (points, next) in [a, b].into_iter().zip(&mut next) {
            match points.get(*next) {
                Some(point) if point.0 == depth => {
                    *next += 1;
                    value += point.1;
                }
                _ => value += value_at(points, *next, depth),
            }
        }
        sum.push((depth, value));
    }
}

impl Accumulate for Captured {
    type Curve = Uncompressed;

    fn insert(&mut self, segment: &BlockerSegment) {
        if !segment.is_clear() {
            self.segments.push(*segment);
        }
    }

    fn finish(self) -> Uncompressed {
        let points = self.sum();
        Uncompressed {
            depth: points.iter().map(|point| point.0).collect(),
            optical_depth: points.iter().map(|point| point.1 as f32).collect(),
        }
    }
}

/// The exact curve: the sum of all optical depths at each end of a segment.
///
/// Error: one rounding of the optical depth and one of the exponential, at most
/// `2e-7`. Of the order of `log n` steps per query, `n log n` to make.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncompressed {
    depth: Vec<f32>,
    optical_depth: Vec<f32>,
}

impl Uncompressed {
    /// How many points the curve has.
    #[must_use]
    pub fn len(&self) -> usize {
        self.depth.len()
    }

    /// True if nothing is in the way.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.depth.is_empty()
    }

    /// Share of the light that gets as far as `depth`.
    #[must_use]
    pub fn transmittance(&self, depth: f32) -> f32 {
        // A blocker at the depth itself does not count: see `BlockerSegment`.
        let next = self.depth.partition_point(|&point| point < depth);
        let Some(before) = next.checked_sub(1) else {
            return 1.0;
        };
        let value = self.optical_depth[before];
        exp_neg(match self.depth.get(next) {
            Some(&after) => {
                let fraction = fraction(self.depth[before], after, depth);
                mix(value, self.optical_depth[next], fraction)
            }
            None => value,
        })
    }
}

impl Evaluate for Uncompressed {
    fn evaluate(&self, depth: f32) -> [f32; 1] {
        [self.transmittance(depth)]
    }
}

//! Opacity shadow maps: optical depth at depths of equal distance.
//!
//! Based on: T.-Y. Kim, U. Neumann, "Opacity Shadow Maps", Eurographics
//! Workshop on Rendering 2001. Segments count up to where each slice is,
//! exactly, where the paper draws what lies in front of it.

use super::{OPAQUE_ENOUGH, Range};
use crate::numeric::exp_neg;
use crate::{Accumulate, BlockerSegment, Evaluate};

/// Optical depth up to each of `N` depths, from the near to the far end of a
/// range, linear between them.
///
/// Whatever happens within `(far − near) / (N − 1)` is smeared over that
/// distance, so that the error grows with the range. Blockers count with an
/// optical depth of at most 8. Exact at the `N` depths themselves but for that
/// and rounding; monotone and in `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpacityCurve<const N: usize> {
    range: Range,
    optical_depth: [f32; N],
}

impl<const N: usize> OpacityCurve<N> {
    /// A clear ray. `N` is at least 2.
    #[must_use]
    pub fn new(range: Range) -> Self {
        const { assert!(N >= 2, "N is at least 2") }
        Self {
            range,
            optical_depth: [0.0; N],
        }
    }

    /// Share of the light that gets as far as `depth`.
    #[must_use]
    pub fn transmittance(&self, depth: f32) -> f32 {
        if !(depth > self.range.near) {
            return 1.0;
        }
        let place = self.range.share(depth) * (N - 1) as f64;
        let slice = (place as usize).min(N - 2);
        let [from, to] = [self.optical_depth[slice], self.optical_depth[slice + 1]];
        exp_neg(from + (to - from) * (place - slice as f64) as f32)
    }
}

impl<const N: usize> Evaluate for OpacityCurve<N> {
    fn evaluate(&self, depth: f32) -> [f32; 1] {
        [self.transmittance(depth)]
    }
}

impl<const N: usize> Accumulate for OpacityCurve<N> {
    type Curve = Self;

    fn insert(&mut self, segment: &BlockerSegment) {
        let [entry, exit] = self
            .range
            .shares(segment)
            .map(|share| share * (N - 1) as f64);
        let tau = segment.optical_depth()[0].min(OPAQUE_ENOUGH);
        // The first slice behind the entry: a surface does not shadow itself.
        // What lies in front of the range counts there in full.
        let first = if segment.exit() < self.range.near {
            0
        } else {
            entry as usize + 1
        };
        let inverse = (exit - entry).recip();
        for (slice, value) in self.optical_depth.iter_mut().enumerate().skip(first) {
            let way = slice as f64 - entry;
            *value += if slice as f64 >= exit {
                tau
            } else {
                tau * (way * inverse) as f32
            };
        }
        // Behind everything, also what ends or stands at the far end counts.
        if first >= N {
            self.optical_depth[N - 1] += tau;
        }
    }

    fn finish(self) -> Self {
        self
    }
}

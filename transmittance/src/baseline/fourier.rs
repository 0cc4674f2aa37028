//! Fourier opacity maps: the density along the ray as a Fourier series.
//!
//! Based on: J. Jansen, L. Bavoil, "Fourier Opacity Mapping", Symposium on
//! Interactive 3D Graphics and Games 2010. Segments are integrated
//! analytically, where the paper's particles are points.

use std::f64::consts::PI;

use super::{OPAQUE_ENOUGH, Range};
use crate::numeric::exp_neg;
use crate::{Accumulate, BlockerSegment, Evaluate};

/// `N` pairs of Fourier coefficients of the density over a range of depths
/// `d` from 0 to 1; 16 pairs are what the literature calls 16 terms.
///
/// ```text
/// a_k = 2 Σ τ mean cos(2π k d),   b_k = 2 Σ τ mean sin(2π k d)
/// −ln T(d) = a_0 d / 2 + Σ a_k sin(2π k d) / 2πk + Σ b_k (1 − cos(2π k d)) / 2πk
/// ```
///
/// with the mean over each segment. Rings at steps: neither monotone nor, but
/// for being clamped, in `[0, 1]`; and being periodic, wrong by up to half of
/// what stands at the ends of the range. Blockers count with an optical depth of
/// at most 8.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FourierCurve<const N: usize> {
    range: Range,
    cosines: [f32; N],
    sines: [f32; N],
}

impl<const N: usize> FourierCurve<N> {
    /// A clear ray. `N` is at least 1.
    #[must_use]
    pub fn new(range: Range) -> Self {
        const { assert!(N >= 1, "N is at least 1") }
        Self {
            range,
            cosines: [0.0; N],
            sines: [0.0; N],
        }
    }

    /// Share of the light that gets as far as `depth`.
    #[must_use]
    pub fn transmittance(&self, depth: f32) -> f32 {
        if !(depth > self.range.near) {
            return 1.0;
        }
        let d = self.range.share(depth);
        let mut tau = 0.5 * self.cosines[0] * d as f32;
        let mut wave = Multiples::of(2.0 * PI * d);
        for k in 1..N {
            let (sin, cos) = wave.next();
            let waves = self.cosines[k] * sin + self.sines[k] * (1.0 - cos);
            tau += waves / (2.0 * std::f32::consts::PI * k as f32);
        }
        exp_neg(tau.max(0.0))
    }
}

impl<const N: usize> Evaluate for FourierCurve<N> {
    fn evaluate(&self, depth: f32) -> [f32; 1] {
        [self.transmittance(depth)]
    }
}

impl<const N: usize> Accumulate for FourierCurve<N> {
    type Curve = Self;

    fn insert(&mut self, segment: &BlockerSegment) {
        let [entry, exit] = self.range.shares(segment);
        let twice = 2.0 * segment.optical_depth()[0].min(OPAQUE_ENOUGH);
        // The mean of a wave over a segment is its value at the middle times
        // sin(h) / h for half a length h in radians.
        let mut middle = Multiples::of(PI * (entry + exit));
        let half = PI * (exit - entry);
        let mut edge = Multiples::of(half);
        self.cosines[0] += twice;
        for k in 1..N {
            let (sin, cos) = middle.next();
            let (edge, _) = edge.next();
            let h = k as f32 * half as f32;
            let mean = if h > 1e-3 { edge / h } else { 1.0 };
            self.cosines[k] += twice * mean * cos;
            self.sines[k] += twice * mean * sin;
        }
    }

    fn finish(self) -> Self {
        self
    }
}

/// Sine and cosine of the multiples of an angle, each from the one before by a
/// rotation: `k` roundings after `k` steps.
struct Multiples {
    once: (f32, f32),
    now: (f32, f32),
}

impl Multiples {
    fn of(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self {
            once: (sin as f32, cos as f32),
            now: (0.0, 1.0),
        }
    }

    fn next(&mut self) -> (f32, f32) {
        let ((s, c), (sin, cos)) = (self.once, self.now);
        self.now = (sin * c + cos * s, cos * c - sin * s);
        self.now
    }
}

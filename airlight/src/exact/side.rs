//! One side of the foot point in a variable that no limit spoils.

use super::segment::{OPAQUE, Scaled};
use crate::ScatteringAngle;

/// The part of a segment on one side of the foot point, as an integral of
/// `2 p e^{−Y} / (a² + b²)` over an offset `o`:
///
/// ```text
/// b = start + slope o,     tan(θ/2) = b/a (or a/b),     Y = depth + rate o
/// ```
///
/// Behind the foot point `o` is the growth of `t = s + d`, with `a = h` and
/// `b = t`: since `dx / d² = 2 dt / (h² + t²)` and `x + d` grows as `t` does,
/// the inverse square and the exponent are both elementary in it. In front,
/// where `t = h² / (d − s)` tells nothing if `h` is 0, it is the growth of
/// `q = 1 / (d − s)`, with `a = 1` and `b = h q`. Without absorption a far end
/// need not be cut off; there `o` is the growth of `1/t` towards the light.
///
/// All is in units of the distance of the segment's start from the light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    a: f64,
    start: f64,
    slope: f64,
    depth: f64,
    rate: f64,
    /// Where `o` ends; may be infinite if `rate` is positive.
    pub(super) extent: f64,
    /// Whether b grows towards the forward direction.
    reversed: bool,
    /// The scale of `b` below which the integrand no longer changes.
    finest: f64,
}

/// Width of the sharpest peak that is looked for; it is as sharp as g next to 1
/// in single precision.
const SHARPEST: f64 = 1e-9;

/// Depth `σ_t d` below which absorption along the path behind changes the
/// result by less than rounding does.
pub(super) const THIN: f64 = 1e-20;

impl Side {
    /// The sides of a segment; `peaks` as in
    /// [`Phase::peaks`](crate::Phase::peaks).
    pub(super) fn both(segment: &Scaled, peaks: [f64; 2]) -> impl Iterator<Item = Self> {
        let Scaled {
            sigma,
            s,
            end,
            h,
            length,
            end_distance,
            ..
        } = *segment;
        let peaks = peaks.map(|peak| if peak > SHARPEST { peak } else { SHARPEST });

        let mut depth = 0.0;
        let front = (s < 0.0).then(|| {
            let (length, end, distance) = if end < 0.0 {
                (length, end, end_distance)
            } else {
                (-s, 0.0, h)
            };
            let first = 1.0 / (1.0 - s);
            let last = 1.0 / (distance - end);
            let side = Self {
                a: 1.0,
                start: h * first,
                slope: h,
                depth: 0.0,
                rate: sigma * h * h,
                extent: length * (first + last) / (1.0 + distance),
                reversed: false,
                finest: peaks[0],
            };
            depth = side.rate * side.extent;
            side
        });

        let behind = (end > 0.0).then(|| {
            let (length, start, distance) = if s < 0.0 {
                (end, 0.0, h)
            } else {
                (length, s, 1.0)
            };
            let first = start + distance;
            let last = end + end_distance;
            if sigma < THIN {
                let (first, last) = (1.0 / first, 1.0 / last);
                let extent = if length.is_finite() {
                    length * (first + last) / (distance + end_distance)
                } else {
                    first
                };
                return Self {
                    a: 1.0,
                    start: h * last,
                    slope: h,
                    depth,
                    rate: 0.0,
                    extent,
                    reversed: true,
                    finest: peaks[1],
                };
            }
            let extent = if length.is_finite() {
                length * (first + last) / (distance + end_distance)
            } else {
                f64::INFINITY
            };
            Self {
                a: h,
                start: first,
                slope: 1.0,
                depth,
                rate: sigma,
                extent,
                reversed: false,
                finest: 0.0,
            }
        });
        front.into_iter().chain(behind)
    }

    /// The angle of scattering at an offset, and everything else of the
    /// integrand.
    pub(super) fn at(&self, offset: f64) -> (ScatteringAngle<f64>, f64) {
        let b = self.start + self.slope * offset;
        let angle = if self.reversed {
            ScatteringAngle::from_half_tangent(self.a, b)
        } else {
            ScatteringAngle::from_half_tangent(b, self.a)
        };
        let exponential = (-(self.depth + self.rate * offset)).exp();
        (angle, 2.0 * exponential / (self.a * self.a + b * b))
    }

    /// The end of a piece from `offset` on over which the integrand is
    /// smooth; none if nothing is left.
    ///
    /// Poles of the integrand have `b` imaginary, so that a piece may be as
    /// long as it is away from `b = 0`, but need not be shorter than the width
    /// of the sharpest peak. The exponential may fall by a fixed factor, or, where nothing much is
    /// left of it, to a fixed power.
    pub(super) fn next(&self, offset: f64) -> Option<f64> {
        let faded = self.rate * offset;
        if !(offset < self.extent && faded + self.depth < OPAQUE) {
            return None;
        }
        let b = self.start + self.slope * offset;
        let mut width = b.max(self.finest) / self.slope;
        if self.rate > 0.0 {
            width = width.min(faded.max(6.0) / self.rate);
        }
        let end = offset + width;
        // Not a sliver at the end.
        let rest = self.extent - offset;
        Some(if rest < 1.1 * width { self.extent } else { end })
    }
}

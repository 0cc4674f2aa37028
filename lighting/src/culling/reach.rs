//! Where along its axis a cone of rays may be lit.

use glam::DVec3;

use crate::scene::{Emission, Emitter};

/// What roundings add to distances, relative to all that go into them: those of f32
/// coordinates and of the numbers here.
const ROUNDING: f64 = 4e-6;

/// The bounds of a light at a point, as seen from an eye.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// From the eye to the light.
    to_light: DVec3,
    /// May be infinite.
    range: f64,
    /// What the rounding of coordinates in the world adds to distances.
    slack: f64,
    /// The axis of the cone that it shines into, and sine and cosine of its half angle.
    cone: Option<(DVec3, [f64; 2])>,
}

/// A cone of rays from the eye.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bundle {
    pub(super) axis: DVec3,
    /// Distance of a point of a ray from that of the axis which is as far from the eye,
    /// relative to this distance.
    pub(super) spread: f64,
    /// Length of its longest ray.
    pub(super) farthest: f64,
}

/// Whether there are enough lights with a range or a cone for culling to be worth its
/// lists: eight.
pub fn is_worthwhile<'a>(emitters: impl IntoIterator<Item = &'a Emitter>) -> bool {
    const ENOUGH: usize = 8;
    let bounded = emitters.into_iter().filter(|emitter| is_bounded(emitter));
    bounded.take(ENOUGH).count() == ENOUGH
}

/// Whether a light has a range or does not shine in all directions, so that there may be
/// rays that it does not reach.
pub fn is_bounded(emitter: &Emitter) -> bool {
    match emitter {
        Emitter::Point(point) => {
            point.range() < f32::INFINITY || *point.emission() != Emission::Isotropic
        }
        Emitter::Directional(_) => false,
    }
}

impl Reach {
    /// `None` if the light has no bounds.
    pub(super) fn new(emitter: &Emitter, eye: DVec3) -> Option<Self> {
        let Emitter::Point(point) = emitter else {
            return None;
        };
        if !is_bounded(emitter) {
            return None;
        }
        let cone = match point.emission() {
            Emission::Isotropic => None,
            Emission::Cosine { normal } => Some((normal.as_dvec3(), [1.0, 0.0])),
            Emission::Spot(spot) => {
                // From 1 − cos, which has more digits.
                let versine = f64::from(spot.outer_versine());
                let sine = (versine * (2.0 - versine)).max(0.0).sqrt();
                Some((spot.axis().as_dvec3(), [sine, 1.0 - versine]))
            }
        };
        let range = f64::from(point.range());
        Some(Self {
            to_light: point.position().as_dvec3() - eye,
            range,
            slack: ROUNDING * eye.length(),
            cone: cone.map(|(axis, angle)| (axis.normalize(), angle)),
        })
    }

    /// The distances from the eye between which rays of a bundle may be lit; `None` if
    /// there are none.
    pub(super) fn part(&self, bundle: &Bundle) -> Option<[f64; 2]> {
        let mut part = [0.0, bundle.farthest];
        let distance = self.to_light.length();
        let along = self.to_light.dot(bundle.axis);
        let grown = bundle.spread + ROUNDING;
        // |x t − c|² ≤ (R + κ x)²
        if self.range < f64::INFINITY {
            let range = self.range * (1.0 + ROUNDING) + ROUNDING * distance + self.slack;
            let square = Quadratic {
                a: 1.0,
                b: -along,
                c: distance * distance,
            };
            part = square.within([range, grown], part)?;
        }
        if let Some((axis, [sine, cosine])) = self.cone {
            let sine = sine + ROUNDING;
            // z = z₀ + z₁ x and r² = |x t − c|² − z².
            let [start, slope] = [-self.to_light.dot(axis), bundle.axis.dot(axis)];
            let square = Quadratic {
                a: cosine * cosine * (1.0 - slope * slope).max(0.0),
                b: cosine * cosine * (-along - start * slope),
                c: cosine * cosine * (distance * distance - start * start).max(0.0),
            };
            let limit = [
                start * sine + ROUNDING * distance + self.slack,
                slope * sine + grown,
            ];
            part = square.within(limit, part)?;
        }
        Some(part)
    }
}

/// The square `a x² + 2 b x + c` of a distance, which is convex.
struct Quadratic {
    a: f64,
    b: f64,
    c: f64,
}

impl Quadratic {
    /// The part of an interval in which the root of the square is at most `m + n x`.
    fn within(&self, [m, n]: [f64; 2], [start, end]: [f64; 2]) -> Option<[f64; 2]> {
        // The limit must not be negative.
        let zero = -m / n;
        let [start, end] = match (n > 0.0, n < 0.0) {
            (true, _) => [start.max(zero), end],
            (_, true) => [start, end.min(zero)],
            _ if m >= 0.0 => [start, end],
            _ => return None,
        };
        if !(start <= end) {
            return None;
        }
        // a x² + 2 b x + c ≤ 0, the difference of the squares, whose roundings are relative
        // to what they are differences of.
        let [a, b, c] = [self.a - n * n, self.b - m * n, self.c - m * m];
        let rounding =
            1e-12 * ((self.b.abs() + (m * n).abs()).powi(2) + (self.a + n * n) * (self.c + m * m));
        let discriminant = b * b - a * c;
        if a > 0.0 {
            if discriminant < -rounding {
                return None;
            }
            let [first, last] = roots([a, b, c], discriminant + rounding);
            let [start, end] = [start.max(first), end.min(last)];
            return (start <= end).then_some([start, end]);
        }
        // True on one side of a root: where it holds at an end. It may be so at both, as the
        // limit's sign leaves only one of two sides.
        let holds = |x: f64| match x.is_infinite() {
            true => a < 0.0 || b < 0.0 || (b == 0.0 && c <= 0.0),
            false => (a * x + 2.0 * b) * x + c <= 0.0,
        };
        let [first, last] = roots([a, b, c], discriminant - rounding);
        match [holds(start), holds(end)] {
            [true, true] => Some([start, end]),
            [true, false] => Some([start, end.min(first.max(start))]),
            [false, true] => Some([start.max(last.min(end)), end]),
            [false, false] => None,
        }
    }
}

/// The roots of `a x² + 2 b x + c`, the lesser first, as far as there are any.
fn roots([a, b, c]: [f64; 3], discriminant: f64) -> [f64; 2] {
    if a == 0.0 {
        return [-0.5 * c / b; 2];
    }
    let root = discriminant.max(0.0).sqrt();
    // No difference of numbers that are alike.
    let sum = if b > 0.0 { -b - root } else { -b + root };
    let [one, two] = [sum / a, c / sum];
    [one.min(two), one.max(two)]
}

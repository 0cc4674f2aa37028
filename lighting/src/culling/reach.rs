//! The part of a cone of rays that a light may reach.

use glam::DVec3;

use crate::scene::{Emission, Emitter};

/// A bound on the rounding of distances, relative to the lengths that they are computed from.
/// It covers f32 coordinates and the computations here.
const ROUNDING: f64 = 4e-6;

/// The bounds of a point light, as seen from an eye.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// The vector from the eye to the light.
    to_light: DVec3,
    /// May be infinite.
    range: f64,
    /// A bound on what the rounding of world coordinates adds to distances.
    slack: f64,
    /// The axis of the cone that it shines into, and the sine and cosine of the half angle.
    cone: Option<(DVec3, [f64; 2])>,
}

/// A cone of rays from the eye.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bundle {
    pub(super) axis: DVec3,
    /// For a point on a ray and the point on the axis that is equally far from the eye: a bound
    /// on their distance, relative to their distance from the eye.
    pub(super) spread: f64,
    /// Length of the longest ray.
    pub(super) farthest: f64,
}

/// Whether at least eight of the lights have a range or a cone. With fewer, culling is not
/// worth its lists.
pub fn is_worthwhile<'a>(emitters: impl IntoIterator<Item = &'a Emitter>) -> bool {
    const ENOUGH: usize = 8;
    let bounded = emitters.into_iter().filter(|emitter| is_bounded(emitter));
    bounded.take(ENOUGH).count() == ENOUGH
}

/// Whether a light has a range or does not shine in all directions, so that it may miss rays.
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
                // The cosine is derived from 1 − cos, which has more digits for narrow cones.
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
            // With z = z₀ + z₁ x, and r² = |x t − c|² − z².
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

/// The square `a x² + 2 b x + c` of a distance, which is convex in x.
struct Quadratic {
    a: f64,
    b: f64,
    c: f64,
}

impl Quadratic {
    /// The part of an interval in which the distance is at most `m + n x`.
    fn within(&self, [m, n]: [f64; 2], [start, end]: [f64; 2]) -> Option<[f64; 2]> {
        // The bound `m + n x` must not be negative.
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
        // a x² + 2 b x + c ≤ 0 is the difference of the two squares; its rounding is relative
        // to these.
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
        // The inequality holds on one side of a root, so it is tested at the ends. It may hold
        // at both, since the sign of the bound leaves only one of two solutions.
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

/// The real roots of `a x² + 2 b x + c`, the smaller one first.
fn roots([a, b, c]: [f64; 3], discriminant: f64) -> [f64; 2] {
    if a == 0.0 {
        return [-0.5 * c / b; 2];
    }
    let root = discriminant.max(0.0).sqrt();
    // This form subtracts no numbers of nearly equal size.
    let sum = if b > 0.0 { -b - root } else { -b + root };
    let [one, two] = [sum / a, c / sum];
    [one.min(two), one.max(two)]
}

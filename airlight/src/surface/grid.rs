//! The axes of the tables, and the values on them.

use std::f64::consts::PI;

use super::exact::ring_light;
use super::ring::Ring;
use crate::gauss::Rule;
use crate::spline;
use crate::within::within;

/// Values along the optical distance. This number and the next two were tuned
/// together, so that none of the axes causes an error above 1e-4.
pub(super) const DISTANCES: usize = 40;
/// Values along the angle between lobe and light.
pub(super) const ANGLES: usize = 64;
/// Values along the exponent of the lobe.
pub(super) const EXPONENTS: usize = 39;

/// Coefficients along the angle.
pub(super) const STRIDE: usize = ANGLES + 2;
/// Coefficients of one exponent.
pub(super) const PLANE: usize = (DISTANCES + 2) * STRIDE;

/// Beyond this optical distance `e^{−T}` is 0 in f32.
const FARTHEST: f64 = 104.0;

/// The axis of distances: `T^{1/4}`, which turns the `T ln T` at small T into
/// something that has three derivatives, and is two square roots.
pub(super) fn distance_coordinate(t: f32) -> f32 {
    t.max(0.0).sqrt().sqrt() / FARTHEST.sqrt().sqrt() as f32
}

fn distance(index: usize) -> f64 {
    FARTHEST * (index as f64 / (DISTANCES - 1) as f64).powi(4)
}

/// The largest exponent on the axis. A spline is least accurate in its last two
/// intervals, which therefore lie beyond the 200 that is asked for.
const SHARPEST: f64 = 300.0;

/// The axis of exponents: `ln n`.
pub(super) fn exponent_coordinate(n: f32) -> f32 {
    n.ln() / SHARPEST.ln() as f32
}

pub(super) fn exponent(index: usize) -> f64 {
    SHARPEST.powf(index as f64 / (EXPONENTS - 1) as f64)
}

/// The axis of angles, as `c = cos θ`: `ln(1 + (1 − c)/0.01) − ½ asinh(c/0.01)`,
/// scaled to [0, 1].
///
/// The first term resolves sharp lobes about the light, the second the edge
/// of blunt ones: a linear lobe ends in a kink at c = 0, where `G` has a
/// logarithm in its second derivative and, in dense fog, turns within 1/T. The
/// axis does not depend on the exponent, so that values at one angle are
/// smooth in the exponent too. Both lengths and the ½ were tuned.
#[derive(Debug, Clone, Copy)]
struct AngleAxis {
    start: f64,
    end: f64,
}

const FINENESS: f64 = 100.0;

impl AngleAxis {
    fn new() -> Self {
        Self {
            start: Self::unscaled(1.0),
            end: Self::unscaled(-1.0),
        }
    }

    fn unscaled(c: f64) -> f64 {
        (FINENESS * (1.0 - c)).ln_1p() - 0.5 * (FINENESS * c).asinh()
    }

    /// θ at a node, by bisection.
    fn angle(self, index: usize) -> f64 {
        let x = index as f64 / (ANGLES - 1) as f64;
        let target = self.start + x * (self.end - self.start);
        let (mut low, mut high) = (0.0, PI);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if Self::unscaled(f64::cos(middle)) < target {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

/// The coordinate on the axis of angles; see `AngleAxis`.
pub(super) fn angle_coordinate(cos_theta: f32) -> f32 {
    // unscaled(1) = −½ asinh(100), and unscaled(−1) = ln 201 + ½ asinh(100).
    const HALF_ASINH: f32 = 2.649_171;
    const SCALE: f32 = 1.0 / (5.303_305 + 2.0 * HALF_ASINH);
    // NaN as −1.
    let c = within(cos_theta, -1.0, 1.0);
    let x = FINENESS as f32 * c.abs();
    let asinh = (x + (x * x + 1.0).sqrt()).ln().copysign(c);
    let log = (1.0 + FINENESS as f32 * (1.0 - c)).ln();
    (log - 0.5 * asinh + HALF_ASINH) * SCALE
}

/// A rule over γ from 0 to π that suits all integrands of the tables: panels
/// that double from `2^{-14}/10`, for the logarithm at 0 and the scale 1/T,
/// and then are even and narrower than the sharpest lobe.
pub(super) struct Directions {
    rule: Vec<(f64, f64)>,
    /// `K` at each node, per distance.
    light: Vec<Vec<f64>>,
}

impl Directions {
    pub(super) fn new() -> Self {
        let first = 0.1;
        let even = 31;
        let mut edges = vec![0.0];
        edges.extend((0..14).rev().map(|k| first * 0.5_f64.powi(k + 1)));
        edges.extend((0..=even).map(|k| first + (PI - first) * f64::from(k) / f64::from(even)));
        let nodes = Rule::of(12);
        let rule: Vec<(f64, f64)> = edges
            .windows(2)
            .flat_map(|panel| {
                let (start, width) = (panel[0], panel[1] - panel[0]);
                nodes
                    .iter()
                    .map(move |(node, weight)| (start + width * node, width * weight))
            })
            .collect();
        let light = (0..DISTANCES)
            .map(|index| {
                let t = distance(index);
                rule.iter()
                    .map(|&(gamma, _)| ring_light(t, gamma))
                    .collect()
            })
            .collect();
        Self { rule, light }
    }

    /// The spline coefficients of `ln(e^T G_n)` for one exponent, distances
    /// outside, angles inside.
    ///
    /// The logarithm makes the interpolated values positive, their error
    /// relative, and the factor `e^{−T}` part of the one exponential.
    pub(super) fn plane(&self, exponent: f64) -> Vec<f64> {
        let ring = Ring::new(exponent);
        let axis = AngleAxis::new();
        let mut values = vec![0.0; DISTANCES * ANGLES];
        for angle in 0..ANGLES {
            let theta = axis.angle(angle);
            let rings: Vec<f64> = self
                .rule
                .iter()
                .map(|&(gamma, weight)| weight * ring.value(gamma, theta))
                .collect();
            for (row, light) in self.light.iter().enumerate() {
                let sum: f64 = rings
                    .iter()
                    .zip(light)
                    .map(|(ring, light)| ring * light)
                    .sum();
                values[row * ANGLES + angle] = sum.ln();
            }
        }
        let rows = spline::coefficients(&values, ANGLES, 1);
        spline::coefficients(&rows, DISTANCES, STRIDE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lookups_find_the_nodes() {
        let axis = AngleAxis::new();
        for i in 0..ANGLES {
            let x = angle_coordinate(axis.angle(i).cos() as f32) * (ANGLES - 1) as f32;
            // The rounding of cos θ near 1 and 0, 100 ε 63 / 10, and of the rest.
            assert!((x - i as f32).abs() < 1e-4, "angle {i}: {x}");
        }
        for i in 0..DISTANCES {
            let x = distance_coordinate(distance(i) as f32) * (DISTANCES - 1) as f32;
            assert!((x - i as f32).abs() < 1e-5, "distance {i}: {x}");
        }
        for i in 0..EXPONENTS {
            let x = exponent_coordinate(exponent(i) as f32) * (EXPONENTS - 1) as f32;
            assert!((x - i as f32).abs() < 1e-5, "exponent {i}: {x}");
        }
    }
}

//! Tables of the light that fog sends to a surface, in f32.

use super::checked_exponent;
use super::grid::{
    ANGLES, DISTANCES, Directions, EXPONENTS, PLANE, STRIDE, angle_coordinate, distance_coordinate,
    exponent, exponent_coordinate,
};
use crate::Error;
use crate::spline::{self, Position};
use crate::within::within;

/// `G_n(T, θ)` for one exponent `n`, in 11 KiB.
///
/// The relative error is below 1e-4 (6e-5 was measured) for every angle and every optical distance
/// at which the result is a normal f32, which is up to 86 or so; beyond, it
/// goes to 0. The values are positive and have two continuous derivatives.
///
/// The table holds the logarithm of `e^T G_n` as coefficients of a bicubic
/// spline: 16 neighbours and one exponential per lookup.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeTable {
    coefficients: Vec<f32>,
}

impl LobeTable {
    /// The table for the lobe `max(0, cos)^exponent`, which is made by quadrature; keep it for
    /// all lookups of this lobe.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless the exponent is from 1 to 200.
    pub fn new(exponent: f32) -> Result<Self, Error> {
        let exponent = checked_exponent(exponent.into())?;
        Ok(Self::of(exponent, &Directions::new()))
    }

    /// `G_0`: the table of a Lambertian surface, whose lobe is the cosine to
    /// its normal.
    pub fn lambertian() -> Self {
        Self::of(1.0, &Directions::new())
    }

    pub(super) fn of(exponent: f64, directions: &Directions) -> Self {
        Self {
            coefficients: narrowed(&directions.plane(exponent)),
        }
    }

    /// `G_n`, dimensionless, at the optical distance `T ≥ 0` of the light and
    /// the cosine of the angle between light and lobe.
    ///
    /// A cosine outside of [-1, 1] counts as the nearer end, a negative T as 0;
    /// never NaN, which counts as T = 0 and as cosine -1.
    pub fn value(&self, optical_distance: f32, cos_theta: f32) -> f32 {
        let [distance, angle] = positions(optical_distance, cos_theta);
        let log = spline::at(&self.coefficients, STRIDE, distance, angle);
        (log - optical_distance.max(0.0)).exp()
    }

    /// The array behind `air_surface_coefficient` in shaders.
    #[cfg(feature = "wgsl")]
    pub fn coefficients(&self) -> &[f32] {
        &self.coefficients
    }

    /// Size of the table.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.coefficients)
    }
}

/// `G_n(T, θ)` for all exponents `n` from 1 to 200, in 444 KiB.
///
/// As [`LobeTable`], with a third axis: the relative error is below 1e-4
/// (7e-5 was measured) for every exponent, whole or not, and a lookup has 64
/// neighbours. Where all surfaces have the same exponent, a [`LobeTable`] is
/// faster.
#[derive(Debug, Clone, PartialEq)]
pub struct GlossTable {
    coefficients: Vec<f32>,
}

impl GlossTable {
    /// The table: a fraction of a second of quadrature.
    #[expect(
        clippy::new_without_default,
        reason = "nothing that takes so long is a default"
    )]
    pub fn new() -> Self {
        Self::of(&Directions::new())
    }

    pub(super) fn of(directions: &Directions) -> Self {
        let planes: Vec<f64> = (0..EXPONENTS)
            .flat_map(|index| directions.plane(exponent(index)))
            .collect();
        Self {
            coefficients: narrowed(&spline::coefficients(&planes, EXPONENTS, PLANE)),
        }
    }

    /// `G_n`, as [`LobeTable::value`]; an exponent outside of 1 to 200 counts
    /// as the nearer end, NaN as 1.
    pub fn value(&self, exponent: f32, optical_distance: f32, cos_theta: f32) -> f32 {
        let exponent = within(exponent, 1.0, 200.0);
        let gloss = Position::new(exponent_coordinate(exponent), EXPONENTS);
        let [distance, angle] = positions(optical_distance, cos_theta);
        let mut log = 0.0;
        for (plane, weight) in gloss.weights.iter().enumerate() {
            let start = (gloss.first + plane) * PLANE;
            let plane = &self.coefficients[start..start + PLANE];
            log += weight * spline::at(plane, STRIDE, distance, angle);
        }
        (log - optical_distance.max(0.0)).exp()
    }

    /// The array behind `air_surface_coefficient` in shaders.
    #[cfg(feature = "wgsl")]
    pub fn coefficients(&self) -> &[f32] {
        &self.coefficients
    }

    /// Size of the table.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.coefficients)
    }
}

fn positions(optical_distance: f32, cos_theta: f32) -> [Position; 2] {
    [
        Position::new(distance_coordinate(optical_distance), DISTANCES),
        Position::new(angle_coordinate(cos_theta), ANGLES),
    ]
}

fn narrowed(values: &[f64]) -> Vec<f32> {
    values.iter().map(|&value| value as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::super::exact;
    use super::*;

    /// What both tables promise.
    const BOUND: f64 = 1e-4;

    /// Optical distances: 0, close to it, over the range that was asked for,
    /// and to the end of the normal numbers.
    fn distances() -> Vec<f32> {
        let mut list = vec![0.0, 1e-12];
        list.extend((0..12).map(|i| 1e-6 * 3.7_f32.powi(i)));
        list.extend((0..14).map(|i| 5.3 + 6.05 * i as f32));
        list
    }

    /// Cosines that crowd about 1 and about 0.
    fn cosines() -> Vec<f32> {
        let mut list = vec![-1.0, 0.0, 1.0];
        for i in 0..5 {
            let small = 2e-6 * 11.0_f32.powi(i);
            list.extend([1.0 - small, small, -small, small - 1.0]);
        }
        list.extend((0..24).map(|i| -0.97 + 0.083 * i as f32));
        list
    }

    fn worst(truth: &exact::Lobe, table: impl Fn(f32, f32) -> f32) -> (f64, f32, f32) {
        let mut worst = (0.0, 0.0, 0.0);
        for t in distances() {
            for cos in cosines() {
                let expected = truth.value(t.into(), f64::from(cos).acos());
                if expected < f32::MIN_POSITIVE.into() {
                    continue;
                }
                let error = (f64::from(table(t, cos)) / expected - 1.0).abs();
                assert!(error.is_finite());
                if error > worst.0 {
                    worst = (error, t, cos);
                }
            }
        }
        worst
    }

    #[test]
    fn both_tables_are_within_their_bound_everywhere() {
        let gloss = GlossTable::new();
        // Between the nodes of the axis of exponents and on them.
        let exponents = [
            1.0, 1.03, 1.08, 1.25, 1.6, 2.0, 3.5, 7.0, 9.2, 21.0, 60.0, 131.0, 184.0, 193.0, 199.1,
            200.0,
        ];
        for n in exponents {
            let lobe = exact::Lobe::new(n.into()).unwrap();
            let single = LobeTable::new(n).unwrap();
            let (error, t, cos) = worst(&lobe, |t, cos| single.value(t, cos));
            assert!(error < BOUND, "n {n}, T {t}, cos {cos}: {error:e}");
            let (error, t, cos) = worst(&lobe, |t, cos| gloss.value(n, t, cos));
            assert!(error < BOUND, "n {n} of all, T {t}, cos {cos}: {error:e}");
        }
    }

    #[test]
    fn known_values() {
        let table = LobeTable::lambertian();
        let pi = std::f32::consts::PI;
        let facing = 2.0 * pi * (0.25 * pi + 0.5);
        let averted = pi * (0.5 * pi - 1.0);
        assert!((table.value(0.0, 1.0) / facing - 1.0).abs() < 1e-5);
        assert!((table.value(0.0, -1.0) / averted - 1.0).abs() < 1e-5);
    }

    #[test]
    fn sizes_are_as_stated() {
        assert!(LobeTable::lambertian().bytes() <= 11 * 1024);
        assert!(GlossTable::new().bytes() <= 444 * 1024);
    }

    #[test]
    fn no_input_gives_nan_or_a_negative_value() {
        let gloss = GlossTable::new();
        let lobe = LobeTable::lambertian();
        let odd = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            -1.0,
            0.0,
            -0.0,
            1.0,
            50.0,
            104.0,
            f32::MIN_POSITIVE,
            1e-45,
        ];
        for a in odd {
            for b in odd {
                assert!(lobe.value(a, b) >= 0.0, "{a} {b}");
                for c in odd {
                    assert!(gloss.value(a, b, c) >= 0.0, "{a} {b} {c}");
                }
            }
        }
        assert_eq!(lobe.value(f32::INFINITY, 1.0), 0.0);
    }

    #[test]
    fn exponents_out_of_range_are_refused() {
        for n in [0.0, 0.99, 200.1, f32::NAN, f32::INFINITY, -3.0] {
            let error = LobeTable::new(n).unwrap_err();
            assert!(error.to_string().contains("1 to 200"), "{error}");
        }
    }
}

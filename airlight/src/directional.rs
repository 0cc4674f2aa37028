//! Parallel light, in closed form.
//!
//! Based on: Hoffman and Preetham, Rendering outdoor light scattering in real
//! time, Game Developers Conference 2002, for light that is not absorbed
//! before it is scattered; and without their assumption of one path.

use crate::{Error, PhaseFunction, Real, ScatteringAngle};

/// `∫ exp(−σ_t x) dx` over a part of a ray from `x` on, in m: the airlight of
/// a sun per unit of `σ_s p E`, in a medium without bounds, which sunlight
/// reaches undimmed.
///
/// Accurate to a few units of the last digit of the exponent `σ_t x`, as long
/// as `exp(−σ_t x)` is a normal number: in f32 up to an exponent of 87. An
/// infinite length is allowed; without extinction it counts as nothing, as
/// there nothing is scattered either. What is no extinction, no way or no
/// length (NaN, or a negative number) gives 0.
pub fn open_air<T: Real>(sigma_t: T, x: T, length: T) -> T {
    let zero = T::from(0.0);
    let ways = length > zero && x >= zero && !x.is_infinite();
    if !ways || !(sigma_t >= zero) || sigma_t.is_infinite() {
        return zero;
    }
    let near = (-(sigma_t * x)).exponential();
    let depth = sigma_t * length;
    if length.is_infinite() {
        return if sigma_t > zero { near / sigma_t } else { zero };
    }
    if depth > T::from(1.0) {
        // The product of a length and a mean could leave the range.
        return near * (-(-depth).exponential_minus_one() / sigma_t);
    }
    near * length * mean_exponential(depth)
}

/// `∫ exp(−τ(x)) dx` over `length`, in m, for an optical depth that changes
/// linearly from `first` to `last`: the airlight of a sun per unit of
/// `σ_s p E` between two kinks of its path, `τ = σ_t (x + l)`, in a medium with
/// bounds.
///
/// Neither depth need be the larger one; no difference of large numbers is
/// formed but that of the depths. In f32 digits are lost where the smaller depth
/// is above 87. For finite lengths: the part of a ray that
/// goes on for ever is [`open_air`]. What is no depth or no length gives 0.
pub fn between<T: Real>(first: T, last: T, length: T) -> T {
    let zero = T::from(0.0);
    let depths = first >= zero && last >= zero;
    if !depths || !(length > zero) || length.is_infinite() {
        return zero;
    }
    let (least, most) = if first < last {
        (first, last)
    } else {
        (last, first)
    };
    if least.is_infinite() {
        return zero;
    }
    (-least).exponential() * length * mean_exponential(most - least)
}

/// The mean of `exp(−y)` for `y` from 0 to `x ≥ 0`, `(1 − exp(−x)) / x`.
fn mean_exponential<T: Real>(x: T) -> T {
    if x > T::from(0.0) {
        -(-x).exponential_minus_one() / x
    } else {
        T::from(1.0)
    }
}

/// Daylight in clear or hazy air: Rayleigh scattering by molecules and
/// Henyey–Greenstein by dust, per colour channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Daylight {
    rayleigh: [f32; 3],
    mie: [f32; 3],
    g: f32,
}

impl Daylight {
    /// For scattering coefficients `β_R` and `β_M`, 1/m, and the mean cosine
    /// `g` of dust. Nothing is absorbed.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless coefficients and their sum are finite and not
    /// negative and -1 < g < 1.
    pub fn new(rayleigh: [f32; 3], mie: [f32; 3], g: f32) -> Result<Self, Error> {
        for beta in rayleigh.into_iter().chain(mie) {
            if !(beta >= 0.0 && beta.is_finite()) {
                let what = "a scattering coefficient";
                return Err(Error::bad_value(what, beta, "at least 0 and finite"));
            }
        }
        for (rayleigh, mie) in rayleigh.into_iter().zip(mie) {
            if (rayleigh + mie).is_infinite() {
                let what = "the sum of two scattering coefficients";
                return Err(Error::bad_value(what, f32::INFINITY, "a finite number"));
            }
        }
        PhaseFunction::HenyeyGreenstein { g }.checked()?;
        Ok(Self { rayleigh, mie, g })
    }

    /// Radiance scattered towards the eye over the first `distance` metres:
    ///
    /// ```text
    /// L_in = E (β_R(θ) + β_M(θ)) / (β_R + β_M) · (1 − exp(−(β_R + β_M) x))
    /// ```
    ///
    /// for the irradiance `E` on a plane that faces the sun.
    pub fn in_scattered(
        &self,
        irradiance: [f32; 3],
        angle: ScatteringAngle<f32>,
        distance: f32,
    ) -> [f32; 3] {
        let molecules = PhaseFunction::Rayleigh.value(angle);
        let dust = PhaseFunction::HenyeyGreenstein { g: self.g }.value(angle);
        std::array::from_fn(|c| {
            let scattered = self.rayleigh[c] * molecules + self.mie[c] * dust;
            let extinction = self.rayleigh[c] + self.mie[c];
            irradiance[c] * scattered * open_air(extinction, 0.0, distance)
        })
    }

    /// Share of the light from `distance` metres away that arrives,
    /// `exp(−(β_R + β_M) x)`; 1 for what is no distance.
    pub fn transmittance(&self, distance: f32) -> [f32; 3] {
        std::array::from_fn(|c| {
            let extinction = self.rayleigh[c] + self.mie[c];
            if extinction > 0.0 {
                (-extinction * distance.max(0.0)).exp()
            } else {
                1.0
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    #[test]
    fn long_and_senseless_ways_have_a_result() {
        assert_eq!(open_air(2.0_f32, 0.0, f32::MAX), 0.5);
        assert_eq!(open_air(1e10_f32, 0.0, 1e30), 1e-10);
        assert_eq!(open_air(0.0_f32, 0.0, f32::MAX), f32::MAX);
        let bad = [f32::NAN, f32::INFINITY, -1.0];
        for value in bad {
            assert_eq!(open_air(value, 0.0, 1.0), 0.0);
            assert_eq!(open_air(1.0, value, 1.0), 0.0);
        }
        assert_eq!(open_air(1.0_f32, 0.0, f32::NAN), 0.0);
        assert_eq!(between(f32::NAN, 1.0, 1.0), 0.0);
        assert!(Daylight::new([f32::MAX; 3], [f32::MAX; 3], 0.0).is_err());
        let air = Daylight::new([1.0; 3], [1.0; 3], 0.0).unwrap();
        assert_eq!(air.transmittance(-1e9), [1.0; 3]);
        let angle = ScatteringAngle::from_cos(0.0);
        assert!(air.in_scattered([1.0; 3], angle, f32::MAX)[0] > 0.0);
    }

    proptest! {
        #![proptest_config(reference::property::cases(256))]

        #[test]
        fn both_precisions_agree_and_parts_add_up(
            sigma in (-14.0_f64..3.0).prop_map(f64::exp),
            x in 0.0_f64..10.0,
            length in (-14.0_f64..5.0).prop_map(f64::exp),
            share in 0.0..1.0_f64,
        ) {
            let whole = open_air(sigma, x, length);
            let parts = open_air(sigma, x, share * length)
                + open_air(sigma, x + share * length, length - share * length);
            // Rounding of the exponents, which are below 4000.
            let error = (8.0 + sigma * (x + length)) * f64::EPSILON;
            prop_assert!((parts - whole).abs() <= error * whole);
            let far = sigma * (x + length);
            let linear = between(sigma * x, far, length);
            // The difference of the depths loses what they have in common.
            let lost = 4.0 * f64::EPSILON * (1.0 + far);
            prop_assert!((linear - whole).abs() <= lost * whole);
            prop_assert_eq!(linear, between(far, sigma * x, length));
            prop_assert!(whole <= open_air(sigma, x, f64::INFINITY) * (1.0 + error));
            let single = f64::from(open_air(sigma as f32, x as f32, length as f32));
            let error = f64::from(f32::EPSILON) * (8.0 + 2.0 * sigma * x);
            prop_assert!(whole < 1e-37 || (single / whole - 1.0).abs() < error);
        }
    }

    #[test]
    fn limits_are_finite() {
        assert_eq!(open_air(0.0, 3.0, 2.0), 2.0);
        assert_eq!(open_air(0.0, 3.0, f64::INFINITY), 0.0);
        assert_eq!(open_air(0.5, 0.0, f64::INFINITY), 2.0);
        assert_eq!(open_air(0.5, 3.0, 0.0), 0.0);
        assert_eq!(open_air(f32::NAN, 3.0, 1.0), 0.0);
        assert_eq!(open_air(0.5, f32::INFINITY, 1.0), 0.0);
        assert_eq!(between(1e6, 0.0, 3.0), 3e-6);
        assert_eq!(between(0.0, f64::INFINITY, 3.0), 0.0);
        assert_eq!(between(f64::INFINITY, f64::INFINITY, 3.0), 0.0);
        assert_eq!(between(0.25, 0.25, 3.0), 3.0 * (-0.25_f64).exp());
    }

    #[test]
    fn single_precision_keeps_its_digits_up_to_an_optical_depth_of_87_and_is_sound_beyond() {
        // Lengths up to the largest: beyond the domain, the product of one with an exponential
        // that is no normal number is one again, with the few digits that are left.
        for depth in [0.0, 1.0, 86.5, 87.0_f32] {
            for further in [0.0, 1e-3, 1.0, 1e3] {
                for length in [1e-3, 1.0, 1e30_f32] {
                    let ends = [f64::from(depth), f64::from(depth) + further];
                    let truth = between(ends[0], ends[1], length.into());
                    let found = between(ends[1] as f32, depth, length);
                    let error = f64::from(f32::EPSILON) * (8.0 + 2.0 * ends[0]);
                    // Numbers that are not normal have fewer digits.
                    let is_normal = truth >= f64::from(f32::MIN_POSITIVE);
                    assert!(
                        !is_normal || (f64::from(found) / truth - 1.0).abs() <= error,
                        "{found:e} for {truth:e}, {depth} {further} {length:e}"
                    );
                    assert_eq!(found, between(depth, ends[1] as f32, length));
                }
            }
        }
        for depth in [87.5_f32, 100.0, 104.0, 1e4, f32::MAX] {
            let found = between(depth, depth, f32::MAX);
            let truth = between(f64::from(depth), f64::from(depth), f32::MAX.into());
            // Two of the steps of numbers below the normal ones, times the length.
            let step = f64::from(f32::from_bits(1)) * f64::from(f32::MAX);
            assert!(
                (f64::from(found) - truth).abs() <= 2.0 * step,
                "{found:e} for {truth:e}"
            );
            assert!(found >= 0.0 && between(depth, f32::INFINITY, f32::MAX) == 0.0);
        }
    }

    #[test]
    fn daylight_is_the_sum_of_both_scatterers() {
        let air = Daylight::new([5.8e-6, 13.5e-6, 33.1e-6], [2e-5; 3], 0.8).unwrap();
        let angle = ScatteringAngle::from_cos(0.3);
        let light = air.in_scattered([1.0, 2.0, 3.0], angle, 1e4);
        for (c, beta) in [5.8e-6, 13.5e-6, 33.1e-6].into_iter().enumerate() {
            let molecules = 3.0 / (16.0 * PI) * beta * (1.0 + 0.09);
            let base: f64 = 1.0 + 0.64 - 1.6 * 0.3;
            let dust = 2e-5 * 0.36 / (4.0 * PI * base.powf(1.5));
            let beta = beta + 2e-5;
            let expected =
                (c as f64 + 1.0) * (molecules + dust) / beta * (1.0 - (-beta * 1e4).exp());
            assert!((f64::from(light[c]) / expected - 1.0).abs() < 1e-6);
            let through = f64::from(air.transmittance(1e4)[c]);
            assert!((through / (-beta * 1e4).exp() - 1.0).abs() < 1e-6);
        }
        // An endless clear sky is as bright as everything that is scattered.
        let sky = air.in_scattered([1.0; 3], angle, f32::INFINITY);
        assert!(sky.iter().all(|value| value.is_finite() && *value > 0.0));
    }

    #[test]
    fn vacuum_is_dark_and_bad_coefficients_are_named() {
        let vacuum = Daylight::new([0.0; 3], [0.0; 3], 0.0).unwrap();
        let angle = ScatteringAngle::from_cos(0.3);
        assert_eq!(
            vacuum.in_scattered([1.0; 3], angle, f32::INFINITY),
            [0.0; 3]
        );
        assert_eq!(vacuum.transmittance(f32::INFINITY), [1.0; 3]);
        assert!(Daylight::new([-1.0, 0.0, 0.0], [0.0; 3], 0.0).is_err());
        assert!(Daylight::new([0.0; 3], [f32::NAN; 3], 0.0).is_err());
        assert!(Daylight::new([0.0; 3], [0.0; 3], 1.0).is_err());
    }
}

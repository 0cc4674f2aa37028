//! How scattered light spreads over directions.

use std::f64::consts::PI;

use crate::{Error, Real, ScatteringAngle};

/// A phase function p(cos θ), 1/sr, normalised over the sphere.
///
/// Implemented by [`PhaseFunction`] and by closures from an angle to 1/sr; a
/// type of one's own can also say how narrow its peaks are.
pub trait Phase: Sync {
    /// p in 1/sr: finite and not negative.
    fn value_f64(&self, angle: ScatteringAngle<f64>) -> f64;

    /// The same in single precision.
    fn value_f32(&self, angle: ScatteringAngle<f32>) -> f32 {
        self.value_f64(angle.into()) as f32
    }

    /// The widths of the forward and the backward peak, as `tan(θ/2)` and
    /// `tan((π−θ)/2)` within which p varies slowly; 1 is no peak at all.
    /// Quadratures place their nodes by them.
    fn peaks(&self) -> [f64; 2] {
        [1.0, 1.0]
    }

    /// How many times as large as for Henyey–Greenstein's function the error of
    /// a quadrature is whose nodes were placed by [`peaks`](Phase::peaks): more
    /// than 1 if the function falls more steeply beside a peak. See
    /// [`Quadrature::with_tolerance`](crate::Quadrature::with_tolerance).
    fn steepness(&self) -> f64 {
        1.0
    }

    /// The value, if it is the same for all angles.
    fn constant(&self) -> Option<f64> {
        None
    }

    /// Whether the parameters are in range.
    ///
    /// # Errors
    /// [`Error::BadValue`] if they are not.
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }
}

impl<F: Fn(ScatteringAngle<f64>) -> f64 + Sync> Phase for F {
    fn value_f64(&self, angle: ScatteringAngle<f64>) -> f64 {
        self(angle)
    }
}

/// A phase function in closed form; `cos θ = 1` is light that goes straight
/// on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum PhaseFunction {
    /// `1 / 4π`.
    #[default]
    Isotropic,
    /// `(1 − g²) / (4π (1 + g² − 2 g cos θ)^{3/2})`, |g| < 1: haze and dust.
    /// Henyey and Greenstein, Diffuse radiation in the galaxy, 1941.
    HenyeyGreenstein {
        /// Mean cosine.
        g: f32,
    },
    /// `3 (1 + cos² θ) / 16π`: particles much smaller than the wavelength.
    Rayleigh,
    /// `(1 − k²) / (4π (1 − k cos θ)²)`, |k| < 1: Henyey–Greenstein without
    /// a root; `k = 1.55 g − 0.55 g³` is near it. Blasi, Le Saëc and Schlick,
    /// A rendering algorithm for discrete volume density objects, 1993.
    Schlick {
        /// Eccentricity.
        k: f32,
    },
    /// `3 (1 − g²) (1 + cos² θ) / (8π (2 + g²) (1 + g² − 2 g cos θ)^{3/2})`,
    /// |g| < 1: Rayleigh for g = 0, peaked like Henyey–Greenstein otherwise.
    /// Cornette and Shanks, Physically reasonable analytic expression for the
    /// single-scattering phase function, 1992.
    CornetteShanks {
        /// Asymmetry; the mean cosine is `3 g (4 + g²) / (5 (2 + g²))`.
        g: f32,
    },
}

impl PhaseFunction {
    /// The same function, if its parameter is in range.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless -1 < g < 1 and -1 < k < 1.
    pub fn checked(self) -> Result<Self, Error> {
        let (what, value) = match self {
            Self::Isotropic | Self::Rayleigh => return Ok(self),
            Self::HenyeyGreenstein { g } => ("g of the Henyey-Greenstein phase function", g),
            Self::Schlick { k } => ("k of the Schlick phase function", k),
            Self::CornetteShanks { g } => ("g of the Cornette-Shanks phase function", g),
        };
        if value.abs() < 1.0 {
            Ok(self)
        } else {
            let expected = "a number between -1 and 1, both excluded";
            Err(Error::bad_value(what, value, expected))
        }
    }

    /// p(cos θ) in 1/sr, for a parameter in range, to a few units of the last
    /// digit at every angle.
    pub fn value<T: Real>(self, angle: ScatteringAngle<T>) -> T {
        let one = T::from(1.0);
        match self {
            Self::Isotropic => T::of(0.25 / PI),
            Self::HenyeyGreenstein { g } => T::of(0.25 / PI) * henyey_greenstein(g.into(), angle),
            Self::Rayleigh => {
                let cos = angle.cos();
                T::of(3.0 / (16.0 * PI)) * (one + cos * cos)
            }
            Self::Schlick { k } => {
                // 1 − k cos θ, without cancellation at either peak.
                let k = T::from(k);
                let distance = if k >= T::from(0.0) {
                    (one - k) + k * angle.one_minus_cos()
                } else {
                    (one + k) - k * angle.one_plus_cos()
                };
                T::of(0.25 / PI) * ((one - k) * (one + k)) / (distance * distance)
            }
            Self::CornetteShanks { g } => {
                let (g, cos) = (T::from(g), angle.cos());
                let rayleigh = (one + cos * cos) / (T::from(2.0) + g * g);
                T::of(3.0 / (8.0 * PI)) * rayleigh * henyey_greenstein(g, angle)
            }
        }
    }

    /// The mean of cos θ, `∫ p cos θ dω`: 0 if as much light is scattered
    /// backward as forward.
    pub fn mean_cosine(self) -> f32 {
        match self {
            Self::Isotropic | Self::Rayleigh => 0.0,
            Self::HenyeyGreenstein { g } => g,
            Self::Schlick { k } => schlick_mean(k.into()) as f32,
            Self::CornetteShanks { g } => {
                let g = f64::from(g);
                (0.6 * g * (4.0 + g * g) / (2.0 + g * g)) as f32
            }
        }
    }
}

impl Phase for PhaseFunction {
    fn value_f64(&self, angle: ScatteringAngle<f64>) -> f64 {
        self.value(angle)
    }

    fn value_f32(&self, angle: ScatteringAngle<f32>) -> f32 {
        self.value(angle)
    }

    fn peaks(&self) -> [f64; 2] {
        // Where the functions of tan(θ/2) have their poles.
        let (eccentricity, width) = match *self {
            Self::Isotropic | Self::Rayleigh => return [1.0, 1.0],
            Self::HenyeyGreenstein { g } | Self::CornetteShanks { g } => {
                let g = f64::from(g);
                (g, (1.0 - g.abs()) / (1.0 + g.abs()))
            }
            Self::Schlick { k } => {
                let k = f64::from(k);
                (k, ((1.0 - k.abs()) / (1.0 + k.abs())).sqrt())
            }
        };
        if eccentricity >= 0.0 {
            [width, 1.0]
        } else {
            [1.0, width]
        }
    }

    fn steepness(&self) -> f64 {
        // With `tan(θ/2) = b` and the inverse square they fall beside a sharp peak
        // like (1 + b²) / b⁴ and (1 + b⁴) / (b³ (1 + b²)^{3/2}), where
        // Henyey–Greenstein's does like (1 + b²)^{1/2} / b³. Measured: 2.5 and 1.3
        // times the error. Towards its backward peak Schlick's grows more steeply, too:
        // 1.7 times the error at k = −0.9999.
        match *self {
            Self::Schlick { k } if k > 0.0 => 4.0,
            Self::Schlick { k } if k < 0.0 => 3.0,
            Self::CornetteShanks { g } if g > 0.0 => 2.0,
            _ => 1.0,
        }
    }

    fn constant(&self) -> Option<f64> {
        match *self {
            Self::Isotropic | Self::HenyeyGreenstein { g: 0.0 } | Self::Schlick { k: 0.0 } => {
                Some(0.25 / PI)
            }
            _ => None,
        }
    }

    fn check(&self) -> Result<(), Error> {
        self.checked().map(|_| ())
    }
}

/// `(1 − g²) / (1 + g² − 2 g cos θ)^{3/2}`.
fn henyey_greenstein<T: Real>(g: T, angle: ScatteringAngle<T>) -> T {
    let one = T::from(1.0);
    let two = T::from(2.0);
    // 1 + g² − 2 g cos θ, without cancellation at either peak.
    let distance2 = if g >= T::from(0.0) {
        (one - g) * (one - g) + two * g * angle.one_minus_cos()
    } else {
        (one + g) * (one + g) - two * g * angle.one_plus_cos()
    };
    ((one - g) * (one + g)) / (distance2 * distance2.square_root())
}

/// `1/k − (1 − k²) artanh(k) / k²`.
fn schlick_mean(k: f64) -> f64 {
    if k.abs() > 0.1 {
        return 1.0 / k - (1.0 - k) * (1.0 + k) * k.atanh() / (k * k);
    }
    // Its series, whose terms fall by 100 each: Σ 2 k^{2m−1} / (4m² − 1).
    let mut power = k;
    let mut sum = 0.0;
    for m in 1..9 {
        sum += 2.0 * power / f64::from(4 * m * m - 1);
        power *= k * k;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// ∫ p(cos θ) f(cos θ) dω by the midpoint rule in ln tan(θ/2), in which
    /// peaks are as wide as anything else and the integrand falls to 0 at
    /// both ends: the rule converges exponentially.
    fn moment(phase: PhaseFunction, f: impl Fn(f64) -> f64) -> f64 {
        let steps = 2000;
        let step = 80.0 / f64::from(steps);
        (0..steps)
            .map(|i| ((f64::from(i) + 0.5) * step - 40.0).exp())
            .map(|c| {
                // d cos θ = 4 c² / (1 + c²)² d ln c
                let angle = ScatteringAngle::from_half_tangent(c, 1.0);
                let measure = angle.one_minus_cos() * angle.one_plus_cos();
                2.0 * PI * phase.value(angle) * f(angle.cos()) * measure * step
            })
            .sum()
    }

    fn any_phase() -> impl Strategy<Value = PhaseFunction> {
        let parameter = || {
            // 1 − |g| is log-uniform down to one unit of the last digit.
            (any::<bool>(), -16.6_f64..0.0).prop_map(|(back, log)| {
                let g = 1.0 - (log.exp() as f32).max(f32::EPSILON / 2.0);
                if back { -g } else { g }
            })
        };
        prop_oneof![
            Just(PhaseFunction::Isotropic),
            Just(PhaseFunction::Rayleigh),
            parameter().prop_map(|g| PhaseFunction::HenyeyGreenstein { g }),
            parameter().prop_map(|k| PhaseFunction::Schlick { k }),
            parameter().prop_map(|g| PhaseFunction::CornetteShanks { g }),
            (-1e-3_f32..1e-3).prop_map(|k| PhaseFunction::Schlick { k }),
        ]
    }

    proptest! {
        #![proptest_config(reference::property::cases(256))]

        #[test]
        fn every_function_is_normalised_and_has_its_mean_cosine(phase in any_phase()) {
            prop_assert_eq!(phase.checked(), Ok(phase));
            let total = moment(phase, |_| 1.0);
            prop_assert!((total - 1.0).abs() < 1e-12, "{} {:?}", total, phase);
            let mean = moment(phase, |cos| cos);
            // The mean itself is rounded to f32.
            prop_assert!((mean - f64::from(phase.mean_cosine())).abs() < 6e-8, "{} {:?}", mean, phase);
        }

        #[test]
        fn single_precision_keeps_its_digits_at_sharp_peaks(
            phase in any_phase(),
            tangent in (-30.0_f32..30.0).prop_map(f32::exp),
        ) {
            let (rough, fine) = if tangent < 1.0 {
                (ScatteringAngle::from_half_tangent(tangent, 1.0),
                 ScatteringAngle::from_half_tangent(f64::from(tangent), 1.0))
            } else {
                (ScatteringAngle::from_half_tangent(1.0, 1.0 / tangent),
                 ScatteringAngle::from_half_tangent(1.0, f64::from(1.0 / tangent)))
            };
            let (rough, fine) = (f64::from(phase.value(rough)), phase.value(fine));
            // Some 20 roundings, each of half a unit of the last digit.
            let allowed = 10.0 * f64::from(f32::EPSILON);
            prop_assert!((rough / fine - 1.0).abs() < allowed, "{} {} {:?}", rough, fine, phase);
        }
    }

    #[test]
    fn peaks_have_their_known_heights() {
        let forward = ScatteringAngle::from_cos(1.0_f64);
        let g = f64::from(0.9_f32);
        let phase = PhaseFunction::HenyeyGreenstein { g: 0.9 };
        let height = (1.0 + g) / (4.0 * PI * (1.0 - g) * (1.0 - g));
        assert!((phase.value(forward) / height - 1.0).abs() < 1e-14);
        let phase = PhaseFunction::Schlick { k: 0.9 };
        let height = (1.0 + g) / (4.0 * PI * (1.0 - g));
        assert!((phase.value(forward) / height - 1.0).abs() < 1e-14);
        let rayleigh = PhaseFunction::Rayleigh.value(forward);
        let cornette = PhaseFunction::CornetteShanks { g: 0.0 }.value(forward);
        assert!((rayleigh - cornette).abs() < 1e-16);
    }

    #[test]
    fn parameters_out_of_range_are_named() {
        for bad in [1.0, -1.0, 2.0, f32::NAN, f32::INFINITY] {
            assert!(
                PhaseFunction::HenyeyGreenstein { g: bad }
                    .checked()
                    .is_err()
            );
            assert!(PhaseFunction::CornetteShanks { g: bad }.check().is_err());
            let error = PhaseFunction::Schlick { k: bad }.checked().unwrap_err();
            assert!(error.to_string().starts_with("k of the Schlick"), "{error}");
        }
    }

    #[test]
    fn a_closure_is_a_phase_function() {
        let linear = |angle: ScatteringAngle<f64>| (1.0 + 0.5 * angle.cos()) / (4.0 * PI);
        let value = linear.value_f32(ScatteringAngle::from_cos(1.0));
        assert!((f64::from(value) - 1.5 / (4.0 * PI)).abs() < 1e-8);
        assert_eq!(linear.constant(), None);
        assert_eq!(PhaseFunction::Isotropic.constant(), Some(0.25 / PI));
    }
}

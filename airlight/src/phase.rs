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

    /// [`Phase::value_f64`] of many angles, of which there are as many as values. A
    /// function whose loop is `#[inline(always)]` is compiled for the vector
    /// instructions of the loops around it.
    #[inline(always)]
    fn values_f64(&self, angles: &[ScatteringAngle<f64>], values: &mut [f64]) {
        for (value, angle) in values.iter_mut().zip(angles) {
            *value = self.value_f64(*angle);
        }
    }

    /// The same in single precision.
    #[inline(always)]
    fn values_f32(&self, angles: &[ScatteringAngle<f32>], values: &mut [f32]) {
        for (value, angle) in values.iter_mut().zip(angles) {
            *value = self.value_f32(*angle);
        }
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
    /// `w H(g₀) + (1 − w) H(g₁)` of two functions of Henyey and Greenstein: a
    /// forward and a backward lobe, as dust and clouds have them. Kattawar, A
    /// three-parameter analytic phase function for multiple scattering
    /// calculations, 1975.
    DoubleHenyeyGreenstein {
        /// Mean cosine of each lobe, |g| < 1.
        g: [f32; 2],
        /// The share `w` of the first lobe, 0 to 1.
        weight: f32,
    },
    /// `(1 − w) H(g) + w D(g_D, α)` of Henyey and Greenstein's function and
    /// Draine's,
    ///
    /// ```text
    /// D = (1 − g²) (1 + α cos² θ) / (4π (1 + α (1 + 2 g²)/3) (1 + g² − 2 g cos θ)^{3/2})
    /// ```
    ///
    /// which near the [droplets](PhaseFunction::droplets) of fog. Jendersie and
    /// d'Eon, An approximate Mie scattering function for fog and cloud rendering,
    /// 2023.
    HenyeyGreensteinDraine {
        /// Mean cosine of Henyey and Greenstein's function, |g| < 1.
        g: f32,
        /// Asymmetry `g_D` of Draine's, |g_D| < 1.
        draine_g: f32,
        /// `α`, 0 to 1e6: 0 is Henyey and Greenstein's function once more, 1 that of
        /// Cornette and Shanks.
        alpha: f32,
        /// The share `w` of Draine's function, 0 to 1.
        weight: f32,
    },
}

impl PhaseFunction {
    /// Fog of droplets of water with a `diameter` of 5 to 50 µm: the fit of
    /// Jendersie and d'Eon to Mie's theory for visible light, as
    /// [`HenyeyGreensteinDraine`](PhaseFunction::HenyeyGreensteinDraine). The glory,
    /// the bow and the diffraction rings are left out.
    ///
    /// # Errors
    /// [`Error::BadValue`] for any other diameter.
    pub fn droplets(diameter: f32) -> Result<Self, Error> {
        if !(5.0..=50.0).contains(&diameter) {
            let what = "the diameter of droplets";
            return Err(Error::bad_value(what, diameter, "5 to 50 micrometres"));
        }
        // The constants are those of the paper's equations 4 to 7.
        let d = f64::from(diameter);
        Ok(Self::HenyeyGreensteinDraine {
            g: (-0.099_056_7 / (d - 1.671_54)).exp() as f32,
            draine_g: (-2.206_79 / (d + 3.910_29) - 0.428_934).exp() as f32,
            alpha: (3.624_89 - 8.292_88 / (d + 5.528_25)).exp() as f32,
            weight: (-0.599_085 / (d - 0.641_583) - 0.665_888).exp() as f32,
        })
    }

    /// The same function, if its parameters are in range.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless every g and k is between -1 and 1, weights are
    /// from 0 to 1 and `alpha` from 0 to 1e6.
    pub fn checked(self) -> Result<Self, Error> {
        let asymmetry = |what, value: f32| {
            if value.abs() < 1.0 {
                return Ok(());
            }
            let expected = "a number between -1 and 1, both excluded";
            Err(Error::bad_value(what, value, expected))
        };
        let share = |what, value: f32| {
            if (0.0..=1.0).contains(&value) {
                return Ok(());
            }
            Err(Error::bad_value(what, value, "a share from 0 to 1"))
        };
        match self {
            Self::Isotropic | Self::Rayleigh => {}
            Self::HenyeyGreenstein { g } => {
                asymmetry("g of the Henyey-Greenstein phase function", g)?;
            }
            Self::Schlick { k } => asymmetry("k of the Schlick phase function", k)?,
            Self::CornetteShanks { g } => {
                asymmetry("g of the Cornette-Shanks phase function", g)?;
            }
            Self::DoubleHenyeyGreenstein { g, weight } => {
                for g in g {
                    asymmetry("g of a double Henyey-Greenstein phase function", g)?;
                }
                share("the weight of the first lobe of a phase function", weight)?;
            }
            Self::HenyeyGreensteinDraine {
                g,
                draine_g,
                alpha,
                weight,
            } => {
                asymmetry("g of a Henyey-Greenstein and Draine phase function", g)?;
                asymmetry("g of the Draine phase function", draine_g)?;
                share("the weight of the Draine phase function", weight)?;
                if !(0.0..=1e6).contains(&alpha) {
                    let what = "alpha of the Draine phase function";
                    return Err(Error::bad_value(what, alpha, "a number from 0 to 1e6"));
                }
            }
        }
        Ok(self)
    }

    /// p(cos θ) in 1/sr, for parameters in range, to a few units of the last
    /// digit at every angle.
    #[inline(always)]
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
            Self::DoubleHenyeyGreenstein { g, weight } => {
                let [first, second] = g.map(|g| henyey_greenstein(T::from(g), angle));
                let weight = T::from(weight);
                T::of(0.25 / PI) * (weight * first + (one - weight) * second)
            }
            Self::HenyeyGreensteinDraine {
                g,
                draine_g,
                alpha,
                weight,
            } => {
                let (weight, cos) = (T::from(weight), angle.cos());
                let (alpha, draine_g) = (T::from(alpha), T::from(draine_g));
                let norm =
                    one + alpha * (one + T::from(2.0) * draine_g * draine_g) * T::of(1.0 / 3.0);
                let across = (one + alpha * cos * cos) / norm;
                let draine = across * henyey_greenstein(draine_g, angle);
                let forward = henyey_greenstein(T::from(g), angle);
                T::of(0.25 / PI) * ((one - weight) * forward + weight * draine)
            }
        }
    }

    /// The values of many angles: a loop for each function, which the compiler then
    /// turns into vectors.
    #[inline(always)]
    fn values<T: Real>(self, angles: &[ScatteringAngle<T>], values: &mut [T]) {
        match self {
            Self::Isotropic => Self::Isotropic.loop_over(angles, values),
            Self::HenyeyGreenstein { g } => {
                Self::HenyeyGreenstein { g }.loop_over(angles, values);
            }
            Self::Rayleigh => Self::Rayleigh.loop_over(angles, values),
            Self::Schlick { k } => Self::Schlick { k }.loop_over(angles, values),
            Self::CornetteShanks { g } => Self::CornetteShanks { g }.loop_over(angles, values),
            Self::DoubleHenyeyGreenstein { g, weight } => {
                Self::DoubleHenyeyGreenstein { g, weight }.loop_over(angles, values);
            }
            Self::HenyeyGreensteinDraine {
                g,
                draine_g,
                alpha,
                weight,
            } => {
                let phase = Self::HenyeyGreensteinDraine {
                    g,
                    draine_g,
                    alpha,
                    weight,
                };
                phase.loop_over(angles, values);
            }
        }
    }

    #[inline(always)]
    fn loop_over<T: Real>(self, angles: &[ScatteringAngle<T>], values: &mut [T]) {
        for (value, angle) in values.iter_mut().zip(angles) {
            *value = self.value(*angle);
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
            Self::DoubleHenyeyGreenstein { g, weight } => {
                let ([first, second], weight) = (g.map(f64::from), f64::from(weight));
                (weight * first + (1.0 - weight) * second) as f32
            }
            Self::HenyeyGreensteinDraine {
                g,
                draine_g,
                alpha,
                weight,
            } => {
                let [g, draine_g, alpha, weight] = [g, draine_g, alpha, weight].map(f64::from);
                let square = draine_g * draine_g;
                let draine = draine_g * (1.0 + alpha * (3.0 + 2.0 * square) / 5.0)
                    / (1.0 + alpha * (1.0 + 2.0 * square) / 3.0);
                ((1.0 - weight) * g + weight * draine) as f32
            }
        }
    }

    /// The asymmetries of its Henyey–Greenstein factors that have any weight.
    fn lobes(self) -> [f32; 2] {
        let (g, weight) = match self {
            Self::DoubleHenyeyGreenstein { g, weight } => (g, weight),
            Self::HenyeyGreensteinDraine {
                g,
                draine_g,
                weight,
                ..
            } => ([draine_g, g], weight),
            Self::HenyeyGreenstein { g } | Self::CornetteShanks { g } => return [g, g],
            Self::Isotropic | Self::Rayleigh | Self::Schlick { .. } => return [0.0; 2],
        };
        match weight {
            0.0 => [g[1]; 2],
            1.0 => [g[0]; 2],
            _ => g,
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

    #[inline(always)]
    fn values_f64(&self, angles: &[ScatteringAngle<f64>], values: &mut [f64]) {
        self.values(angles, values);
    }

    #[inline(always)]
    fn values_f32(&self, angles: &[ScatteringAngle<f32>], values: &mut [f32]) {
        self.values(angles, values);
    }

    fn peaks(&self) -> [f64; 2] {
        // Where the functions of tan(θ/2) have their poles.
        if let Self::Schlick { k } = *self {
            let k = f64::from(k);
            let width = ((1.0 - k.abs()) / (1.0 + k.abs())).sqrt();
            return if k >= 0.0 { [width, 1.0] } else { [1.0, width] };
        }
        let mut peaks = [1.0_f64; 2];
        for g in self.lobes().map(f64::from) {
            let side = usize::from(g < 0.0);
            peaks[side] = peaks[side].min((1.0 - g.abs()) / (1.0 + g.abs()));
        }
        peaks
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
            // Beside its peak Draine's factor falls by as much as 1 + α.
            Self::HenyeyGreensteinDraine { .. } => 4.0,
            _ => 1.0,
        }
    }

    fn constant(&self) -> Option<f64> {
        match *self {
            Self::Isotropic | Self::HenyeyGreenstein { g: 0.0 } | Self::Schlick { k: 0.0 } => {
                Some(0.25 / PI)
            }
            Self::DoubleHenyeyGreenstein { .. } if self.lobes() == [0.0; 2] => Some(0.25 / PI),
            _ => None,
        }
    }

    fn check(&self) -> Result<(), Error> {
        self.checked().map(|_| ())
    }
}

/// `(1 − g²) / (1 + g² − 2 g cos θ)^{3/2}`.
#[inline(always)]
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
            (parameter(), parameter(), 0.0_f32..=1.0).prop_map(|(a, b, weight)| {
                PhaseFunction::DoubleHenyeyGreenstein { g: [a, b], weight }
            }),
            (parameter(), parameter(), -9.0_f32..9.0, 0.0_f32..=1.0).prop_map(
                |(g, draine_g, log, weight)| PhaseFunction::HenyeyGreensteinDraine {
                    g,
                    draine_g,
                    alpha: log.exp(),
                    weight,
                }
            ),
            (5.0_f32..=50.0).prop_map(|d| PhaseFunction::droplets(d).unwrap()),
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
    fn mixtures_of_one_lobe_are_that_lobe() {
        for tangent in [0.0, 0.1, 0.7, 1.0, 5.0, 1e6] {
            let angle = ScatteringAngle::from_half_tangent(tangent, 1.0);
            let near = |a: PhaseFunction, b: PhaseFunction| {
                let (a, b): (f64, f64) = (a.value(angle), b.value(angle));
                assert!((a / b - 1.0).abs() < 1e-14, "{a} {b}");
            };
            let double = |g, weight| PhaseFunction::DoubleHenyeyGreenstein { g, weight };
            let single = PhaseFunction::HenyeyGreenstein { g: 0.6 };
            near(double([0.6, -0.9], 1.0), single);
            near(double([-0.9, 0.6], 0.0), single);
            near(double([0.6, 0.6], 0.3), single);
            let draine = |draine_g, alpha, weight| PhaseFunction::HenyeyGreensteinDraine {
                g: 0.6,
                draine_g,
                alpha,
                weight,
            };
            near(draine(-0.3, 8.0, 0.0), single);
            near(draine(0.6, 0.0, 0.5), single);
            near(
                draine(0.7, 1.0, 1.0),
                PhaseFunction::CornetteShanks { g: 0.7 },
            );
            near(draine(0.0, 1.0, 1.0), PhaseFunction::Rayleigh);
        }
        let even = PhaseFunction::DoubleHenyeyGreenstein {
            g: [0.0, 0.5],
            weight: 1.0,
        };
        assert_eq!((even.constant(), even.peaks()), (Some(0.25 / PI), [1.0; 2]));
    }

    #[test]
    fn larger_droplets_scatter_more_sharply_forward() {
        let forward = ScatteringAngle::from_cos(1.0_f64);
        let (mut height, mut mean) = (0.0, 0.0);
        for diameter in [5.0, 8.0, 13.0, 21.0, 34.0, 50.0] {
            let phase = PhaseFunction::droplets(diameter).unwrap();
            assert_eq!(phase.checked(), Ok(phase));
            assert!(phase.value(forward) > height && phase.mean_cosine() > mean);
            (height, mean) = (phase.value(forward), phase.mean_cosine());
        }
        // Mie's theory has 0.85 to 0.87 for the droplets of clouds.
        assert!((0.84..0.9).contains(&mean), "{mean}");
        for diameter in [4.9, 50.1, f32::NAN] {
            let error = PhaseFunction::droplets(diameter).unwrap_err();
            assert!(error.to_string().contains("micrometres"), "{error}");
        }
    }

    #[test]
    fn parameters_out_of_range_are_named() {
        for (g, weight, cause) in [
            ([0.0, 1.0], 0.5, "double Henyey-Greenstein"),
            ([f32::NAN, 0.0], 0.5, "is NaN"),
            ([0.0; 2], -0.1, "weight"),
            ([0.0; 2], f32::NAN, "weight"),
        ] {
            let phase = PhaseFunction::DoubleHenyeyGreenstein { g, weight };
            let error = phase.checked().unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
        for (g, draine_g, alpha, weight, cause) in [
            (1.0, 0.0, 1.0, 0.5, "g of a Henyey-Greenstein and Draine"),
            (0.0, -1.0, 1.0, 0.5, "g of the Draine"),
            (0.0, 0.0, -1.0, 0.5, "alpha"),
            (0.0, 0.0, f32::INFINITY, 0.5, "alpha"),
            (0.0, 0.0, 1.0, 1.5, "weight"),
        ] {
            let phase = PhaseFunction::HenyeyGreensteinDraine {
                g,
                draine_g,
                alpha,
                weight,
            };
            let error = phase.checked().unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
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

//! Phase functions in f64.

use std::f64::consts::PI;

/// How scattered light spreads over directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phase {
    /// `1/(4π)`.
    Isotropic,
    /// `3 (1 + cos² θ) / (16π)`.
    Rayleigh,
    /// `(1 − g²) / (4π (1 + g² − 2g cos θ)^{3/2})`, −1 < g < 1.
    HenyeyGreenstein {
        /// Mean cosine.
        g: f64,
    },
    /// `(1 − k²) / (4π (1 − k cos θ)²)`, −1 < k < 1.
    Schlick {
        /// Steepness.
        k: f64,
    },
    /// Henyey and Greenstein's times `3 (1 + cos² θ) / (2 (2 + g²))`.
    CornetteShanks {
        /// The asymmetry of the first factor.
        g: f64,
    },
    /// The weighted mean of two of Henyey and Greenstein's, 0 ≤ weight ≤ 1.
    Double {
        /// Mean cosines.
        g: [f64; 2],
        /// Share of the first.
        weight: f64,
    },
    /// The weighted mean of Henyey and Greenstein's and Draine's, which is the
    /// former times `(1 + α cos² θ) / (1 + α (1 + 2g²)/3)`.
    Draine {
        /// Mean cosine of the former.
        g: f64,
        /// Asymmetry of Draine's.
        draine_g: f64,
        /// How much more is scattered along the line of the light than across it.
        alpha: f64,
        /// Share of Draine's.
        weight: f64,
    },
}

impl Phase {
    /// The value in 1/sr for `sin²(θ/2)` and `cos²(θ/2)` of the angle θ
    /// between the directions before and after scattering. Half angles keep
    /// the digits of both peaks.
    pub fn at(self, sin2: f64, cos2: f64) -> f64 {
        match self {
            Self::Isotropic => 1.0 / (4.0 * PI),
            Self::Rayleigh => 3.0 * (1.0 + (cos2 - sin2).powi(2)) / (16.0 * PI),
            Self::HenyeyGreenstein { g } => {
                // 1 + g² − 2g cos θ = (1 − |g|)² + 4|g| × (sin² or cos² of θ/2).
                let turned = if g < 0.0 { cos2 } else { sin2 };
                let base = (1.0 - g.abs()).powi(2) + 4.0 * g.abs() * turned;
                (1.0 - g) * (1.0 + g) / (4.0 * PI * base * base.sqrt())
            }
            Self::Schlick { k } => {
                let turned = if k < 0.0 { cos2 } else { sin2 };
                let base = 1.0 - k.abs() + 2.0 * k.abs() * turned;
                (1.0 - k * k) / (4.0 * PI * base * base)
            }
            Self::CornetteShanks { g } => {
                let peak = Self::HenyeyGreenstein { g }.at(sin2, cos2);
                1.5 * peak * (1.0 + (cos2 - sin2).powi(2)) / (2.0 + g * g)
            }
            Self::Double { g, weight } => {
                let [a, b] = g.map(|g| Self::HenyeyGreenstein { g }.at(sin2, cos2));
                weight * a + (1.0 - weight) * b
            }
            Self::Draine {
                g,
                draine_g,
                alpha,
                weight,
            } => {
                let plain = Self::HenyeyGreenstein { g }.at(sin2, cos2);
                let peak = Self::HenyeyGreenstein { g: draine_g }.at(sin2, cos2);
                // The mean of cos² θ over the peak is (1 + 2g²)/3.
                let mean = (1.0 + 2.0 * draine_g * draine_g) / 3.0;
                let factor = (1.0 + alpha * (cos2 - sin2).powi(2)) / (1.0 + alpha * mean);
                (1.0 - weight) * plain + weight * peak * factor
            }
        }
    }
}

#[cfg(feature = "scene")]
impl From<airlight::PhaseFunction> for Phase {
    fn from(function: airlight::PhaseFunction) -> Self {
        use airlight::PhaseFunction;
        match function {
            PhaseFunction::Isotropic => Self::Isotropic,
            PhaseFunction::Rayleigh => Self::Rayleigh,
            PhaseFunction::HenyeyGreenstein { g } => Self::HenyeyGreenstein { g: g.into() },
            PhaseFunction::Schlick { k } => Self::Schlick { k: k.into() },
            PhaseFunction::CornetteShanks { g } => Self::CornetteShanks { g: g.into() },
            PhaseFunction::DoubleHenyeyGreenstein { g, weight } => Self::Double {
                g: g.map(f64::from),
                weight: weight.into(),
            },
            PhaseFunction::HenyeyGreensteinDraine {
                g,
                draine_g,
                alpha,
                weight,
            } => Self::Draine {
                g: g.into(),
                draine_g: draine_g.into(),
                alpha: alpha.into(),
                weight: weight.into(),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phase_functions_integrate_to_one() {
        for phase in [
            Phase::Isotropic,
            Phase::Rayleigh,
            Phase::HenyeyGreenstein { g: 0.8 },
            Phase::HenyeyGreenstein { g: -0.5 },
            Phase::Schlick { k: 0.7 },
            Phase::CornetteShanks { g: -0.6 },
            Phase::Double {
                g: [0.8, -0.4],
                weight: 0.3,
            },
            Phase::Draine {
                g: 0.8,
                draine_g: -0.5,
                alpha: 20.0,
                weight: 0.6,
            },
        ] {
            let steps = 100_000;
            let total: f64 = (0..steps)
                .map(|i| {
                    let cos2 = (f64::from(i) + 0.5) / f64::from(steps);
                    // dω = 2π d(cos θ) = 4π d(cos² θ/2)
                    4.0 * PI / f64::from(steps) * phase.at(1.0 - cos2, cos2)
                })
                .sum();
            assert!((total - 1.0).abs() < 1e-7, "{phase:?}: {total}");
        }
    }
}

//! How scattered light spreads over directions.

use std::f32::consts::PI;

use crate::Error;

/// Phase function p(cos θ), 1/sr, normalised over the sphere; `cos θ = 1` is
/// light that goes straight on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum PhaseFunction {
    /// `1 / 4π`.
    #[default]
    Isotropic,
    /// `(1 - g²) / (4π (1 + g² - 2 g cos θ)^{3/2})`, |g| < 1.
    HenyeyGreenstein {
        /// Mean cosine.
        g: f32,
    },
    /// `3 (1 + cos² θ) / 16π`.
    Rayleigh,
}

impl PhaseFunction {
    /// The same function, if its parameter is in range.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless -1 < g < 1.
    pub fn checked(self) -> Result<Self, Error> {
        match self {
            Self::HenyeyGreenstein { g } if !(g.abs() < 1.0) => Err(Error::bad_value(
                "g of the Henyey-Greenstein phase function",
                g,
                "a number between -1 and 1, both excluded",
            )),
            _ => Ok(self),
        }
    }

    /// p(cos θ) in 1/sr.
    pub fn value(self, angle: ScatteringAngle) -> f32 {
        match self {
            Self::Isotropic => 0.25 / PI,
            Self::HenyeyGreenstein { g } => {
                // 1 + g² - 2 g cos θ, without cancellation at either peak.
                let distance2 = if g >= 0.0 {
                    (1.0 - g) * (1.0 - g) + 2.0 * g * angle.one_minus_cos
                } else {
                    (1.0 + g) * (1.0 + g) - 2.0 * g * angle.one_plus_cos
                };
                0.25 / PI * ((1.0 - g) * (1.0 + g)) / (distance2 * distance2.sqrt())
            }
            Self::Rayleigh => {
                let cos = 0.5 * (angle.one_plus_cos - angle.one_minus_cos);
                3.0 / (16.0 * PI) * (1.0 + cos * cos)
            }
        }
    }
}

/// The angle θ between the directions before and after scattering, kept so
/// that sharp forward and backward peaks lose no digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScatteringAngle {
    one_minus_cos: f32,
    one_plus_cos: f32,
}

impl ScatteringAngle {
    /// From a cosine in [-1, 1].
    pub fn from_cos(cos: f32) -> Self {
        Self {
            one_minus_cos: 1.0 - cos,
            one_plus_cos: 1.0 + cos,
        }
    }

    /// At distance `s` along the ray behind the foot point of a point light
    /// that is `h` away from the ray: `cos θ = -s / √(s² + h²)`.
    pub fn from_foot(s: f32, h: f32) -> Self {
        let d = (s * s + h * h).sqrt();
        let large = 1.0 + s.abs() / d;
        let small = (h / d) * (h / d) / large;
        if s < 0.0 {
            Self {
                one_minus_cos: small,
                one_plus_cos: large,
            }
        } else {
            Self {
                one_minus_cos: large,
                one_plus_cos: small,
            }
        }
    }
}

//! Angles of scattering that keep their digits near both peaks.

use crate::Real;

/// The angle θ between the directions before and after scattering, kept as
/// `1 − cos θ` and `1 + cos θ`, so that sharp forward and backward peaks lose
/// no digits. In `f32` or `f64`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScatteringAngle<T = f32> {
    one_minus_cos: T,
    one_plus_cos: T,
}

impl<T: Real> ScatteringAngle<T> {
    /// From a cosine in [-1, 1].
    pub fn from_cos(cos: T) -> Self {
        let one = T::from(1.0);
        Self {
            one_minus_cos: one - cos,
            one_plus_cos: one + cos,
        }
    }

    /// With `tan(θ/2) = b/a`, of which one may be 0 and neither is negative.
    ///
    /// ```text
    /// 1 − cos θ = 2b² / (a² + b²),    1 + cos θ = 2a² / (a² + b²)
    /// ```
    ///
    /// On an eye ray `tan(θ/2) = (s + d)/h = h/(d − s)`.
    #[inline(always)]
    pub fn from_half_tangent(b: T, a: T) -> Self {
        let (a2, b2) = (a * a, b * b);
        let factor = T::from(2.0) / (a2 + b2);
        Self {
            one_minus_cos: b2 * factor,
            one_plus_cos: a2 * factor,
        }
    }

    /// With the squares of `b` and `a`, and the inverse of their sum.
    #[inline(always)]
    pub(crate) fn from_squares(b2: T, a2: T, per_sum: T) -> Self {
        let factor = T::from(2.0) * per_sum;
        Self {
            one_minus_cos: b2 * factor,
            one_plus_cos: a2 * factor,
        }
    }

    /// At distance `s` along the ray behind the foot point of a point light
    /// that is `h` away from the ray: `cos θ = -s / √(s² + h²)`. Not both may
    /// be 0.
    pub fn from_foot(s: T, h: T) -> Self {
        let one = T::from(1.0);
        let d = (s * s + h * h).square_root();
        let behind = s >= T::from(0.0);
        let large = one + if behind { s } else { -s } / d;
        let small = (h / d) * (h / d) / large;
        let (one_minus_cos, one_plus_cos) = if behind {
            (large, small)
        } else {
            (small, large)
        };
        Self {
            one_minus_cos,
            one_plus_cos,
        }
    }

    /// `1 − cos θ`, in [0, 2].
    #[inline(always)]
    pub fn one_minus_cos(self) -> T {
        self.one_minus_cos
    }

    /// `1 + cos θ`, in [0, 2].
    #[inline(always)]
    pub fn one_plus_cos(self) -> T {
        self.one_plus_cos
    }

    /// `cos θ`.
    #[inline(always)]
    pub fn cos(self) -> T {
        T::from(0.5) * (self.one_plus_cos - self.one_minus_cos)
    }

    /// `sin θ`, at least 0.
    pub fn sin(self) -> T {
        (self.one_plus_cos * self.one_minus_cos).square_root()
    }
}

impl From<ScatteringAngle<f32>> for ScatteringAngle<f64> {
    fn from(angle: ScatteringAngle<f32>) -> Self {
        Self {
            one_minus_cos: angle.one_minus_cos.into(),
            one_plus_cos: angle.one_plus_cos.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_next_to_both_peaks_keep_their_digits() {
        for k in 0..40 {
            let tangent = 10_f64.powi(-k);
            let exact = 2.0 * tangent * tangent / (1.0 + tangent * tangent);
            let forward = ScatteringAngle::from_half_tangent(tangent, 1.0);
            assert!((forward.one_minus_cos() / exact - 1.0).abs() < 1e-15);
            let backward = ScatteringAngle::from_half_tangent(1.0, tangent);
            assert!((backward.one_plus_cos() / exact - 1.0).abs() < 1e-15);
            // tan(θ/2) = h/(d − s) with s = −(1 − tan²)/(2 tan) h.
            let s = (1.0 - tangent * tangent) / (2.0 * tangent);
            let forward = ScatteringAngle::from_foot(-s, 1.0);
            assert!((forward.one_minus_cos() / exact - 1.0).abs() < 2e-15);
            let backward = ScatteringAngle::from_foot(s, 1.0);
            assert!((backward.one_plus_cos() / exact - 1.0).abs() < 2e-15);
        }
    }

    #[test]
    fn cosine_and_sine_belong_together() {
        for k in -10..=10 {
            let angle = ScatteringAngle::from_cos(0.1 * f64::from(k));
            assert!((angle.cos() - 0.1 * f64::from(k)).abs() < 1e-15);
            assert!((angle.sin().hypot(angle.cos()) - 1.0).abs() < 1e-15);
            let f32_angle = ScatteringAngle::from_cos(0.1 * k as f32);
            assert!((f64::from(f32_angle.sin()) - angle.sin()).abs() < 1e-6);
        }
    }
}

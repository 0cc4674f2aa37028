//! Fog that thins out with altitude.

use glam::{DVec3, Vec3};

use crate::medium::check_coefficients;
use crate::{PhaseFunction, SceneError};

/// A medium over all of the scene whose coefficients fall exponentially with
/// altitude:
///
/// ```text
/// σ(y) = σ₀ exp(−(y − y₀) / H)
/// ```
///
/// Far below `y₀` it grows without limit, and beyond 700 `H` it is infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightFog {
    sigma_s: Vec3,
    sigma_a: Vec3,
    altitude: f32,
    scale_height: f32,
    phase: PhaseFunction,
}

impl HeightFog {
    /// Fog of scattering `sigma_s` and absorption `sigma_a`, 1/m, at the height
    /// `altitude` (`y₀`, m), that is thinner by a factor of e every
    /// `scale_height` (`H`, m) above it.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if a coefficient is neither 0 nor from 1e-15 to
    /// 1e15 per metre, the altitude is beyond 1e9 m, or the scale height is not
    /// from 1e-3 to 1e9 m; [`SceneError::PhaseFunction`] if a parameter of the
    /// phase function is out of range.
    pub fn new(
        sigma_s: impl Into<[f32; 3]>,
        sigma_a: impl Into<[f32; 3]>,
        altitude: f32,
        scale_height: f32,
        phase: PhaseFunction,
    ) -> Result<Self, SceneError> {
        let owner = "height fog";
        let [sigma_s, sigma_a] = [sigma_s.into(), sigma_a.into()].map(Vec3::from_array);
        check_coefficients(owner, "sigma_s", sigma_s)?;
        check_coefficients(owner, "sigma_a", sigma_a)?;
        if !(-1e9..=1e9).contains(&altitude) {
            let expected = "an altitude within 1e9 m";
            return Err(SceneError::bad_value(owner, "altitude", altitude, expected));
        }
        if !(1e-3..=1e9).contains(&scale_height) {
            let (what, expected) = ("scale height", "a length from 1e-3 to 1e9 m");
            return Err(SceneError::bad_value(owner, what, scale_height, expected));
        }
        Ok(Self {
            sigma_s,
            sigma_a,
            altitude,
            scale_height,
            phase: phase.checked()?,
        })
    }

    /// Scattering coefficient at the altitude of the fog, 1/m.
    pub fn sigma_s(&self) -> Vec3 {
        self.sigma_s
    }

    /// Absorption coefficient at the altitude of the fog, 1/m.
    pub fn sigma_a(&self) -> Vec3 {
        self.sigma_a
    }

    /// Extinction coefficient at the altitude of the fog, 1/m.
    pub fn sigma_t(&self) -> Vec3 {
        self.sigma_s + self.sigma_a
    }

    /// The altitude at which the coefficients are those that were given, m.
    pub fn altitude(&self) -> f32 {
        self.altitude
    }

    /// The height over which the coefficients fall by a factor of e, m.
    pub fn scale_height(&self) -> f32 {
        self.scale_height
    }

    /// How scattered light spreads over directions.
    pub fn phase(&self) -> PhaseFunction {
        self.phase
    }

    /// The factor on the coefficients at the height `y`.
    pub fn density(&self, y: f64) -> f64 {
        ((f64::from(self.altitude) - y) / f64::from(self.scale_height)).exp()
    }

    /// The length in metres of a path at the fog's own altitude that crosses as much fog as a
    /// given path. That path has length `length`, begins at the height `y` and rises by `slope`
    /// per metre (−1 to 1); `length` may be infinite. The result is exact except for rounding,
    /// which is about 1e-16 times the distance from the fog's altitude in scale heights; it is
    /// never NaN.
    ///
    /// ```text
    /// ∫ exp(−(y + slope t − y₀) / H) dt,  t from 0 to length
    /// ```
    pub fn column(&self, y: f64, slope: f64, length: f64) -> f64 {
        // The integral starts at the lower end, from which the exponential falls.
        let low = if slope < 0.0 { y + slope * length } else { y };
        let density = self.density(low);
        let rate = slope.abs() / f64::from(self.scale_height);
        let fall = rate * length;
        let reach = if fall > 0.0 {
            -(-fall).exp_m1() / rate
        } else {
            length
        };
        // More than about 700 scale heights above the altitude nothing is left, and as far
        // below the fog is infinite.
        if density == 0.0 || reach == 0.0 {
            return 0.0;
        }
        density * reach
    }

    /// The optical depth per colour channel of the path of light that arrives at the height `y`
    /// from a `distance`; the direction towards the light rises by `slope` per metre. It is the
    /// [optical depth](HeightFog::optical_depth) of that path, except for a sun whose light
    /// travels through the fog without end: as in a homogeneous medium, its irradiance is the
    /// one that arrives, and the depth is 0.
    pub fn depth_towards(&self, y: f64, slope: f64, distance: f64) -> DVec3 {
        if distance.is_finite() || slope > 0.0 {
            self.optical_depth(y, slope, distance)
        } else {
            DVec3::ZERO
        }
    }

    /// The optical depth per colour channel of the path that [`column`](HeightFog::column)
    /// takes.
    pub fn optical_depth(&self, y: f64, slope: f64, length: f64) -> DVec3 {
        crate::media::depth(self.sigma_t().as_dvec3(), self.column(y, slope, length))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fog(altitude: f32, scale_height: f32) -> HeightFog {
        let sigma_s = Vec3::new(0.1, 0.0, 0.2);
        HeightFog::new(
            sigma_s,
            Vec3::ZERO,
            altitude,
            scale_height,
            PhaseFunction::Isotropic,
        )
        .unwrap()
    }

    /// Simpson's rule, as an independent sum.
    fn simpson(fog: &HeightFog, y: f64, slope: f64, length: f64) -> f64 {
        let (count, at) = (20_000, |t: f64| fog.density(y + slope * t));
        let step = length / f64::from(count);
        let sum: f64 = (0..count)
            .map(|i| {
                let t = f64::from(i) * step;
                at(t) + 4.0 * at(t + 0.5 * step) + at(t + step)
            })
            .sum();
        sum * step / 6.0
    }

    #[test]
    fn columns_are_the_integral_at_any_slope() {
        let fog = fog(3.0, 7.0);
        for y in [-20.0, 0.0, 3.0, 40.0] {
            for slope in [-1.0, -0.3, -1e-9, 0.0, 1e-300, 1e-12, 1e-4, 0.5, 1.0] {
                for length in [1e-3, 1.0, 25.0, 90.0] {
                    let (found, sum) = (
                        fog.column(y, slope, length),
                        simpson(&fog, y, slope, length),
                    );
                    assert!(
                        (found / sum - 1.0).abs() < 1e-11,
                        "{y} {slope} {length}: {found} {sum}"
                    );
                }
            }
        }
    }

    #[test]
    fn parts_add_up_and_a_way_back_crosses_as_much() {
        let fog = fog(0.0, 2.0);
        for (y, slope) in [(1.0, 0.7), (5.0, -0.2), (0.5, 1e-15)] {
            let whole = fog.column(y, slope, 10.0);
            let parts = fog.column(y, slope, 4.0) + fog.column(y + 4.0 * slope, slope, 6.0);
            let back = fog.column(y + 10.0 * slope, -slope, 10.0);
            assert!((parts / whole - 1.0).abs() < 1e-13 && (back / whole - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn endless_and_extreme_ways_have_their_limits() {
        let fog = fog(0.0, 2.0);
        let endless = f64::INFINITY;
        assert_eq!(fog.column(0.0, 0.5, endless), 4.0);
        assert_eq!(fog.column(0.0, 0.0, endless), endless);
        assert_eq!(fog.column(0.0, -0.5, endless), endless);
        assert_eq!(fog.column(1e5, 0.0, endless), 0.0);
        assert_eq!(fog.column(-1e9, 0.0, 0.0), 0.0);
        assert_eq!(fog.column(-1e9, 1.0, 1.0), endless);
        // A channel that scatters nothing has no depth however far one goes.
        let depth = fog.optical_depth(0.0, 0.0, endless);
        assert_eq!(depth, DVec3::new(endless, 0.0, endless));
    }

    #[test]
    fn bad_fog_names_its_cause() {
        let new = |sigma, altitude, height, g| {
            let phase = PhaseFunction::HenyeyGreenstein { g };
            HeightFog::new(Vec3::splat(sigma), Vec3::ZERO, altitude, height, phase)
        };
        for (fog, cause) in [
            (new(-1.0, 0.0, 1.0, 0.0), "sigma_s"),
            (new(1.0, f32::NAN, 1.0, 0.0), "altitude is NaN"),
            (new(1.0, 0.0, 0.0, 0.0), "scale height is 0"),
            (new(1.0, 0.0, 1.0, 1.0), "Henyey"),
        ] {
            let error = fog.unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
    }
}

//! The homogeneous participating medium.

pub use airlight::{PhaseFunction, ScatteringAngle};
use glam::Vec3;

use super::{SceneError, is_near};
use crate::Interval;

/// A homogeneous medium that scatters light once.
///
/// `sigma_t = sigma_s + sigma_a` in 1/m per colour channel; transmittance over
/// a distance `x` inside is `exp(-sigma_t x)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    sigma_s: Vec3,
    sigma_a: Vec3,
    phase: PhaseFunction,
    bounds: Option<Bounds>,
}

impl Medium {
    /// A vacuum everywhere.
    pub const VACUUM: Self = Self {
        sigma_s: Vec3::ZERO,
        sigma_a: Vec3::ZERO,
        phase: PhaseFunction::Isotropic,
        bounds: None,
    };

    /// An unbounded medium of scattering `sigma_s` and absorption `sigma_a`, 1/m.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if a coefficient is neither 0 nor from 1e-15 to
    /// 1e15 per metre, or the phase function's parameter is out of its range.
    pub fn new(
        sigma_s: impl Into<[f32; 3]>,
        sigma_a: impl Into<[f32; 3]>,
        phase: PhaseFunction,
    ) -> Result<Self, SceneError> {
        let [sigma_s, sigma_a] = [sigma_s.into(), sigma_a.into()].map(Vec3::from_array);
        check_coefficients("medium", "sigma_s", sigma_s)?;
        check_coefficients("medium", "sigma_a", sigma_a)?;
        phase.checked()?;
        Ok(Self {
            sigma_s,
            sigma_a,
            phase,
            bounds: None,
        })
    }

    /// The same medium, but only inside a box; a vacuum outside.
    #[must_use]
    pub fn within(self, bounds: Bounds) -> Self {
        Self {
            bounds: Some(bounds),
            ..self
        }
    }

    /// Scattering coefficient, 1/m.
    #[inline]
    pub fn sigma_s(&self) -> Vec3 {
        self.sigma_s
    }

    /// Absorption coefficient, 1/m.
    pub fn sigma_a(&self) -> Vec3 {
        self.sigma_a
    }

    /// Extinction coefficient, 1/m.
    #[inline]
    pub fn sigma_t(&self) -> Vec3 {
        self.sigma_s + self.sigma_a
    }

    /// How scattered light spreads over directions.
    #[inline]
    pub fn phase(&self) -> PhaseFunction {
        self.phase
    }

    /// The box that holds the medium, `None` if it is everywhere.
    #[inline]
    pub fn bounds(&self) -> Option<Bounds> {
        self.bounds
    }

    /// True if nothing is scattered: the airlight is 0 everywhere.
    pub fn scatters_nothing(&self) -> bool {
        self.sigma_s == Vec3::ZERO
    }

    /// The length of the segment from `start` along the unit vector
    /// `direction` over `length` that lies inside the medium. `length` may be
    /// infinite.
    #[inline]
    pub fn length_inside(&self, start: Vec3, direction: Vec3, length: f32) -> f32 {
        match &self.bounds {
            None => length,
            Some(bounds) => bounds
                .clip(start, direction, Interval::new(0.0, length))
                .map_or(0.0, Interval::length),
        }
    }
}

/// Scattering or absorption coefficients of a medium.
pub(crate) fn check_coefficients(
    owner: &'static str,
    what: &'static str,
    value: Vec3,
) -> Result<(), SceneError> {
    let is_sound = |sigma: &f32| *sigma == 0.0 || (1e-15..=1e15).contains(sigma);
    if value.to_array().iter().all(is_sound) {
        return Ok(());
    }
    let expected = "coefficients of 0, or of 1e-15 to 1e15 per metre";
    Err(SceneError::bad_value(owner, what, value, expected))
}

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    min: Vec3,
    max: Vec3,
}

impl Bounds {
    /// The box between two corners.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if a coordinate is not finite or beyond 1e9 m, or
    /// `min` is not below `max` on every axis.
    pub fn new(min: impl Into<[f32; 3]>, max: impl Into<[f32; 3]>) -> Result<Self, SceneError> {
        let [min, max] = [min.into(), max.into()].map(Vec3::from_array);
        if !(is_near(min) && is_near(max) && min.cmplt(max).all()) {
            return Err(SceneError::bad_value(
                "box",
                "corners",
                format!("{min} to {max}"),
                "corners within 1e9 m, the first below the second on each axis",
            ));
        }
        Ok(Self { min, max })
    }

    /// The corner with the smallest coordinates.
    pub fn min(&self) -> Vec3 {
        self.min
    }

    /// The corner with the largest coordinates.
    pub fn max(&self) -> Vec3 {
        self.max
    }

    /// All eight corners: corner i has the largest coordinate on the axes whose bits are set in
    /// i.
    pub fn corners(&self) -> [Vec3; 8] {
        let ends = [self.min, self.max];
        std::array::from_fn(|i| Vec3::from([0, 1, 2].map(|axis| ends[i >> axis & 1][axis])))
    }

    /// The smallest box that contains both.
    #[must_use]
    pub fn around(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Whether `point` lies in the box or on its surface.
    pub fn contains(&self, point: Vec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// The part of `interval` of the ray `start + x direction` inside the box,
    /// `None` if it is empty or a single point.
    pub fn clip(&self, start: Vec3, direction: Vec3, interval: Interval) -> Option<Interval> {
        let (mut near, mut far) = (interval.start, interval.end);
        for axis in 0..3 {
            let (origin, slope) = (start[axis], direction[axis]);
            let (low, high) = (self.min[axis], self.max[axis]);
            if slope == 0.0 {
                if origin < low || origin > high {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - origin) / slope, (high - origin) / slope);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near < far).then(|| Interval::new(near, far))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn medium(s: f32, a: f32, phase: PhaseFunction) -> Result<Medium, SceneError> {
        Medium::new(Vec3::splat(s), Vec3::splat(a), phase)
    }

    #[test]
    fn bad_coefficients_are_named() {
        for (s, a) in [
            (-1.0, 0.0),
            (0.0, f32::NAN),
            (f32::INFINITY, 0.0),
            (3e38, 3e38),
            (1e-40, 0.0),
        ] {
            assert!(medium(s, a, PhaseFunction::Isotropic).is_err());
        }
        for g in [1.0, -1.0, 2.0, f32::NAN] {
            let error = medium(1.0, 0.0, PhaseFunction::HenyeyGreenstein { g }).unwrap_err();
            assert!(
                error
                    .to_string()
                    .contains("g of the Henyey-Greenstein phase function is"),
                "{error}"
            );
        }
    }

    #[test]
    fn a_box_clips_rays_and_paths() {
        let bounds = Bounds::new(Vec3::ZERO, Vec3::ONE).unwrap();
        let whole = Interval::new(0.0, f32::INFINITY);
        let start = Vec3::new(0.5, 0.5, 3.0);
        assert_eq!(
            bounds.clip(start, Vec3::NEG_Z, whole),
            Some(Interval::new(2.0, 3.0))
        );
        assert_eq!(bounds.clip(start, Vec3::Z, whole), None);
        assert_eq!(bounds.clip(start, Vec3::X, whole), None);
        let fog = medium(1.0, 0.0, PhaseFunction::Isotropic)
            .unwrap()
            .within(bounds);
        assert_eq!(fog.length_inside(start, Vec3::NEG_Z, 2.5), 0.5);
        assert!(Bounds::new(Vec3::ONE, Vec3::ZERO).is_err());
        assert!(Bounds::new(Vec3::NAN, Vec3::ONE).is_err());
    }
}

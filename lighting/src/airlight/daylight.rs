//! The model of daylight, for any light.

use glam::Vec3;

use super::directional::{directional, mean_exponential};
use super::{AirlightEvaluator, far_end};
use crate::scene::ScatteringAngle;
use crate::{Emitter, Interval, LightPath};

/// Airlight as if all light were daylight.
///
/// Based on: Hoffman and Preetham, Rendering outdoor light scattering in real time, Game
/// Developers Conference 2002; Wyman and Ramsey (Interactive Volumetric Shadows, RT 2008) apply
/// it step by step to coloured spotlights, for more contrast:
///
/// ```text
/// L[a, b] = σ_s p(cos θ) E ∫_a^b exp(−σ_t x) dx,    E = I / D²
/// ```
///
/// The angle θ is the one at the middle of an interval, and so is the direction in which a
/// light with a pattern shines. The irradiance E is the same everywhere: that at the distance D
/// from the light. The model has neither the inverse square nor the extinction between light
/// and air. So beams do not fade along their way, and a ray is no brighter for passing close by
/// the light. It does not approximate single scattering but replaces it: at the distance d from
/// the light it is brighter by `(d / D)² exp(σ_t d)`, which is a factor of 16 at d = 12 m in
/// fog of 0.05 / m with D = 4 m.
///
/// For a sun in fog without bounds it is exact. In a box of fog the way of sunlight through the
/// fog counts, as in [`directional()`](super::directional). It costs two exponentials per
/// colour and interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Daylight {
    distance: f32,
}

/// The distance that was given is not from 1e-6 m to 1e9 m.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("distance of daylight: {0} m, expected 1e-6 to 1e9")]
pub struct DaylightError(pub f32);

impl Daylight {
    /// Light that is everywhere as strong as at `distance` metres from a point light.
    ///
    /// # Errors
    /// [`DaylightError`] unless the distance is from 1e-6 m to 1e9 m.
    pub fn new(distance: f32) -> Result<Self, DaylightError> {
        match (1e-6..=1e9).contains(&distance) {
            true => Ok(Self { distance }),
            false => Err(DaylightError(distance)),
        }
    }

    /// The distance D from the light at which the model has the light's true irradiance, m.
    pub fn distance(&self) -> f32 {
        self.distance
    }
}

impl AirlightEvaluator for Daylight {
    fn radiance(&self, path: &LightPath<'_>, interval: Interval) -> Vec3 {
        let point = match path.emitter() {
            Emitter::Directional(sun) => return directional(path, sun, interval),
            Emitter::Point(point) => point,
        };
        let medium = path.medium();
        let start = interval.start;
        let end = interval.end.min(start + far_end(medium));
        if !(start < end) {
            return Vec3::ZERO;
        }
        let s = start + 0.5 * (end - start) - path.foot();
        let angle = ScatteringAngle::from_foot(s, path.h());
        // At the light itself no direction is defined.
        let light = match s != 0.0 || path.h() > 0.0 {
            true => path.intensity(point, path.from_light(s).0),
            false => point.intensity(),
        };
        let sigma_t = medium.sigma_t();
        let way = sigma_t.map(|sigma| {
            let near = (-sigma * (start - path.entry())).exp();
            near * mean_exponential(sigma * (end - start))
        });
        let irradiance = light / (self.distance * self.distance);
        medium.sigma_s() * irradiance * way * (medium.phase().value(angle) * (end - start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ray;
    use crate::scene::{Emission, Medium, PhaseFunction};

    #[test]
    fn light_is_as_strong_everywhere_and_dims_on_its_way_to_the_eye() {
        let sigma = Vec3::new(0.1, 0.2, 0.4);
        let fog = Medium::new(sigma, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let ray = Ray::new(Vec3::ZERO, Vec3::X, f32::INFINITY).unwrap();
        let daylight = Daylight::new(2.0).unwrap();
        for lamp in [
            Vec3::new(3.0, 1.0, 0.0),
            Vec3::new(-9.0, 0.0, 30.0),
            Vec3::ZERO,
        ] {
            let light = Emitter::point(lamp, [8.0; 3], f32::INFINITY, Emission::Isotropic);
            let light = light.unwrap();
            let path = LightPath::new(&ray, &light, &fog).unwrap();
            let found = daylight.radiance(&path, Interval::new(1.0, 3.0));
            // 8 W/sr at 2 m, isotropic: scattering and extinction are equal.
            let expected = (-sigma).exp() - (-3.0 * sigma).exp();
            let expected = expected * 2.0 / (4.0 * std::f32::consts::PI);
            assert!((found - expected).abs().max_element() < 1e-6, "{found}");
            let both = [0.0, 7.0, f32::INFINITY]
                .windows(2)
                .map(|x| daylight.radiance(&path, Interval::new(x[0], x[1])));
            let all = both.sum::<Vec3>() * (4.0 * std::f32::consts::PI) / 2.0;
            assert!((all - 1.0).abs().max_element() < 1e-4, "{all}");
        }
    }

    #[test]
    fn parallel_light_is_what_it_is() {
        let fog = Medium::new(Vec3::ONE, Vec3::ONE, PhaseFunction::Rayleigh).unwrap();
        let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
        let ray = Ray::new(Vec3::ZERO, Vec3::X, 4.0).unwrap();
        let path = LightPath::new(&ray, &sun, &fog).unwrap();
        let Emitter::Directional(parallel) = &sun else {
            panic!("a sun was made");
        };
        let expected = directional(&path, parallel, path.span());
        assert_eq!(
            Daylight::new(3.0).unwrap().radiance(&path, path.span()),
            expected
        );
    }

    #[test]
    fn distances_are_checked() {
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e10] {
            assert!(Daylight::new(bad).is_err());
        }
    }
}

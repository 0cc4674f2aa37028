//! Points of surfaces that are lit.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use crate::scene::{Emitter, Medium};

/// A point of a Lambertian surface, and how much of what it reflects reaches the
/// eye.
///
/// Laid out as three `vec4<f32>`, which is what shaders see. The default is a
/// pixel without a surface: it reflects nothing, and no step adds anything to it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct SurfacePoint {
    pub(crate) position: Vec3,
    pub(crate) openness: f32,
    pub(crate) normal: Vec3,
    pub(crate) padding_a: f32,
    pub(crate) response: Vec3,
    pub(crate) padding_b: f32,
}

impl SurfacePoint {
    /// A point at `position` with the unit `normal` on the side of the eye.
    ///
    /// `response` is the radiance that reaches the eye per unit of irradiance:
    /// `albedo/π · exp(−σ_t D)`, with `D` the way from the surface to the eye that
    /// runs in the medium. It is at least 0 in every channel.
    ///
    /// Nothing covers the surface; see [`SurfacePoint::with_openness`].
    ///
    /// `None` if a number is not finite, the normal is 0 or a response is negative.
    pub fn new(position: Vec3, normal: Vec3, response: Vec3) -> Option<Self> {
        let normal = normal.try_normalize()?;
        let is_sound =
            position.is_finite() && response.is_finite() && response.min_element() >= 0.0;
        is_sound.then_some(Self {
            position,
            openness: 1.0,
            normal,
            padding_a: 0.0,
            response,
            padding_b: 0.0,
        })
    }

    /// The same point under something that covers part of its sky: `openness` is
    /// the share, 0 to 1, of the hemisphere over it, weighted by the cosine to the
    /// normal, that sees the environment. Numbers outside count as the nearer end,
    /// NaN as 0.
    #[must_use]
    pub fn with_openness(self, openness: f32) -> Self {
        // Not a clamp, which would keep NaN.
        let openness = if openness > 0.0 {
            openness.min(1.0)
        } else {
            0.0
        };
        Self { openness, ..self }
    }

    /// World position, m.
    pub fn position(&self) -> Vec3 {
        self.position
    }

    /// Unit normal on the side of the eye.
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// Radiance at the eye per unit of irradiance, 1/sr.
    pub fn response(&self) -> Vec3 {
        self.response
    }

    /// Share of the sky over it that is not covered.
    pub fn openness(&self) -> f32 {
        self.openness
    }

    /// Whether there is a surface that reflects anything.
    pub fn reflects(&self) -> bool {
        self.response.max_element() > 0.0
    }
}

/// Light on its way to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arriving {
    /// Where it comes from.
    pub(crate) to_light: Vec3,
    /// How far it is from there, infinite if it is parallel.
    pub(crate) distance: f32,
    /// The irradiance of a surface that faces it, without shadow and fog.
    pub(crate) irradiance: Vec3,
}

impl Arriving {
    /// The light of `emitter` at `point`; `None` where it does not reach.
    pub(crate) fn at(point: Vec3, emitter: &Emitter) -> Option<Self> {
        let lamp = match emitter {
            Emitter::Directional(sun) => {
                return Some(Self {
                    to_light: -sun.direction(),
                    distance: f32::INFINITY,
                    irradiance: sun.irradiance(),
                });
            }
            Emitter::Point(lamp) => lamp,
        };
        let offset = lamp.position() - point;
        let distance = offset.length();
        if distance == 0.0 || distance > lamp.range() {
            return None;
        }
        let to_light = offset / distance;
        let intensity =
            lamp.intensity() * lamp.emission().factor(-to_light) * lamp.window(distance);
        Some(Self {
            to_light,
            distance,
            irradiance: intensity / (distance * distance),
        })
    }

    /// The share of it that fog lets through on its way.
    pub(crate) fn through(&self, medium: Option<&Medium>, point: Vec3) -> Vec3 {
        match medium {
            // Sunlight in an unbounded medium has been attenuated "before": the
            // irradiance is the one that arrives.
            Some(medium) if medium.bounds().is_none() && !self.distance.is_finite() => Vec3::ONE,
            medium => transmittance(medium, point, self.to_light, self.distance),
        }
    }
}

/// What a medium lets through from `start` over a length in metres.
pub(crate) fn transmittance(
    medium: Option<&Medium>,
    start: Vec3,
    direction: Vec3,
    length: f32,
) -> Vec3 {
    match medium {
        None => Vec3::ONE,
        // 0 · ∞: a medium that extinguishes nothing does so over any length.
        Some(medium) if medium.sigma_t() == Vec3::ZERO => Vec3::ONE,
        Some(medium) => (-medium.sigma_t() * medium.length_inside(start, direction, length)).exp(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_sound_or_refused() {
        let point = SurfacePoint::new(Vec3::ONE, 3.0 * Vec3::Y, Vec3::X).unwrap();
        assert_eq!(point.normal(), Vec3::Y);
        assert!(point.reflects() && point.openness() == 1.0);
        assert!(!SurfacePoint::default().reflects());
        for (position, normal, response) in [
            (Vec3::NAN, Vec3::Y, Vec3::ONE),
            (Vec3::ONE, Vec3::ZERO, Vec3::ONE),
            (Vec3::ONE, Vec3::Y, Vec3::NEG_X),
            (Vec3::ONE, Vec3::Y, Vec3::INFINITY),
        ] {
            assert_eq!(SurfacePoint::new(position, normal, response), None);
        }
        for (given, counts_as) in [(f32::NAN, 0.0), (-1.0, 0.0), (0.3, 0.3), (7.0, 1.0)] {
            assert_eq!(point.with_openness(given).openness(), counts_as);
        }
    }
}

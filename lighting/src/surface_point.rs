//! Points of surfaces that are to be lit.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use crate::scene::{Emitter, Medium};

/// A point of a Lambertian surface, and how much of the light that it reflects reaches the eye.
///
/// Its memory layout is three `vec4<f32>`, which is what shaders read. The default stands for a
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
    /// `response` is the radiance that reaches the eye per unit of irradiance: `albedo/π ·
    /// exp(−σ_t D)`, where `D` is the length of the way from the surface to the eye in the
    /// medium. It must be at least 0 in every channel.
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

    /// The same point under something that covers part of its sky. `openness` is the share, 0
    /// to 1, of the hemisphere over the surface that sees the environment, weighted by the
    /// cosine to the normal. Numbers outside count as 0 or 1, NaN as 0.
    #[must_use]
    pub fn with_openness(self, openness: f32) -> Self {
        // `clamp` would keep NaN.
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

    /// The share of its sky that is open.
    pub fn openness(&self) -> f32 {
        self.openness
    }

    /// Whether it reflects anything. It does not where there is no surface.
    pub fn reflects(&self) -> bool {
        self.response.max_element() > 0.0
    }
}

/// Light that arrives at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arriving {
    /// The unit direction to the light.
    pub(crate) to_light: Vec3,
    /// The distance of the light, m; infinite for a directional light.
    pub(crate) distance: f32,
    /// The irradiance of a surface that faces the light, without shadow and fog.
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

    /// The share that fog lets through on the way to `point`.
    pub(crate) fn through(&self, medium: Option<&Medium>, point: Vec3) -> Vec3 {
        match medium {
            // In a medium without bounds, the irradiance of a sun is the one that arrives.
            Some(medium) if medium.bounds().is_none() && !self.distance.is_finite() => Vec3::ONE,
            medium => transmittance(medium, point, self.to_light, self.distance),
        }
    }
}

/// The transmittance of a medium from `start` over a length in metres.
pub(crate) fn transmittance(
    medium: Option<&Medium>,
    start: Vec3,
    direction: Vec3,
    length: f32,
) -> Vec3 {
    match medium {
        None => Vec3::ONE,
        // This avoids 0 · ∞: a medium without extinction dims nothing over any length.
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

//! Lights as a scene describes them.

use glam::{Quat, Vec3};

use super::{SceneError, Texture};
use crate::{Emission, Emitter};

/// A light of a scene. Algorithms see it as one or more [`Emitter`]s.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Light {
    /// Shines equally in all directions.
    Point(PointLight),
    /// Shines into a cone.
    Spot(SpotLight),
    /// Infinitely far away: the sun.
    Directional(DirectionalLight),
    /// A rectangle that glows on one side.
    Area(AreaLight),
}

/// A point that shines equally in all directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLight {
    /// World position, m.
    pub position: Vec3,
    /// Radiant intensity, linear RGB.
    pub intensity: Vec3,
    /// Nothing farther away than this is lit, m; `f32::INFINITY` for no limit.
    pub range: f32,
}

/// A point that shines into a cone around its local −Z.
#[derive(Debug, Clone, PartialEq)]
pub struct SpotLight {
    /// World position, m.
    pub position: Vec3,
    /// From the light's space to the world's.
    pub rotation: Quat,
    /// Radiant intensity on the axis, linear RGB.
    pub intensity: Vec3,
    /// Nothing farther away than this is lit, m; `f32::INFINITY` for no limit.
    pub range: f32,
    /// The cone in which the intensity is full and the one where it ends.
    pub cone: Cone,
    /// A slide in front of the light that multiplies its intensity. It spans
    /// the square around the outer cone, upright with the light's local +Y.
    pub texture: Option<Texture>,
}

/// Half angles of a spotlight, radians.
///
/// At the angle θ to the axis the intensity is multiplied by
/// `clamp((cos θ − cos outer) / max(0.001, cos inner − cos outer), 0, 1)²`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Up to here the intensity is full. 0 ≤ `inner` < `outer`.
    pub inner: f32,
    /// From here on it is 0. At most π/2.
    pub outer: f32,
}

/// Parallel light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    /// Where the light travels to; any length but 0.
    pub direction: Vec3,
    /// Irradiance on a plane that faces the light, linear RGB.
    pub irradiance: Vec3,
}

/// A rectangle that emits on the side of `edges[0] × edges[1]`.
#[derive(Debug, Clone, PartialEq)]
pub struct AreaLight {
    /// The corner at texture coordinate (0, 0).
    pub corner: Vec3,
    /// The edges from that corner along the texture's u and v.
    pub edges: [Vec3; 2],
    /// Emitted radiance, linear RGB.
    pub radiance: Vec3,
    /// Multiplies the radiance over the rectangle.
    pub texture: Option<Texture>,
}

impl Light {
    /// What kind of light this is, for reports.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Point(_) => "point",
            Self::Spot(spot) if spot.texture.is_some() => "textured spot",
            Self::Spot(_) => "spot",
            Self::Directional(_) => "directional",
            Self::Area(_) => "area",
        }
    }

    /// The light as emitters that algorithms work with: itself, or about
    /// `samples` virtual point lights in a regular grid over an area light,
    /// each with the share of radiance × area that its cell emits and a cosine
    /// emission. At least one, at most 65536. They float in front of the
    /// rectangle by 1e-3 of its shorter edge, so that a mesh in the same place
    /// does not hide them.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if a number is out of its domain.
    pub fn emitters(&self, samples: u32) -> Result<Vec<Emitter>, SceneError> {
        match self {
            Self::Point(light) => {
                let emission = Emission::Isotropic;
                let PointLight {
                    position,
                    intensity,
                    range,
                } = *light;
                Emitter::point(position, intensity, range, emission).map(|e| vec![e])
            }
            Self::Spot(light) => {
                let emission = Emission::spot(light.rotation, light.cone, light.texture.clone())?;
                Emitter::point(light.position, light.intensity, light.range, emission)
                    .map(|e| vec![e])
            }
            Self::Directional(light) => {
                Emitter::directional(light.direction, light.irradiance).map(|e| vec![e])
            }
            Self::Area(light) => light.emitters(samples),
        }
    }
}

impl AreaLight {
    fn emitters(&self, samples: u32) -> Result<Vec<Emitter>, SceneError> {
        let [u, v] = self.edges;
        let normal = u.cross(v);
        let area = normal.length();
        if !(self.corner.is_finite() && area.is_finite() && area > 0.0) {
            return Err(SceneError::bad_value(
                "area light",
                "rectangle",
                format!("{} with edges {u} and {v}", self.corner),
                "finite coordinates and two edges that span an area",
            ));
        }
        let samples = samples.clamp(1, 65536) as f32;
        let columns = (samples * u.length() / v.length())
            .sqrt()
            .round()
            .clamp(1.0, samples);
        let rows = (samples / columns).round().max(1.0);
        let (columns, rows) = (columns as u32, rows as u32);
        let cell = glam::Vec2::new(1.0 / columns as f32, 1.0 / rows as f32);
        let share = area * cell.x * cell.y;
        let normal = normal / area;
        let lift = 1e-3 * u.length().min(v.length()) * normal;
        let mut emitters = Vec::with_capacity((columns * rows) as usize);
        for row in 0..rows {
            for column in 0..columns {
                let origin = glam::Vec2::new(column as f32, row as f32) * cell;
                let centre = origin + 0.5 * cell;
                let position = self.corner + centre.x * u + centre.y * v + lift;
                let radiance = self.radiance * self.mean_texture(origin, cell);
                emitters.push(Emitter::point(
                    position,
                    radiance * share,
                    f32::INFINITY,
                    Emission::Cosine { normal },
                )?);
            }
        }
        Ok(emitters)
    }

    /// The mean of the texture over a cell, from 8 × 8 bilinear lookups.
    fn mean_texture(&self, origin: glam::Vec2, cell: glam::Vec2) -> Vec3 {
        const SIDE: u32 = 8;
        let Some(texture) = &self.texture else {
            return Vec3::ONE;
        };
        let mut sum = Vec3::ZERO;
        for y in 0..SIDE {
            for x in 0..SIDE {
                let offset = (glam::Vec2::new(x as f32, y as f32) + 0.5) / SIDE as f32;
                sum += texture.clamp(origin + offset * cell);
            }
        }
        sum / (SIDE * SIDE) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(texture: Option<Texture>) -> AreaLight {
        AreaLight {
            corner: Vec3::new(-1.0, 2.0, 0.0),
            edges: [Vec3::X * 4.0, Vec3::Z],
            radiance: Vec3::new(3.0, 2.0, 1.0),
            texture,
        }
    }

    #[test]
    fn virtual_lights_share_the_power_of_the_rectangle() {
        let light = Light::Area(panel(None));
        for samples in [0, 1, 5, 16, 100] {
            let emitters = light.emitters(samples).unwrap();
            let total: Vec3 = emitters.iter().map(Emitter::intensity).sum();
            assert!((total - Vec3::new(12.0, 8.0, 4.0)).length() < 1e-4);
        }
        assert_eq!(light.emitters(16).unwrap().len(), 16, "8 x 2 cells");
    }

    #[test]
    fn a_texture_is_shared_out_by_cell() {
        let texels = vec![Vec3::ZERO, Vec3::ZERO, Vec3::splat(2.0), Vec3::splat(2.0)];
        let texture = Texture::new(4, 1, texels).unwrap();
        let emitters = Light::Area(panel(Some(texture))).emitters(4).unwrap();
        let total: Vec3 = emitters.iter().map(Emitter::intensity).sum();
        assert!((total.x - 12.0).abs() < 0.1, "{total}");
        assert!(emitters[0].intensity().x < 0.1 * emitters[3].intensity().x);
    }

    #[test]
    fn bad_lights_are_refused() {
        let point = PointLight {
            position: Vec3::ZERO,
            intensity: Vec3::ONE,
            range: f32::INFINITY,
        };
        let cone = Cone {
            inner: 0.2,
            outer: 0.4,
        };
        let spot = SpotLight {
            position: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            intensity: Vec3::ONE,
            range: 5.0,
            cone,
            texture: None,
        };
        let bad = [
            Light::Point(PointLight {
                position: Vec3::new(0.0, f32::NAN, 0.0),
                ..point
            }),
            Light::Point(PointLight {
                intensity: Vec3::splat(-1.0),
                ..point
            }),
            Light::Point(PointLight {
                range: 0.0,
                ..point
            }),
            Light::Spot(SpotLight {
                cone: Cone { inner: 0.5, ..cone },
                ..spot.clone()
            }),
            Light::Spot(SpotLight {
                cone: Cone { outer: 2.0, ..cone },
                ..spot
            }),
            Light::Directional(DirectionalLight {
                direction: Vec3::ZERO,
                irradiance: Vec3::ONE,
            }),
            Light::Area(AreaLight {
                edges: [Vec3::X, Vec3::X],
                ..panel(None)
            }),
        ];
        for light in bad {
            assert!(light.emitters(4).is_err(), "{light:?}");
        }
    }
}

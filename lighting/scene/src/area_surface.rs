//! The points of an area light.

use glam::{DVec2, Vec2, Vec3};

use crate::{AreaLight, AreaShape, SceneError};

/// The glowing side of an [`AreaLight`], as a map from the unit square to points of the light
/// that preserves ratios of areas: the coordinates along the edges of a rectangle, or the
/// square of the radius and the angle of an ellipse.
#[derive(Debug, Clone, Copy)]
pub struct AreaSurface<'a> {
    light: &'a AreaLight,
    /// The corner, in front of the light.
    origin: Vec3,
    normal: Vec3,
    area: f32,
}

impl<'a> AreaSurface<'a> {
    /// The surface of `light`. It is in front of the light by 1e-3 of its shorter edge, as are
    /// the points of [`AreaLight::virtual_lights`], so that whatever holds the light casts no
    /// shadow on it.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if the corner is not finite or farther away than
    /// 1e9 m, the edges do not span an area, or the radiance is negative or not finite.
    pub fn new(light: &'a AreaLight) -> Result<Self, SceneError> {
        let [u, v] = light.edges;
        // The square of a small area underflows in single precision.
        let across = u.as_dvec3().cross(v.as_dvec3());
        let area = across.length() as f32;
        let far = light.corner.abs().max_element() + u.length() + v.length();
        if !(far <= 1e9 && area.is_finite() && area > 0.0) {
            return Err(SceneError::bad_value(
                "area light",
                "rectangle",
                format!("{} with edges {u} and {v}", light.corner),
                "coordinates within 1e9 m and two edges that span an area",
            ));
        }
        if !(light.radiance.is_finite() && light.radiance.min_element() >= 0.0) {
            return Err(SceneError::bad_value(
                "area light",
                "radiance",
                light.radiance,
                "finite numbers from 0 on",
            ));
        }
        let normal = across.normalize().as_vec3();
        Ok(Self {
            light,
            origin: light.corner + 1e-3 * u.length().min(v.length()) * normal,
            normal,
            area: match light.shape {
                AreaShape::Rectangle => area,
                AreaShape::Disk => 0.25 * std::f32::consts::PI * area,
            },
        })
    }

    /// Unit normal of the side that glows.
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// Area, m².
    pub fn area(&self) -> f32 {
        self.area
    }

    /// The position of a point of [0, 1]², and the radiance that leaves it in every direction
    /// of the front. The mean over the unit square of radiance × [area](AreaSurface::area) ×
    /// cosine is the radiant intensity of the light.
    pub fn point(&self, at: DVec2) -> (Vec3, Vec3) {
        let place: Vec2 = self.light.on_the_light(at);
        let [u, v] = self.light.edges;
        let colour = match &self.light.texture {
            Some(texture) => texture.clamp(place),
            None => Vec3::ONE,
        };
        let position = self.origin + place.x * u + place.y * v;
        (position, self.light.radiance * colour)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Emitter, Pattern, Texture};

    /// A screen whose right half is brighter.
    fn screen(shape: AreaShape) -> AreaLight {
        let texels = vec![Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.0, 0.5, 0.25)];
        AreaLight {
            shape,
            corner: Vec3::new(1.0, 2.0, 3.0),
            edges: [2.0 * Vec3::X, 1.5 * Vec3::Z],
            radiance: Vec3::new(5.0, 4.0, 3.0),
            texture: Some(Texture::new(2, 1, texels).unwrap()),
            ..AreaLight::default()
        }
    }

    #[test]
    fn points_emit_together_what_virtual_lights_do() {
        for shape in [AreaShape::Rectangle, AreaShape::Disk] {
            let light = screen(shape);
            let surface = AreaSurface::new(&light).unwrap();
            let lights = light.virtual_lights(Pattern::Lattice, 500).unwrap();
            let expected: Vec3 = lights.iter().map(Emitter::intensity).sum();
            let n = 200;
            let mut sum = Vec3::ZERO;
            for i in 0..n * n {
                let at = DVec2::new(f64::from(i % n), f64::from(i / n)) + 0.5;
                let (position, radiance) = surface.point(at / f64::from(n));
                sum += radiance;
                let out = position - (light.corner + light.edges[0] / 2.0 + light.edges[1] / 2.0);
                let out = Vec2::new(out.x / 2.0, out.z / 1.5);
                assert!(match shape {
                    AreaShape::Rectangle => out.abs().max_element() <= 0.5 + 1e-5,
                    AreaShape::Disk => out.length() <= 0.5 + 1e-5,
                });
                assert!(((position - light.corner).dot(surface.normal()) - 1.5e-3).abs() < 1e-5);
            }
            let found = sum * surface.area() / (n * n) as f32;
            assert!(
                (found / expected - 1.0).length() < 2e-3,
                "{found} {expected}"
            );
        }
    }

    #[test]
    fn what_is_no_light_is_refused() {
        let light = screen(AreaShape::Rectangle);
        let flat = AreaLight {
            edges: [Vec3::X, 2.0 * Vec3::X],
            ..light.clone()
        };
        let far = AreaLight {
            corner: Vec3::splat(2e9),
            ..light.clone()
        };
        let nowhere = AreaLight {
            corner: Vec3::NAN,
            ..light.clone()
        };
        for bad in [flat, far, nowhere] {
            let error = AreaSurface::new(&bad).unwrap_err().to_string();
            assert!(error.contains("rectangle"), "{error}");
        }
        for radiance in [Vec3::splat(-1.0), Vec3::NAN, Vec3::INFINITY] {
            let bad = AreaLight {
                radiance,
                ..light.clone()
            };
            let error = AreaSurface::new(&bad).unwrap_err().to_string();
            assert!(error.contains("radiance"), "{error}");
        }
    }
}

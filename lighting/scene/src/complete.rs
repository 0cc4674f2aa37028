//! A sensible camera, light and medium for scenes that bring none.

use std::fmt;

use glam::Vec3;

use super::{
    Bounds, Camera, Instance, Light, Medium, Mesh, PhaseFunction, PointLight, Scene, SceneError,
    Translucent,
};

/// Something that was placed because the scene did not bring it. Its
/// `Display` form is a sentence for the user.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Placement {
    /// The whole scene is in view.
    Camera(Camera),
    /// A point light behind and above the scene, as seen from the camera.
    Light(PointLight),
    /// A grey fog through which about half of the light crosses the scene.
    Medium(Medium),
    /// A square floor at this height, which is all that there is to be seen.
    Floor(f32),
}

impl fmt::Display for Placement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Camera(camera) => write!(
                f,
                "the scene has no camera: placed one at {:.3} that sees all of it",
                camera.eye()
            ),
            Self::Light(light) => write!(
                f,
                "the scene has no light: placed a point light at {:.3} of intensity {:.3}",
                light.position, light.intensity.x
            ),
            Self::Medium(medium) => write!(
                f,
                "the scene has no medium: filled it with fog of sigma_s {:.4} and sigma_a {:.4} per metre",
                medium.sigma_s().x,
                medium.sigma_a().x
            ),
            Self::Floor(height) => write!(
                f,
                "the scene has no surfaces: laid a floor below it at y = {height:.3}"
            ),
        }
    }
}

impl Scene {
    /// A box around all that is translucent; `None` if nothing is.
    pub fn translucent_bounds(&self) -> Option<Bounds> {
        let each = self.translucent.iter().filter_map(Translucent::bounds);
        each.reduce(Bounds::around)
    }

    /// Lays a floor below hair and smoke if nothing is placed in the scene but
    /// these, so that there is something to be seen: a square at the lower end
    /// of them, three times as wide as they are.
    pub fn lay_floor(&mut self) -> Option<Placement> {
        let bounds = self.translucent_bounds()?;
        if !self.instances.is_empty() {
            return None;
        }
        let centre = 0.5 * (bounds.min() + bounds.max());
        let size = bounds.max() - bounds.min();
        let (half, height) = (1.5 * size.x.max(size.z), bounds.min().y);
        let corner = |x: f32, z: f32| Vec3::new(centre.x + x * half, height, centre.z + z * half);
        self.meshes.push(Mesh {
            name: "floor".into(),
            positions: vec![
                corner(-1.0, -1.0),
                corner(-1.0, 1.0),
                corner(1.0, 1.0),
                corner(1.0, -1.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        });
        self.instances.push(Instance {
            mesh: self.meshes.len() - 1,
            ..Instance::default()
        });
        Some(Placement::Floor(height))
    }

    /// Places a camera and a light if the scene has none, so that all of
    /// `bounds` is in view, and returns what was placed.
    ///
    /// A medium is never placed here: vacuum is a legitimate medium. See
    /// [`Scene::fill_with_fog`].
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if the bounds are so extreme that no camera
    /// can see them.
    pub fn complete(&mut self, bounds: Bounds) -> Result<Vec<Placement>, SceneError> {
        let centre = 0.5 * (bounds.min() + bounds.max());
        let radius = 0.5 * (bounds.max() - bounds.min()).length();
        let mut placements = Vec::new();
        let camera = match self.camera {
            Some(camera) => camera,
            None => {
                let fov = 0.8_f32;
                let distance = 1.05 * radius / (0.5 * fov).sin();
                let direction = Vec3::new(0.45, 0.35, 1.0).normalize();
                let camera = Camera::look_at(centre + distance * direction, centre, fov)?;
                placements.push(Placement::Camera(camera));
                *self.camera.insert(camera)
            }
        };
        if self.lights.is_empty() {
            let behind = camera.rotation() * Vec3::new(-0.5, 0.6, -0.8);
            let distance = 1.3 * radius;
            let light = PointLight {
                position: centre + distance * behind,
                intensity: Vec3::splat(10.0 * distance * distance),
                ..PointLight::default()
            };
            placements.push(Placement::Light(light.clone()));
            self.lights.push(Light::Point(light));
        }
        Ok(placements)
    }

    /// Fills the air with grey fog of albedo 0.9 if the scene has no medium:
    /// optical depth 0.7 over the diagonal of `bounds`, isotropic.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if the bounds are so small that the
    /// coefficient overflows.
    pub fn fill_with_fog(&mut self, bounds: Bounds) -> Result<Option<Placement>, SceneError> {
        if self.medium.is_some() {
            return Ok(None);
        }
        let sigma_t = Vec3::splat(0.7 / (bounds.max() - bounds.min()).length());
        let medium = Medium::new(0.9 * sigma_t, 0.1 * sigma_t, PhaseFunction::Isotropic)?;
        self.medium = Some(medium);
        Ok(Some(Placement::Medium(medium)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Geometry, Particle, Particles, Profile};

    #[test]
    fn hair_and_smoke_stand_on_a_floor_where_there_is_nothing_else() {
        let puff = Particle {
            centre: Vec3::new(5.0, 2.0, 0.0),
            radius: 1.0,
            sigma_t: 1.0,
        };
        let puffs = Particles::new(vec![puff], Profile::Soft).unwrap();
        let mut scene = Scene {
            translucent: vec![puffs.into()],
            ..Scene::default()
        };
        let placed = scene.lay_floor().unwrap();
        assert!(placed.to_string().contains("y = 1.000"), "{placed}");
        let geometry = Geometry::new(&scene).unwrap();
        assert_eq!(geometry.triangles().len(), 2);
        let [a, b, c] = geometry.triangles()[0];
        assert!((b - a).cross(c - a).y > 0.0, "seen from above");
        assert!(geometry.bounds().max().x > 7.9 && geometry.bounds().min().x < 2.1);
        assert_eq!(scene.lay_floor(), None);
        assert_eq!(Scene::default().lay_floor(), None);
    }

    #[test]
    fn all_of_the_scene_is_in_view_and_nothing_is_replaced() {
        let bounds = Bounds::new(Vec3::new(-3.0, 1.0, 10.0), Vec3::new(5.0, 2.0, 11.0)).unwrap();
        let mut scene = Scene::default();
        let placed = scene.complete(bounds).unwrap();
        assert_eq!(placed.len(), 2);
        let camera = scene.camera.unwrap();
        for corner in 0..8 {
            let pick = |bit: u32, axis: usize| {
                if corner >> bit & 1 == 1 {
                    bounds.max()[axis]
                } else {
                    bounds.min()[axis]
                }
            };
            let point = Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2));
            let local = camera.rotation().inverse() * (point - camera.eye());
            let half = (0.5 * camera.vertical_fov()).tan();
            assert!(local.z < 0.0 && local.y.abs() < -local.z * half, "{local}");
            assert!(local.x.abs() < -local.z * half, "{local}");
        }
        assert_eq!(scene.complete(bounds).unwrap(), vec![]);
        assert!(scene.fill_with_fog(bounds).unwrap().is_some());
        assert!(scene.fill_with_fog(bounds).unwrap().is_none());
        assert!(placed[0].to_string().contains("no camera"));
    }
}

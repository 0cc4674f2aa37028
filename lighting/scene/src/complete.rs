//! A default camera, light, ground and medium for scenes that have none.

use std::fmt;

use glam::Vec3;

use super::{
    Bounds, Camera, Geometry, Instance, Light, Material, Medium, Mesh, PhaseFunction, PointLight,
    Scene, SceneError, Translucent,
};

/// Something that was placed because the scene did not have it. `Display` writes a sentence for
/// the user.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Placement {
    /// A camera that has the whole scene in view, filling the picture.
    Camera(Camera),
    /// A point light in front of the scene, above it and to the left as seen from the camera,
    /// and outside of the picture.
    Light(PointLight),
    /// Grey fog through which about half of the light crosses the scene.
    Medium(Medium),
    /// A square floor at this height, below a scene of nothing but hair and smoke.
    Floor(f32),
    /// A square of ground at this height, on which the scene stands.
    Ground(f32),
}

/// Full vertical field of view of the default camera: 45°.
const FIELD_OF_VIEW: f32 = std::f32::consts::FRAC_PI_4;

/// The direction from the scene to the default camera.
const TO_CAMERA: Vec3 = Vec3::new(0.45, 0.35, 1.0);

/// The share of the picture's width or height that the scene fills, in the direction in which
/// it is larger.
const FILLED: f32 = 0.84;

/// The vector from the scene to the default light in the camera's coordinates (right, up,
/// towards the camera), in radii of the scene. It is so high that no camera that sees just the
/// scene has it in its picture.
const TO_LIGHT: Vec3 = Vec3::new(-1.4, 1.5, 1.0);

/// Half a side of the ground, in radii of the scene.
const GROUND: f32 = 3.0;

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
            Self::Ground(height) => write!(
                f,
                "the scene has no floor: laid ground below it at y = {height:.3}"
            ),
        }
    }
}

impl Scene {
    /// A box around all hair and smoke; `None` if there is none.
    pub fn translucent_bounds(&self) -> Option<Bounds> {
        let each = self.translucent.iter().filter_map(Translucent::bounds);
        each.reduce(Bounds::around)
    }

    /// Adds a floor below hair and smoke if the scene has nothing else, so that there is a
    /// surface to see: a square at their lower end, three times as wide as they are.
    pub fn lay_floor(&mut self) -> Option<Placement> {
        let bounds = self.translucent_bounds()?;
        if !self.instances.is_empty() {
            return None;
        }
        let size = bounds.max() - bounds.min();
        let (half, height) = (1.5 * size.x.max(size.z), bounds.min().y);
        let middle = 0.5 * (bounds.min() + bounds.max());
        self.lay_square("floor", middle.with_y(height), half, None, false);
        Some(Placement::Floor(height))
    }

    /// Adds ground below a scene that has no floor, so that there is a surface for its shadow:
    /// a grey square at its lower end, three times as large, which casts no shadow itself.
    /// `geometry` must be that of the scene.
    ///
    /// A floor is what faces up in the lower quarter of the scene and covers at least half of
    /// its plan.
    pub fn lay_ground(&mut self, geometry: &Geometry) -> Option<Placement> {
        let bounds = match self.translucent_bounds() {
            Some(bounds) => bounds.around(geometry.bounds()),
            None => geometry.bounds(),
        };
        if has_floor(geometry, bounds) {
            return None;
        }
        let radius = 0.5 * (bounds.max() - bounds.min()).length();
        // Slightly below surfaces that lie flat on it.
        let height = bounds.min().y - 1e-4 * radius;
        let middle = 0.5 * (bounds.min() + bounds.max());
        self.materials.push(Material {
            name: "ground".into(),
            base_color: Vec3::splat(0.5),
            ..Material::default()
        });
        let material = Some(self.materials.len() - 1);
        self.lay_square(
            "ground",
            middle.with_y(height),
            GROUND * radius,
            material,
            true,
        );
        Some(Placement::Ground(height))
    }

    /// A square that faces up.
    fn lay_square(
        &mut self,
        name: &str,
        centre: Vec3,
        half: f32,
        material: Option<usize>,
        no_shadow: bool,
    ) {
        let corner = |x: f32, z: f32| centre + half * Vec3::new(x, 0.0, z);
        self.meshes.push(Mesh {
            name: name.into(),
            positions: vec![
                corner(-1.0, -1.0),
                corner(-1.0, 1.0),
                corner(1.0, 1.0),
                corner(1.0, -1.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material,
            ..Mesh::default()
        });
        self.instances.push(Instance {
            mesh: self.meshes.len() - 1,
            no_shadow,
            ..Instance::default()
        });
    }

    /// Places a camera and a light if the scene has none, and returns what was placed. All of
    /// `bounds` is in view in pictures that are at least as wide as high.
    ///
    /// A medium is not placed here, because vacuum is a legitimate medium; see
    /// [`Scene::fill_with_fog`].
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if the bounds are so extreme that no camera can see them.
    pub fn complete(&mut self, bounds: Bounds) -> Result<Vec<Placement>, SceneError> {
        let [min, max] = [bounds.min(), bounds.max()];
        let corners = (0..8).map(|corner| {
            let pick = |axis: usize| [min, max][corner >> axis & 1][axis];
            Vec3::new(pick(0), pick(1), pick(2))
        });
        self.complete_around(bounds, corners, 1.0)
    }

    /// The same with a camera that has all `points` in view from as near as possible, in a
    /// picture whose width is `aspect` times its height. `bounds` must be the bounds of the
    /// points.
    ///
    /// # Errors
    /// As for [`Scene::complete`]; also if no point is finite or `aspect` is not positive.
    pub fn complete_around(
        &mut self,
        bounds: Bounds,
        points: impl Iterator<Item = Vec3>,
        aspect: f32,
    ) -> Result<Vec<Placement>, SceneError> {
        let centre = 0.5 * (bounds.min() + bounds.max());
        let radius = 0.5 * (bounds.max() - bounds.min()).length();
        let mut placements = Vec::new();
        let camera = match self.camera {
            Some(camera) => camera,
            None => {
                let camera = framed(centre, points, aspect)?;
                placements.push(Placement::Camera(camera));
                *self.camera.insert(camera)
            }
        };
        if self.lights.is_empty() {
            let offset = camera.rotation() * (radius * TO_LIGHT);
            let light = PointLight {
                position: centre + offset,
                intensity: Self::placed_intensity(offset.length()),
                ..PointLight::default()
            };
            placements.push(Placement::Light(light.clone()));
            self.lights.push(Light::Point(light));
        }
        Ok(placements)
    }

    /// The radiant intensity of a default light at this distance from the middle of a scene,
    /// W/sr: the irradiance there is 10 W/m².
    pub fn placed_intensity(distance: f32) -> Vec3 {
        Vec3::splat(10.0 * distance * distance)
    }

    /// Fills the air with grey, isotropic fog of albedo 0.9 if the scene has neither a medium
    /// nor fog that thins out. Its optical depth is 0.7 over the diagonal of `bounds`.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if the bounds are so small that the
    /// coefficient overflows.
    pub fn fill_with_fog(&mut self, bounds: Bounds) -> Result<Option<Placement>, SceneError> {
        if self.medium.is_some() || self.height_fog.is_some() {
            return Ok(None);
        }
        let sigma_t = Vec3::splat(0.7 / (bounds.max() - bounds.min()).length());
        let medium = Medium::new(0.9 * sigma_t, 0.1 * sigma_t, PhaseFunction::Isotropic)?;
        self.medium = Some(medium);
        Ok(Some(Placement::Medium(medium)))
    }
}

/// True if what faces up in the lower quarter of the scene, or at nearly the same level as the
/// whole scene, covers at least half of its plan.
fn has_floor(geometry: &Geometry, bounds: Bounds) -> bool {
    let size = (bounds.max() - bounds.min()).as_dvec3();
    let highest = bounds.min().y + 0.25 * (bounds.max().y - bounds.min().y);
    let is_flat = size.y < 0.05 * size.x.max(size.z);
    let area: f64 = geometry
        .triangles()
        .iter()
        .map(|[a, b, c]| {
            let normal = (b - a).as_dvec3().cross((c - a).as_dvec3());
            let is_low = is_flat || (a.y + b.y + c.y) / 3.0 <= highest;
            let faces_up = normal.y > 0.7 * normal.length();
            if is_low && faces_up {
                0.5 * normal.y
            } else {
                0.0
            }
        })
        .sum();
    area >= 0.5 * size.x * size.z
}

/// The camera that looks along −[`TO_CAMERA`] and has all points in view, so that they fill
/// [`FILLED`] of the picture's width or height.
fn framed(
    centre: Vec3,
    points: impl Iterator<Item = Vec3>,
    aspect: f32,
) -> Result<Camera, SceneError> {
    let back = TO_CAMERA.normalize();
    let right = Vec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let tangent = FILLED * (0.5 * FIELD_OF_VIEW).tan();
    let [across, along] = [tangent * aspect, tangent];
    // A point is in view if its distance from the axis is at most `tangent` times its depth.
    // Each side of the frustum is moved until it touches the first point.
    let mut sides = [f32::NEG_INFINITY; 4];
    let mut nearest = f32::NEG_INFINITY;
    for point in points.filter(|point| point.is_finite()) {
        let local = point - centre;
        let (x, y, z) = (local.dot(right), local.dot(up), local.dot(back));
        let reach = [
            x + across * z,
            -x + across * z,
            y + along * z,
            -y + along * z,
        ];
        for (side, reach) in sides.iter_mut().zip(reach) {
            *side = side.max(reach);
        }
        nearest = nearest.max(z);
    }
    let [r, l, t, b] = sides;
    let distance = (0.5 * (r + l) / across).max(0.5 * (t + b) / along);
    // A single point would be at the eye.
    let distance = distance.max(nearest + 1e-3 * (1.0 + centre.abs().max_element()));
    let target = centre + 0.5 * (r - l) * right + 0.5 * (t - b) * up;
    Camera::look_at(target + distance * back, target, FIELD_OF_VIEW)
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

    fn cube() -> Mesh {
        let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        Mesh {
            positions: (0..8).map(corner).collect(),
            triangles: [
                [0, 2, 3],
                [0, 3, 1],
                [4, 5, 7],
                [4, 7, 6],
                [0, 1, 5],
                [0, 5, 4],
                [2, 6, 7],
                [2, 7, 3],
                [0, 4, 6],
                [0, 6, 2],
                [1, 3, 7],
                [1, 7, 5],
            ]
            .to_vec(),
            ..Mesh::default()
        }
    }

    #[test]
    fn ground_is_laid_below_what_stands_on_none() {
        let mut scene = Scene::from(cube());
        let geometry = Geometry::new(&scene).unwrap();
        let placed = scene.lay_ground(&geometry).unwrap();
        assert!(placed.to_string().contains("no floor"), "{placed}");
        assert!(scene.instances[1].no_shadow);
        let geometry = Geometry::new(&scene).unwrap();
        let [a, b, c] = geometry.triangles()[12];
        assert!((b - a).cross(c - a).y > 0.0 && a.y < 0.0 && a.y > -1e-3);
        // Now there is a floor.
        assert_eq!(scene.lay_ground(&geometry), None);
    }

    #[test]
    fn a_floor_is_known_whether_flat_or_under_something() {
        let flat = |half: f32, y: f32| Mesh {
            positions: [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
                .map(|(x, z)| Vec3::new(half * x, y, half * z))
                .to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        let with = |mesh: Mesh| {
            let mut scene = Scene::from(cube());
            scene.meshes.push(mesh);
            scene.instances.push(Instance {
                mesh: 1,
                ..Instance::default()
            });
            let geometry = Geometry::new(&scene).unwrap();
            has_floor(&geometry, geometry.bounds())
        };
        assert!(with(flat(3.0, 0.0)));
        assert!(!with(flat(3.0, 1.0)), "a roof");
        let geometry = Geometry::new(&Scene::from(flat(1.0, 0.0))).unwrap();
        assert!(
            has_floor(&geometry, geometry.bounds()),
            "nothing but a floor"
        );
    }

    #[test]
    fn the_scene_touches_the_border_of_its_frame_and_the_light_is_outside() {
        let sphere = |i: u32| {
            let (a, b) = (i as f32 * 0.1, i as f32 * 1.7);
            Vec3::new(2.0 * a.sin() * b.cos(), a.cos(), a.sin() * b.sin()) + 10.0
        };
        let thin = |i: u32| Vec3::new(0.01 * (i % 2) as f32, i as f32, 0.0);
        let flat = |i: u32| Vec3::new((i % 8) as f32, 0.0, (i / 8) as f32);
        let shapes: [&dyn Fn(u32) -> Vec3; 3] = [&sphere, &thin, &flat];
        for (shape, aspect) in shapes.into_iter().flat_map(|s| [(s, 1.0), (s, 16.0 / 9.0)]) {
            let points: Vec<Vec3> = (0..64).map(shape).collect();
            let min = points.iter().copied().reduce(Vec3::min).unwrap();
            let max = points.iter().copied().reduce(Vec3::max).unwrap();
            let bounds = Bounds::new(min, max + 1e-4).unwrap();
            let mut scene = Scene::default();
            let all = points.iter().copied();
            scene.complete_around(bounds, all, aspect).unwrap();
            let camera = scene.camera.unwrap();
            let on_picture = |point: Vec3| {
                let local = camera.rotation().inverse() * (point - camera.eye());
                let half = -local.z * (0.5 * camera.vertical_fov()).tan();
                (local.z < 0.0).then_some([local.x / half / aspect, local.y / half])
            };
            let farthest = points
                .iter()
                .flat_map(|point| on_picture(*point).unwrap())
                .fold(0.0, |most: f32, place| most.max(place.abs()));
            assert!((farthest - FILLED).abs() < 1e-3, "{farthest}");
            let [Light::Point(light)] = &scene.lights[..] else {
                panic!("one point light");
            };
            // Above the picture or behind the camera.
            let place = on_picture(light.position);
            assert!(place.is_none_or(|[_, y]| y > 1.05), "{place:?}");
        }
    }

    #[test]
    fn a_point_is_seen_from_a_distance() {
        let bounds = Bounds::new(Vec3::splat(5.0), Vec3::splat(5.000_01)).unwrap();
        let mut scene = Scene::default();
        let point = std::iter::once(Vec3::splat(5.0));
        scene.complete_around(bounds, point, 1.0).unwrap();
        assert!(scene.camera.is_some());
        let none = Scene::default().complete_around(bounds, std::iter::empty(), 1.0);
        assert!(none.is_err());
    }

    #[test]
    fn all_of_the_scene_is_in_view_and_nothing_is_replaced() {
        let bounds = Bounds::new(Vec3::new(-3.0, 1.0, 10.0), Vec3::new(5.0, 2.0, 11.0)).unwrap();
        let mut scene = Scene::default();
        let placed = scene.complete(bounds).unwrap();
        assert_eq!(placed.len(), 2);
        let camera = scene.camera.unwrap();
        for corner in bounds.corners() {
            let local = camera.rotation().inverse() * (corner - camera.eye());
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

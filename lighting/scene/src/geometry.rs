//! The triangles of a scene in world space, checked.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{Vec3, Vec4};

use super::caster::{Caster, interpolate};
use super::coatings::{Coatings, CoatingsOf};
use super::{AlphaMode, Bounds, Instance, Material, Mesh, Scene, SceneError, is_near};

/// The largest number of triangles of a scene after its instances are expanded: 2²⁶, which
/// takes 3 GiB with additional data. It takes twice as much if some are dynamic, because the
/// static and the dynamic part are kept in addition to the whole.
pub const MAX_TRIANGLES: u64 = 1 << 26;

/// All triangles of a scene in world space, which are known to be finite.
///
/// Triangles without area are left out, as they can neither be seen nor cast a shadow.
/// [`Geometry::dropped`] gives their number.
///
/// # Static and dynamic triangles
///
/// A scene may mark [instances](Instance::dynamic) that move. All triangles are in one list,
/// because most callers make no difference. [`Geometry::static_part`] and
/// [`Geometry::dynamic_part`] have the triangles of one kind, with their own bounds.
#[derive(Debug, Clone)]
pub struct Geometry {
    triangles: Vec<[Vec3; 3]>,
    sources: Vec<Source>,
    dropped: usize,
    bounds: Bounds,
    coatings: Coatings,
    parts: Option<Arc<Parts>>,
}

/// The two parts of a scene in which some triangles move.
#[derive(Debug)]
struct Parts {
    /// `None` if all triangles are dynamic.
    fixed: Option<Geometry>,
    dynamic: Geometry,
}

/// What a point of a surface looks like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Appearance {
    /// Share of the light that is reflected diffusely, linear RGB: the base
    /// colour with texture and vertex colour, times the share of the point that
    /// is covered and not transmitted.
    pub albedo: Vec3,
    /// Radiance that leaves the front, linear RGB, times the share of the point
    /// that is covered.
    pub emitted: Vec3,
    /// Radiance that leaves the back: the same if the material is double-sided,
    /// else nothing.
    pub emitted_behind: Vec3,
}

/// The origin of a triangle in the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source {
    /// Index into [`Scene::instances`].
    pub instance: u32,
    /// Index into [`Mesh::triangles`].
    pub triangle: u32,
}

impl Geometry {
    /// Expands the instances of a scene.
    ///
    /// # Errors
    /// [`SceneError::Empty`] if no triangle with an area is left,
    /// [`SceneError::TooManyTriangles`], [`SceneError::IndexOutOfRange`],
    /// [`SceneError::LengthMismatch`] for texture coordinates and vertex colours,
    /// and [`SceneError::BadValue`] for positions that are not finite or farther
    /// out than 1e9 m, for vertex colours that are negative or not finite, and
    /// for an opacity or a transmission that is not from 0 to 1.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        check(scene, &scene.meshes)?;
        let whole = Self::expand(scene, |_| true)?;
        if scene.instances.iter().all(|instance| !instance.dynamic) {
            return Ok(whole);
        }
        let dynamic = match Self::expand(scene, |instance| instance.dynamic) {
            // The marked instances have no area.
            Err(SceneError::Empty) => return Ok(whole),
            dynamic => dynamic?,
        };
        let fixed = match Self::expand(scene, |instance| !instance.dynamic) {
            Err(SceneError::Empty) => None,
            fixed => Some(fixed?),
        };
        Ok(Self {
            parts: Some(Arc::new(Parts { fixed, dynamic })),
            ..whole
        })
    }

    /// The triangles of the [dynamic](Instance::dynamic) instances of a scene alone, which is
    /// all that has to be expanded anew for a frame in which nothing else has moved.
    ///
    /// It is an ordinary geometry without parts.
    ///
    /// # Errors
    /// As for [`Geometry::new`], which checks the static instances too; [`SceneError::Empty`]
    /// if no triangle is dynamic.
    pub fn of_dynamic(scene: &Scene) -> Result<Self, SceneError> {
        let dynamic = scene.instances.iter().filter(|instance| instance.dynamic);
        let meshes: BTreeSet<usize> = dynamic.map(|instance| instance.mesh).collect();
        let meshes = meshes.iter().filter_map(|mesh| scene.meshes.get(*mesh));
        check(scene, meshes)?;
        Self::expand(scene, |instance| instance.dynamic)
    }

    /// Expands some of the instances; their meshes must have been checked.
    fn expand(scene: &Scene, is_wanted: impl Fn(&Instance) -> bool) -> Result<Self, SceneError> {
        let mut total = 0_u64;
        for (index, instance) in scene.instances.iter().enumerate() {
            let mesh =
                scene
                    .meshes
                    .get(instance.mesh)
                    .ok_or_else(|| SceneError::IndexOutOfRange {
                        owner: format!("instance {index}"),
                        what: "mesh",
                        index: instance.mesh as u64,
                        count: scene.meshes.len() as u64,
                    })?;
            if is_wanted(instance) {
                total = total.saturating_add(mesh.triangles.len() as u64);
            }
        }
        if total > MAX_TRIANGLES {
            return Err(SceneError::TooManyTriangles {
                triangles: total,
                limit: MAX_TRIANGLES,
            });
        }

        let mut triangles = Vec::with_capacity(total as usize);
        let mut sources = Vec::with_capacity(total as usize);
        let mut coatings = CoatingsOf::new(scene);
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let wanted = scene.instances.iter().enumerate();
        for (index, instance) in wanted.filter(|(_, instance)| is_wanted(instance)) {
            let mesh = &scene.meshes[instance.mesh];
            let coat = coatings.coat(mesh);
            for (number, corners) in mesh.triangles.iter().enumerate() {
                let triangle = corners.map(|corner| {
                    instance
                        .transform
                        .transform_point3(mesh.positions[corner as usize])
                });
                for corner in triangle {
                    if !is_near(corner) {
                        return Err(SceneError::bad_value(
                            format!("instance {index} of {}", describe(mesh)),
                            "a position in the world",
                            corner,
                            "finite coordinates within 1e9 m",
                        ));
                    }
                }
                let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
                if (b - a).cross(c - a) == glam::DVec3::ZERO {
                    continue;
                }
                for corner in triangle {
                    min = min.min(corner);
                    max = max.max(corner);
                }
                coatings.push(mesh, *corners, coat, instance.no_shadow);
                triangles.push(triangle);
                sources.push(Source {
                    instance: index as u32,
                    triangle: number as u32,
                });
            }
        }
        if triangles.is_empty() {
            return Err(SceneError::Empty);
        }
        // A flat scene needs a box with a volume.
        let margin = (1e-6
            * (max - min)
                .max_element()
                .max(min.abs().max(max.abs()).max_element()))
        .max(1e-6);
        let bounds = Bounds::new(min - margin, max + margin)?;
        Ok(Self {
            dropped: total as usize - triangles.len(),
            triangles,
            sources,
            bounds,
            coatings: coatings.finish(),
            parts: None,
        })
    }

    /// The triangles of static instances: this geometry itself if none are dynamic, and `None`
    /// if all are.
    pub fn static_part(&self) -> Option<&Self> {
        match &self.parts {
            None => Some(self),
            Some(parts) => parts.fixed.as_ref(),
        }
    }

    /// The triangles of [dynamic](Instance::dynamic) instances; `None` if there are none.
    pub fn dynamic_part(&self) -> Option<&Self> {
        self.parts.as_ref().map(|parts| &parts.dynamic)
    }

    /// The corners of every triangle, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[Vec3; 3]] {
        &self.triangles
    }

    /// The origin of each triangle, in the same order.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Number of triangles without area that were left out.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// A box around all triangles, slightly larger than the tightest one.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// What a triangle does to light that meets it.
    ///
    /// # Panics
    /// If `triangle` is not an index of [`Geometry::triangles`].
    pub fn caster(&self, triangle: usize) -> Caster<'_> {
        assert!(triangle < self.triangles.len(), "no triangle {triangle}");
        self.coatings.caster(triangle)
    }

    /// What all triangles do to light; copies share their memory.
    pub fn coatings(&self) -> &Coatings {
        &self.coatings
    }

    /// True if no light passes through any triangle: each is
    /// [`Caster::Solid`].
    pub fn all_solid(&self) -> bool {
        self.coatings.all_solid()
    }

    /// What the surface looks like at the barycentric coordinates (`u`, `v`) of
    /// the second and third corner of a triangle.
    ///
    /// # Panics
    /// If `triangle` is not an index of [`Geometry::triangles`] or `scene` is
    /// not the one this was made from.
    pub fn appearance(&self, scene: &Scene, triangle: usize, u: f32, v: f32) -> Appearance {
        let (material, coordinates) = self.surface(scene, triangle, u, v);
        let plain = Material::default();
        let material = material.unwrap_or(&plain);
        let source = self.sources[triangle];
        let mesh = &scene.meshes[scene.instances[source.instance as usize].mesh];
        let vertex = match mesh.colors.as_slice() {
            [] => Vec4::ONE,
            colors => {
                let corners = mesh.triangles[source.triangle as usize];
                interpolate(corners.map(|corner| colors[corner as usize]), u, v)
            }
        };
        let texture = material.base_color_texture.as_ref().zip(coordinates);
        let (mut color, mut opacity) = (Vec3::ONE, 1.0);
        if let Some((texture, uv)) = texture {
            color = texture.sample(uv);
            opacity = texture.sample_alpha(uv);
        }
        let opacity = (material.opacity * vertex.w * opacity).clamp(0.0, 1.0);
        let covered = match material.alpha {
            AlphaMode::Opaque => 1.0,
            // Rays decide in f64 whether a mask covers a point; this keeps its border from
            // being black.
            AlphaMode::Mask { cutoff } if opacity >= cutoff - 1e-5 => 1.0,
            AlphaMode::Mask { .. } => 0.0,
            AlphaMode::Blend => opacity,
        };
        let emitted = covered * material.emitted;
        let mut transmission = material.transmission;
        if let Some(texture) = &material.transmission_texture
            && !mesh.transmission_coordinates.is_empty()
        {
            let at = |corner: u32| mesh.transmission_coordinates[corner as usize];
            let uv = interpolate(mesh.triangles[source.triangle as usize].map(at), u, v);
            transmission *= texture.sample(uv).x.min(1.0);
        }
        Appearance {
            albedo: covered
                * (1.0 - transmission)
                * (material.base_color * vertex.truncate() * color),
            emitted,
            emitted_behind: if material.double_sided {
                emitted
            } else {
                Vec3::ZERO
            },
        }
    }

    /// The material of a triangle and, if its mesh has them, the texture
    /// coordinates at the barycentric coordinates (`u`, `v`) of its second and
    /// third corner.
    ///
    /// # Panics
    /// If `triangle` is not an index of [`Geometry::triangles`] or `scene` is
    /// not the one this was made from.
    pub fn surface<'a>(
        &self,
        scene: &'a Scene,
        triangle: usize,
        u: f32,
        v: f32,
    ) -> (Option<&'a Material>, Option<glam::Vec2>) {
        let source = self.sources[triangle];
        let mesh = &scene.meshes[scene.instances[source.instance as usize].mesh];
        let [a, b, c] = mesh.triangles[source.triangle as usize];
        let coordinates = (!mesh.texture_coordinates.is_empty()).then(|| {
            let at = |corner: u32| mesh.texture_coordinates[corner as usize];
            interpolate([a, b, c].map(at), u, v)
        });
        (
            mesh.material.map(|index| &scene.materials[index]),
            coordinates,
        )
    }
}

fn describe(mesh: &Mesh) -> String {
    if mesh.name.is_empty() {
        "a mesh".into()
    } else {
        format!("mesh \"{}\"", mesh.name)
    }
}

/// Checks some of the meshes, and all materials.
fn check<'a>(scene: &Scene, meshes: impl IntoIterator<Item = &'a Mesh>) -> Result<(), SceneError> {
    for mesh in meshes {
        check_mesh(mesh, scene.materials.len())?;
    }
    for (index, material) in scene.materials.iter().enumerate() {
        check_material(material, index)?;
    }
    Ok(())
}

fn check_mesh(mesh: &Mesh, materials: usize) -> Result<(), SceneError> {
    let out_of_range = |what, index: u64, count: usize| SceneError::IndexOutOfRange {
        owner: describe(mesh),
        what,
        index,
        count: count as u64,
    };
    if let Some(index) = mesh.material
        && index >= materials
    {
        return Err(out_of_range("material", index as u64, materials));
    }
    let vertices = mesh.positions.len();
    for (what, coordinates) in [
        ("texture coordinates", &mesh.texture_coordinates),
        (
            "coordinates of the transmission texture",
            &mesh.transmission_coordinates,
        ),
    ] {
        if !coordinates.is_empty() && coordinates.len() != vertices {
            return Err(SceneError::LengthMismatch {
                owner: describe(mesh),
                what,
                actual: coordinates.len(),
                expected: vertices,
            });
        }
    }
    if !mesh.colors.is_empty() && mesh.colors.len() != vertices {
        return Err(SceneError::LengthMismatch {
            owner: describe(mesh),
            what: "vertex colours",
            actual: mesh.colors.len(),
            expected: vertices,
        });
    }
    let is_bad = |color: &Vec4| !color.is_finite() || color.min_element() < 0.0;
    if let Some(index) = mesh.colors.iter().position(is_bad) {
        return Err(SceneError::bad_value(
            format!("{}, vertex {index}", describe(mesh)),
            "colour",
            mesh.colors[index],
            "finite, not negative",
        ));
    }
    for corner in mesh.triangles.iter().flatten() {
        if *corner as usize >= vertices {
            return Err(out_of_range("vertex", u64::from(*corner), vertices));
        }
    }
    if let Some((index, position)) = mesh
        .positions
        .iter()
        .enumerate()
        .find(|(_, position)| !position.is_finite())
    {
        return Err(SceneError::bad_value(
            format!("{}, vertex {index}", describe(mesh)),
            "position",
            position,
            "finite coordinates",
        ));
    }
    Ok(())
}

fn check_material(material: &Material, index: usize) -> Result<(), SceneError> {
    let mut owner = format!("material {index}");
    if !material.name.is_empty() {
        owner = format!("{owner} \"{}\"", material.name);
    }
    for (what, value) in [
        ("opacity", material.opacity),
        ("transmission", material.transmission),
    ] {
        if !(0.0..=1.0).contains(&value) {
            return Err(SceneError::bad_value(owner, what, value, "0 to 1"));
        }
    }
    match material.alpha {
        AlphaMode::Mask { cutoff } if !cutoff.is_finite() => Err(SceneError::bad_value(
            owner,
            "alpha cutoff",
            cutoff,
            "a finite number",
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::Instance;

    fn scene(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Scene {
        Scene {
            meshes: vec![Mesh {
                positions,
                triangles,
                ..Mesh::default()
            }],
            instances: vec![Instance {
                mesh: 0,
                transform: Affine3A::from_translation(Vec3::Z),
                ..Instance::default()
            }],
            ..Scene::default()
        }
    }

    #[test]
    fn instances_are_expanded_and_flat_triangles_dropped() {
        let mut scene = scene(
            vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X * 0.5],
            vec![[0, 1, 2], [0, 1, 3], [2, 2, 1]],
        );
        scene.instances.push(scene.instances[0].clone());
        let geometry = Geometry::new(&scene).unwrap();
        assert_eq!(geometry.triangles().len(), 2);
        assert_eq!(geometry.dropped(), 4);
        assert_eq!(geometry.triangles()[0][1], Vec3::new(1.0, 0.0, 1.0));
        assert_eq!(geometry.sources()[1].instance, 1);
        assert!(geometry.bounds().min().z < geometry.bounds().max().z);
    }

    #[test]
    fn static_and_dynamic_triangles_are_all_of_a_scene() {
        let mut scene = scene(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
        scene.instances[0].name = "wall".into();
        let whole = Geometry::new(&scene).unwrap();
        assert!(whole.dynamic_part().is_none());
        let fixed = whole.static_part().unwrap();
        assert_eq!(fixed.triangles(), whole.triangles());

        scene.instances.push(Instance {
            name: "car".into(),
            transform: Affine3A::from_translation(5.0 * Vec3::X),
            no_shadow: true,
            ..Instance::default()
        });
        assert_eq!(scene.set_dynamic("car", true), 1);
        let whole = Geometry::new(&scene).unwrap();
        let (fixed, dynamic) = (whole.static_part().unwrap(), whole.dynamic_part().unwrap());
        assert_eq!(fixed.triangles(), &whole.triangles()[..1]);
        assert_eq!(dynamic.triangles(), &whole.triangles()[1..]);
        assert_eq!(dynamic.sources()[0].instance, 1);
        assert_eq!(
            [fixed.caster(0), dynamic.caster(0)],
            [Caster::Solid, Caster::Absent]
        );
        assert!(fixed.bounds().max().x < 2.0 && dynamic.bounds().min().x > 4.0);
        let moved = Geometry::of_dynamic(&scene).unwrap();
        assert_eq!(moved.triangles(), dynamic.triangles());

        assert_eq!(scene.set_dynamic("wall", true), 1);
        let whole = Geometry::new(&scene).unwrap();
        assert!(whole.static_part().is_none());
        let dynamic = whole.dynamic_part().unwrap();
        assert_eq!(dynamic.triangles(), whole.triangles());
    }

    #[test]
    fn bad_geometry_names_its_cause() {
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let cases = [
            (scene(corners.clone(), vec![]), "no triangles"),
            (scene(corners.clone(), vec![[0, 1, 1]]), "no triangles"),
            (scene(corners.clone(), vec![[0, 1, 7]]), "vertex index 7"),
            (
                scene(vec![Vec3::ZERO, Vec3::NAN, Vec3::Y], vec![[0, 1, 2]]),
                "vertex 1",
            ),
            (
                scene(vec![Vec3::ZERO, Vec3::X * 2e9, Vec3::Y], vec![[0, 1, 2]]),
                "1e9",
            ),
        ];
        for (scene, cause) in cases {
            let error = Geometry::new(&scene).unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
        let mut scene = scene(corners, vec![[0, 1, 2]]);
        scene.instances[0].mesh = 3;
        assert!(Geometry::new(&scene).is_err());
    }

    #[test]
    fn vertex_colours_are_interpolated_and_multiply_the_base_colour() {
        let mut scene = scene(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
        scene.materials.push(Material {
            base_color: Vec3::new(1.0, 0.5, 1.0),
            emitted: Vec3::splat(2.0),
            ..Material::default()
        });
        scene.meshes[0].material = Some(0);
        let colors = [Vec3::X, Vec3::Y, Vec3::Z];
        scene.meshes[0].colors = colors.map(|c| c.extend(1.0)).to_vec();
        let geometry = Geometry::new(&scene).unwrap();
        let appearance = geometry.appearance(&scene, 0, 0.5, 0.25);
        assert!((appearance.albedo - Vec3::splat(0.25)).length() < 1e-6);
        assert_eq!(appearance.emitted, Vec3::splat(2.0));
        assert_eq!(appearance.emitted_behind, Vec3::ZERO, "dark behind");
        scene.materials[0].double_sided = true;
        let appearance = geometry.appearance(&scene, 0, 0.5, 0.25);
        assert_eq!(appearance.emitted_behind, Vec3::splat(2.0));
        for (color, cause) in [(Vec4::splat(-1.0), "vertex 1"), (Vec4::NAN, "not negative")] {
            scene.meshes[0].colors[1] = color;
            let error = Geometry::new(&scene).unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
        scene.meshes[0].colors.pop();
        assert!(Geometry::new(&scene).is_err());
    }

    #[test]
    fn materials_out_of_their_domain_are_refused() {
        let mut scene = scene(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
        let plain = Material {
            name: "glass".into(),
            ..Material::default()
        };
        for (material, cause) in [
            (
                Material {
                    opacity: 1.5,
                    ..plain.clone()
                },
                "opacity",
            ),
            (
                Material {
                    transmission: f32::NAN,
                    ..plain.clone()
                },
                "\"glass\": transmission",
            ),
            (
                Material {
                    alpha: AlphaMode::Mask {
                        cutoff: f32::INFINITY,
                    },
                    ..plain
                },
                "cutoff",
            ),
        ] {
            scene.materials = vec![material];
            let error = Geometry::new(&scene).unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
    }

    #[test]
    fn more_triangles_than_fit_are_refused_before_they_are_made() {
        let mut scene = scene(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]; 1 << 16]);
        scene.instances = vec![scene.instances[0].clone(); (1 << 10) + 1];
        assert!(matches!(
            Geometry::new(&scene),
            Err(SceneError::TooManyTriangles { .. })
        ));
    }
}

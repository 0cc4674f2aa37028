//! The triangles of a scene in world space, checked.

use glam::Vec3;

use super::{Bounds, Material, Mesh, Scene, SceneError, is_near};

/// The largest number of triangles a scene may have once its instances are
/// expanded: 2²⁶, which is 3 GiB with its bookkeeping.
pub const MAX_TRIANGLES: u64 = 1 << 26;

/// All triangles of a scene in world space, known to be finite.
///
/// Triangles without area are left out: they can neither be seen nor cast a
/// shadow. [`Geometry::dropped`] tells how many there were.
#[derive(Debug, Clone)]
pub struct Geometry {
    triangles: Vec<[Vec3; 3]>,
    sources: Vec<Source>,
    dropped: usize,
    bounds: Bounds,
}

/// Where a world-space triangle came from.
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
    /// [`SceneError::LengthMismatch`] for texture coordinates, and
    /// [`SceneError::BadValue`] for positions that are not finite or farther
    /// out than 1e9 m.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        for mesh in &scene.meshes {
            check_mesh(mesh, scene.materials.len())?;
        }
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
            total = total.saturating_add(mesh.triangles.len() as u64);
        }
        if total > MAX_TRIANGLES {
            return Err(SceneError::TooManyTriangles {
                triangles: total,
                limit: MAX_TRIANGLES,
            });
        }

        let mut triangles = Vec::with_capacity(total as usize);
        let mut sources = Vec::with_capacity(total as usize);
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for (index, instance) in scene.instances.iter().enumerate() {
            let mesh = &scene.meshes[instance.mesh];
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
        // A flat scene still gets a box with a volume.
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
        })
    }

    /// The corners of every triangle, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[Vec3; 3]] {
        &self.triangles
    }

    /// Where each triangle came from, in the same order.
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
            at(a) * (1.0 - u - v) + at(b) * u + at(c) * v
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
    if !mesh.texture_coordinates.is_empty() && mesh.texture_coordinates.len() != vertices {
        return Err(SceneError::LengthMismatch {
            owner: describe(mesh),
            what: "texture coordinates",
            actual: mesh.texture_coordinates.len(),
            expected: vertices,
        });
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
        scene.instances.push(scene.instances[0]);
        let geometry = Geometry::new(&scene).unwrap();
        assert_eq!(geometry.triangles().len(), 2);
        assert_eq!(geometry.dropped(), 4);
        assert_eq!(geometry.triangles()[0][1], Vec3::new(1.0, 0.0, 1.0));
        assert_eq!(geometry.sources()[1].instance, 1);
        assert!(geometry.bounds().min().z < geometry.bounds().max().z);
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
    fn more_triangles_than_fit_are_refused_before_they_are_made() {
        let mut scene = scene(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]; 1 << 16]);
        scene.instances = vec![scene.instances[0]; (1 << 10) + 1];
        assert!(matches!(
            Geometry::new(&scene),
            Err(SceneError::TooManyTriangles { .. })
        ));
    }
}

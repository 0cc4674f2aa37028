//! Shadow maps of all kinds of lights, and the step that renders them.

use glam::Vec3;
use gpu_backend::{Backend, BufferOf, Cpu, Error, Host, Memory};

use super::Casters;
use super::masked::Masked;
use crate::scene::raster::{Face, Footprint, Rays, nearest_depths};
use crate::scene::{Bounds, Emission, Emitter, Geometry};
use crate::visibility::PointVisibility;

/// Depth of a texel in which the light sees nothing. It is finite, because shaders must not
/// meet an infinity.
pub const EMPTY: f32 = f32::MAX;

/// Larger shadow maps are refused: 4 GiB.
const MAX_BYTES: u64 = 1 << 32;

/// Spotlights wider than this (tangent of 75°) get a cube of maps.
const WIDEST_TAN: f32 = 3.732;

/// Rows in which masked triangles are rendered as one unit of work.
const BAND: u32 = 16;

/// Why a shadow map could not be rendered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowMapError {
    /// The resolution is 0 or above 65536.
    #[error("a shadow map of {resolution} texels per side was asked for, expected 1 to 65536")]
    Resolution {
        /// Texels per side asked for.
        resolution: u32,
    },
    /// The distances between which cascades should lie are out of range, or not in this order.
    #[error(
        "cascades from {near} to {far} m were asked for, expected 1e-12 m or more for the first \
         distance, and more than that but at most 1e12 m for the second"
    )]
    CascadeDistances {
        /// The first distance, m.
        near: f32,
        /// The second distance, m.
        far: f32,
    },
    /// The view that cascades cover has no pixels.
    #[error("cascades of a view of {width} x {height} pixels were asked for, expected 1 or more")]
    ViewSize {
        /// Pixels along x.
        width: u32,
        /// Pixels along y.
        height: u32,
    },
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] Error),
}

/// The depth of the first blocker in every direction from a light.
#[derive(Debug)]
pub struct ShadowMap<M: Memory> {
    faces: Vec<Face>,
    resolution: u32,
    depth: M::Buffer<f32>,
}

impl<M: Memory> ShadowMap<M> {
    /// One face, or six in the order +X −X +Y −Y +Z −Z.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Texels per side of each face.
    pub fn resolution(&self) -> u32 {
        self.resolution
    }

    /// Depths, face by face, each row by row from the top; [`EMPTY`] where the
    /// light sees nothing.
    pub fn depth(&self) -> &M::Buffer<f32> {
        &self.depth
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        map_bytes(self.faces.len(), self.resolution)
    }
}

fn map_bytes(faces: usize, resolution: u32) -> u64 {
    4 * faces as u64 * u64::from(resolution) * u64::from(resolution)
}

impl ShadowMap<Host> {
    /// Copies the map to another backend.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if it does not fit there.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<ShadowMap<B::Memory>, Error> {
        Ok(ShadowMap {
            faces: self.faces.clone(),
            resolution: self.resolution,
            depth: backend.upload(&self.depth)?,
        })
    }

    /// True if no blocker in the map lies between the light and `point`. Points outside of the
    /// picture are lit: an orthographic map contains all casters, and a spotlight does not
    /// light such points anyway.
    #[inline]
    pub fn is_lit(&self, point: Vec3) -> bool {
        let (face, v) = face_towards(&self.faces, point);
        depth_of(&self.faces[face], v) <= self.depth_along(face, v)
    }

    /// The depth in the texel in which a face shows its origin plus `v`; infinite outside of
    /// the picture.
    #[inline]
    fn depth_along(&self, index: usize, v: Vec3) -> f32 {
        let Some(texel) = texel_along(&self.faces[index], self.resolution, v) else {
            return f32::INFINITY;
        };
        // The far border of the picture belongs to the last texel.
        let last = self.resolution - 1;
        let [column, row] = texel.map(|position| (position as u32).min(last) as usize);
        let side = self.resolution as usize;
        self.depth[(index * side + row) * side + column]
    }
}

impl PointVisibility for ShadowMap<Host> {
    type Share = f32;

    fn visibility(&self, point: Vec3) -> f32 {
        f32::from(u8::from(self.is_lit(point)))
    }
}

#[cfg(feature = "voxel-shadow")]
impl voxel_shadow::FirstBlocker for ShadowMap<Host> {
    /// The depth of the texel that the light ray falls into; none outside of the picture.
    #[inline]
    fn distance(&self, ray: &epipolar::LightRay) -> f32 {
        let direction = Vec3::from(ray.direction);
        let (face, v) = match self.faces[0].rays {
            Rays::Parallel { .. } => (0, Vec3::from(ray.origin) - self.faces[0].origin),
            // All faces have the light as their origin.
            Rays::Central { .. } => (face_along(self.faces.len(), direction), direction),
        };
        let depth = self.depth_along(face, v);
        match self.faces[face].rays {
            Rays::Parallel { .. } if depth < EMPTY => depth - v.dot(self.faces[face].forward),
            _ => depth,
        }
    }
}

/// The face that shows `point`, and the vector to the point from the common origin of all
/// faces.
#[inline]
pub(crate) fn face_towards(faces: &[Face], point: Vec3) -> (usize, Vec3) {
    let v = point - faces[0].origin;
    (face_along(faces.len(), v), v)
}

/// Which of `faces` faces shows what lies in the direction `v` from the light.
#[inline]
pub(super) fn face_along(faces: usize, v: Vec3) -> usize {
    match faces {
        1 => 0,
        _ => cube_face(v),
    }
}

/// The depth, in the sense of a face, of its origin plus `v`.
#[inline]
fn depth_of(face: &Face, v: Vec3) -> f32 {
    match face.rays {
        Rays::Parallel { .. } => v.dot(face.forward),
        Rays::Central { .. } => v.length(),
    }
}

/// Column and row, from 0 to the resolution, at which a face shows its origin plus `v`; `None`
/// outside of the picture.
#[inline]
pub(super) fn texel_along(face: &Face, resolution: u32, v: Vec3) -> Option<[f32; 2]> {
    let (x, y) = (v.dot(face.right), v.dot(face.up));
    let (u, w) = match face.rays {
        Rays::Parallel {
            half_width,
            half_height,
        } => (x / half_width, y / half_height),
        Rays::Central { tan } => {
            let z = v.dot(face.forward);
            if z <= 0.0 {
                return None;
            }
            let scale = 1.0 / (z * tan);
            (x * scale, y * scale)
        }
    };
    let n = resolution as f32;
    let (column, row) = (0.5 * n * (1.0 + u), 0.5 * n * (1.0 - w));
    let inside = column >= 0.0 && column <= n && row >= 0.0 && row <= n;
    inside.then_some([column, row])
}

/// The place of a point in the pictures of a light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    /// Index of the picture.
    pub(crate) face: usize,
    /// Column and row, from 0 to the resolution.
    pub(crate) texel: [f32; 2],
    pub(crate) depth: f32,
}

/// Finds a point in the pictures of a light; `None` outside of them.
#[inline]
pub(crate) fn locate(faces: &[Face], resolution: u32, point: Vec3) -> Option<Place> {
    let (face, v) = face_towards(faces, point);
    Some(Place {
        face,
        texel: texel_along(&faces[face], resolution, v)?,
        depth: depth_of(&faces[face], v),
    })
}

/// Which face of a cube the direction points at.
#[inline]
pub(super) fn cube_face(v: Vec3) -> usize {
    let a = v.abs();
    let (axis, value) = if a.x >= a.y && a.x >= a.z {
        (0, v.x)
    } else if a.y >= a.z {
        (2, v.y)
    } else {
        (4, v.z)
    };
    axis + usize::from(value < 0.0)
}

/// Renders shadow maps.
pub trait RenderShadowMap: Backend {
    /// The map of `emitter` with `resolution` texels per side and face.
    ///
    /// # Errors
    /// [`ShadowMapError::Resolution`] if the resolution is 0 or above 65536,
    /// [`Error::TooLarge`] if the map would exceed 4 GiB or what the device can
    /// hold.
    fn shadow_map(
        &self,
        casters: &Casters<Self::Memory>,
        emitter: &Emitter,
        resolution: u32,
    ) -> Result<ShadowMap<Self::Memory>, ShadowMapError> {
        self.shadow_map_within(casters, casters.bounds(), emitter, resolution)
    }

    /// The map of the casters within a box alone. The same number of texels covers a smaller
    /// part of the scene; points outside of the pictures are lit. See
    /// [`reached`](super::reached).
    ///
    /// # Errors
    /// As for [`RenderShadowMap::shadow_map`].
    fn shadow_map_within(
        &self,
        casters: &Casters<Self::Memory>,
        bounds: Bounds,
        emitter: &Emitter,
        resolution: u32,
    ) -> Result<ShadowMap<Self::Memory>, ShadowMapError> {
        let faces = faces(bounds, emitter);
        let depth = self.depths(casters, &faces, resolution)?;
        Ok(ShadowMap {
            faces,
            resolution,
            depth,
        })
    }

    /// The depths of any pictures of the casters, one picture after the other, each row by row
    /// from the top.
    ///
    /// # Errors
    /// As for [`RenderShadowMap::shadow_map`].
    fn depths(
        &self,
        casters: &Casters<Self::Memory>,
        faces: &[Face],
        resolution: u32,
    ) -> Result<BufferOf<Self, f32>, ShadowMapError>;
}

impl RenderShadowMap for Cpu {
    fn depths(
        &self,
        casters: &Casters<Host>,
        faces: &[Face],
        resolution: u32,
    ) -> Result<Vec<f32>, ShadowMapError> {
        check_size(faces.len(), resolution)?;
        let mut depth = self.zeros::<f32>(faces.len() * (resolution as usize).pow(2))?;
        for (face, texels) in faces
            .iter()
            .zip(depth.chunks_exact_mut((resolution as usize).pow(2)))
        {
            let (triangles, masked) = (casters.triangles(), casters.masks_on_host());
            render_face(self, face, triangles, masked, resolution, texels);
        }
        Ok(depth)
    }
}

pub(crate) fn check_size(faces: usize, resolution: u32) -> Result<(), ShadowMapError> {
    if !(1..=65536).contains(&resolution) {
        return Err(ShadowMapError::Resolution { resolution });
    }
    let requested = map_bytes(faces, resolution);
    if requested > MAX_BYTES {
        return Err(ShadowMapError::Backend(Error::TooLarge {
            what: "a shadow map",
            requested,
            limit: MAX_BYTES,
        }));
    }
    Ok(())
}

/// Writes the nearest depth of each texel. The last triangles are those of `masked`; their
/// holes are left out. Bands of rows are independent of each other, and a minimum does not
/// depend on the order, so the result does not depend on threads.
pub(crate) fn render_face(
    cpu: &Cpu,
    face: &Face,
    triangles: &[[Vec3; 3]],
    masked: &Masked,
    resolution: u32,
    texels: &mut [f32],
) {
    let (solid, with_holes) = triangles.split_at(triangles.len() - masked.len());
    nearest_depths(cpu, face, solid, resolution, EMPTY, texels);
    if !with_holes.is_empty() {
        render_masked(cpu, face, with_holes, masked, resolution, texels);
    }
}

/// Lowers texels to the nearest depth of masked triangles outside of their holes.
fn render_masked(
    cpu: &Cpu,
    face: &Face,
    triangles: &[[Vec3; 3]],
    masked: &Masked,
    resolution: u32,
    texels: &mut [f32],
) {
    const CHUNK: usize = 4096;
    let footprints: Vec<Vec<(usize, Footprint)>> =
        cpu.map(triangles.len().div_ceil(CHUNK), |chunk| {
            (chunk * CHUNK..)
                .zip(&triangles[chunk * CHUNK..])
                .take(CHUNK)
                .filter_map(|(index, triangle)| {
                    Some((index, Footprint::new(face, triangle, resolution)?))
                })
                .collect()
        });
    let mut bands = vec![Vec::new(); resolution.div_ceil(BAND) as usize];
    for footprint in footprints.iter().flatten() {
        let (first, end) = footprint.1.rows();
        for band in &mut bands[(first / BAND) as usize..end.div_ceil(BAND) as usize] {
            band.push(footprint);
        }
    }
    let width = resolution as usize;
    cpu.for_each_chunk(texels, BAND as usize * width, |first, chunk| {
        let first_row = (first / width) as u32;
        let end_row = first_row + (chunk.len() / width) as u32;
        for (index, footprint) in &bands[(first_row / BAND) as usize] {
            footprint.for_each(first_row, end_row, |x, y, depth| {
                let texel = &mut chunk[(y - first_row) as usize * width + x as usize];
                let is_there = || {
                    let [u, v] = footprint.barycentric(x, y);
                    masked.blocks(*index, u, v)
                };
                if depth < *texel && is_there() {
                    *texel = depth;
                }
            });
        }
    });
}

/// Number of faces that the shadow map of `emitter` has in a scene: one or six. A map takes 4
/// bytes × faces × resolution².
pub fn face_count(geometry: &Geometry, emitter: &Emitter) -> usize {
    faces(geometry.bounds(), emitter).len()
}

/// The picture planes from which a light sees all casters in a box.
pub(crate) fn faces(bounds: Bounds, emitter: &Emitter) -> Vec<Face> {
    let point = match emitter {
        Emitter::Directional(sun) => return vec![Face::orthographic(bounds, sun.direction())],
        Emitter::Point(point) => point,
    };
    let cone = match point.emission() {
        Emission::Spot(spot) => tangent(spot.outer_versine()),
        _ => f32::INFINITY,
    };
    match (point.emission(), fitted(bounds, point.position())) {
        (_, Some((face, tan))) if tan < cone => vec![face],
        (Emission::Spot(spot), _) if cone <= WIDEST_TAN => {
            let rotation = spot.rotation();
            vec![Face {
                origin: point.position(),
                right: rotation * Vec3::X,
                up: rotation * Vec3::Y,
                forward: rotation * Vec3::NEG_Z,
                rays: Rays::Central { tan: cone },
            }]
        }
        _ => cube(point.position()),
    }
}

/// One perspective picture of all casters in a box from a light outside of it, and the tangent
/// of its half angle; `None` if it is no narrower than a face of a cube. The cube around a
/// distant light would spend most texels on empty space.
fn fitted(bounds: Bounds, origin: Vec3) -> Option<(Face, f32)> {
    let forward = (0.5 * (bounds.min() + bounds.max()) - origin).try_normalize()?;
    let right = forward.any_orthonormal_vector();
    let up = right.cross(forward);
    let mut tan = 0.0_f32;
    for corner in bounds.corners() {
        let v = corner - origin;
        let across = v.dot(right).abs().max(v.dot(up).abs());
        let z = v.dot(forward);
        if z <= across {
            return None;
        }
        tan = tan.max(across / z);
    }
    // A margin for the rounding of the corners, so that no caster falls off the edge.
    let tan = tan * (1.0 + 1e-4);
    let face = Face {
        origin,
        right,
        up,
        forward,
        rays: Rays::Central { tan },
    };
    Some((face, tan))
}

fn tangent(versine: f32) -> f32 {
    (versine * (2.0 - versine)).sqrt() / (1.0 - versine)
}

fn cube(origin: Vec3) -> Vec<Face> {
    [
        (Vec3::X, Vec3::Y),
        (Vec3::NEG_X, Vec3::Y),
        (Vec3::Y, Vec3::NEG_Z),
        (Vec3::NEG_Y, Vec3::Z),
        (Vec3::Z, Vec3::Y),
        (Vec3::NEG_Z, Vec3::Y),
    ]
    .map(|(forward, up)| Face {
        origin,
        right: forward.cross(up),
        up,
        forward,
        rays: Rays::Central { tan: 1.0 },
    })
    .into()
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::scene::{Cone, Mesh, Scene};

    /// A square of side 2 in the plane z = −2 and a far larger one at z = −6.
    fn casters() -> Casters<Host> {
        let square = |half: f32, z: f32| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| Vec3::new(half * x, half * y, z))
        };
        let mesh = Mesh {
            positions: [square(1.0, -2.0), square(40.0, -6.0)].concat(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            ..Mesh::default()
        };
        let scene = Scene::from(mesh);
        Casters::upload(&Cpu::new(), &Geometry::new(&scene).unwrap()).unwrap()
    }

    fn lights() -> Vec<Emitter> {
        let point =
            |emission| Emitter::point(Vec3::ZERO, Vec3::ONE, f32::INFINITY, emission).unwrap();
        let spot = |outer| {
            let cone = Cone { inner: 0.1, outer };
            Emission::spot(Quat::IDENTITY, cone, None).unwrap()
        };
        vec![
            point(Emission::Isotropic),
            point(spot(0.9)),
            point(spot(1.5)),
            Emitter::directional(Vec3::NEG_Z, Vec3::ONE).unwrap(),
        ]
    }

    #[test]
    fn points_are_lit_up_to_the_first_blocker_and_no_farther() {
        let cpu = Cpu::new();
        for light in lights() {
            for resolution in [1, 7, 64] {
                let map = cpu.shadow_map(&casters(), &light, resolution).unwrap();
                let context = format!("{light:?} {resolution}");
                assert!(map.is_lit(Vec3::new(0.0, 0.0, -1.9)), "{context}");
                // A texel holds the depth at its centre only.
                if resolution == 64 {
                    assert!(!map.is_lit(Vec3::new(0.1, 0.1, -2.1)), "{context}");
                    assert!(!map.is_lit(Vec3::new(2.9, 0.0, -6.1)), "{context}");
                    assert!(map.is_lit(Vec3::new(4.0, 0.0, -5.9)), "{context}");
                }
                assert!(map.is_lit(Vec3::new(0.0, 0.0, 3.0)), "{context}");
            }
        }
    }

    #[test]
    fn the_map_of_a_distant_light_is_spent_on_the_casters() {
        let cpu = Cpu::new();
        let position = Vec3::new(0.0, 300.0, 9e3);
        let light =
            Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
        let map = cpu.shadow_map(&casters(), &light, 256).unwrap();
        assert_eq!(map.faces().len(), 1);
        let covered = map.depth().iter().filter(|&&depth| depth < EMPTY).count();
        assert!(covered > 256 * 256 / 4, "{covered}");
        assert!(!map.is_lit(Vec3::new(0.0, 0.0, -3.0)));
        assert!(map.is_lit(Vec3::new(3.0, 0.0, -3.0)));
        assert!(
            map.is_lit(Vec3::new(500.0, 0.0, -30.0)),
            "beside the casters"
        );
    }

    #[test]
    fn every_direction_belongs_to_the_face_that_sees_it() {
        let faces = cube(Vec3::ZERO);
        for i in 0..400 {
            let golden = i as f32 * 2.399_963;
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / 400.0;
            let ring = (1.0 - y * y).sqrt();
            let v = Vec3::new(ring * golden.cos(), y, ring * golden.sin());
            let face = faces[cube_face(v)];
            let z = v.dot(face.forward);
            assert!(v.dot(face.right).abs() <= z && v.dot(face.up).abs() <= z);
            assert!((face.up.cross(face.right) - face.forward).length() < 1e-6);
        }
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let one = Cpu::single_threaded();
        for light in lights() {
            let a = one.shadow_map(&casters(), &light, 45).unwrap();
            let b = Cpu::new().shadow_map(&casters(), &light, 45).unwrap();
            assert_eq!(a.depth(), b.depth());
        }
    }

    #[test]
    fn senseless_sizes_are_refused_before_they_are_allocated() {
        let cpu = Cpu::new();
        let point = &lights()[0];
        for resolution in [0, 65537, u32::MAX] {
            assert_eq!(
                cpu.shadow_map(&casters(), point, resolution).unwrap_err(),
                ShadowMapError::Resolution { resolution }
            );
        }
        let error = cpu.shadow_map(&casters(), point, 65536).unwrap_err();
        assert!(error.to_string().contains("limit"), "{error}");
    }

    /// A card of side 2 at z = −2 with a pattern of holes, beside a pane of glass and
    /// what casts no shadow.
    #[cfg(feature = "trace")]
    fn card() -> Geometry {
        use glam::Vec2;

        use crate::scene::{AlphaMode, Instance, Material, Texture};

        let square = |shift: f32, z: f32| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| Vec3::new(x + shift, y, z))
        };
        let mesh = |shift, z, material| Mesh {
            positions: square(shift, z).to_vec(),
            texture_coordinates: vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: Some(material),
            ..Mesh::default()
        };
        let mut random = reference::random::Random::new(2);
        let alpha = (0..16).map(|_| random.unit()).collect();
        let texture = Texture::new(4, 4, vec![Vec3::ONE; 16]).unwrap();
        let texture = texture.with_alpha(alpha).unwrap();
        let mut scene = Scene {
            meshes: vec![mesh(0.0, -2.0, 0), mesh(0.5, -1.5, 1), mesh(-0.5, -1.0, 2)],
            materials: vec![
                Material {
                    base_color_texture: Some(texture),
                    alpha: AlphaMode::Mask { cutoff: 0.5 },
                    ..Material::default()
                },
                Material {
                    transmission: 0.5,
                    ..Material::default()
                },
                Material::default(),
            ],
            ..Scene::default()
        };
        scene.instances = (0..3)
            .map(|mesh| Instance {
                mesh,
                no_shadow: mesh == 2,
                ..Instance::default()
            })
            .collect();
        Geometry::new(&scene).unwrap()
    }

    #[cfg(feature = "trace")]
    #[test]
    fn texels_see_through_the_holes_of_a_mask() {
        let cpu = Cpu::new();
        let geometry = card();
        let casters = Casters::upload(&cpu, &geometry).unwrap();
        assert_eq!((casters.triangles().len(), casters.masked()), (2, 2));
        for light in lights() {
            let map = cpu.shadow_map(&casters, &light, 64).unwrap();
            let mut seen = [0; 2];
            for (index, face) in map.faces().iter().enumerate() {
                for texel in 0..64 * 64 {
                    let (x, y) = ((texel % 64) as f32, (texel / 64) as f32);
                    let across = (x + 0.5) / 32.0 - 1.0;
                    let upward = 1.0 - (y + 0.5) / 32.0;
                    let (origin, direction) = match face.rays {
                        Rays::Parallel {
                            half_width,
                            half_height,
                        } => {
                            let start =
                                across * half_width * face.right + upward * half_height * face.up;
                            (face.origin + start, face.forward)
                        }
                        Rays::Central { tan } => {
                            let aside = across * face.right + upward * face.up;
                            (face.origin, face.forward + tan * aside)
                        }
                    };
                    let line = crate::scene::trace::Line::new(origin, direction);
                    let hit = |i: usize| line.meets(&geometry.triangles()[i]);
                    let holds = (0..2).find_map(|i| {
                        let (t, u, v) = hit(i)?;
                        let is_there = geometry.caster(i).transmittance_at(u, v) == Vec3::ZERO;
                        (t > 0.0 && is_there).then_some(t)
                    });
                    let depth = map.depth()[index * 64 * 64 + texel];
                    seen[usize::from(holds.is_some())] += 1;
                    match holds {
                        None => assert_eq!(depth, EMPTY, "{light:?} {x} {y}"),
                        Some(t) => assert!((f64::from(depth) - t).abs() < 1e-4, "{depth} {t}"),
                    }
                }
            }
            assert!(seen[0] > 100 && seen[1] > 100, "{seen:?}");
        }
    }
}

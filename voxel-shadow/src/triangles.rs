//! Voxelisation straight from triangles: every light ray is intersected with
//! every triangle that it may meet.
//!
//! Slower than rectifying a shadow map, and without that map's resolution:
//! what remains is the error of the voxels alone.

use std::mem::size_of;

use epipolar::{Lattice, LightRay};
use glam::Vec3;
use gpu_backend::{Backend, BufferOf, Cpu, Host};

use crate::rectify::check;
use crate::{Error, IndexMap};

/// Intersects light rays with triangles.
pub trait RectifyTriangles: Backend {
    /// Writes for every light ray, through the centres of its voxels, the first
    /// voxel in shadow of any of the `triangles`. Both sides of a triangle block;
    /// triangles without an area, or with corners that are not finite, do
    /// not. A ray through a common edge of two triangles meets at least one of
    /// them.
    ///
    /// Cost: on the CPU the light rays in the epipolar bounds of each triangle, on
    /// a GPU all light rays times all triangles.
    ///
    /// # Errors
    /// [`Error::Resolution`] unless `map` is as large as the lattice; errors of the
    /// backend.
    fn rectify_triangles(
        &self,
        lattice: &Lattice,
        triangles: &BufferOf<Self, [Vec3; 3]>,
        map: &mut IndexMap<Self::Memory>,
    ) -> Result<(), Error>;
}

/// Where triangles have holes through which light passes.
pub trait Holes: Sync {
    /// Whether a triangle has a hole at the barycentric coordinates (`u`, `v`) of
    /// its second and third corner.
    fn is_hole(&self, triangle: usize, u: f32, v: f32) -> bool;
}

/// There are none.
impl Holes for () {
    fn is_hole(&self, _: usize, _: f32, _: f32) -> bool {
        false
    }
}

/// Intersects light rays with triangles that are not there everywhere.
///
/// On the CPU `H` is any [`Holes`]; on a GPU it is what fits its `HolesSlot`.
pub trait RectifyMasked<H: ?Sized>: Backend {
    /// [`RectifyTriangles::rectify_triangles`], but a light ray passes a triangle
    /// where that has a hole. Triangles have the numbers of their places in
    /// `triangles`.
    ///
    /// # Errors
    /// As there.
    fn rectify_masked(
        &self,
        lattice: &Lattice,
        triangles: &BufferOf<Self, [Vec3; 3]>,
        holes: &H,
        map: &mut IndexMap<Self::Memory>,
    ) -> Result<(), Error>;
}

/// Units of work into which the planes are divided. Each looks at the bounds of
/// all triangles, which costs no memory, whatever the triangles.
const BANDS: usize = 32;

/// Triangles whose bounds are one unit of work.
const CHUNK: usize = 1024;

impl RectifyTriangles for Cpu {
    fn rectify_triangles(
        &self,
        lattice: &Lattice,
        triangles: &Vec<[Vec3; 3]>,
        map: &mut IndexMap<Host>,
    ) -> Result<(), Error> {
        self.rectify_masked(lattice, triangles, &(), map)
    }
}

impl<H: Holes + ?Sized> RectifyMasked<H> for Cpu {
    fn rectify_masked(
        &self,
        lattice: &Lattice,
        triangles: &Vec<[Vec3; 3]>,
        holes: &H,
        map: &mut IndexMap<Host>,
    ) -> Result<(), Error> {
        check(lattice, map)?;
        let resolution = lattice.resolution();
        let bits = resolution.bits() as usize;
        let footprints = self.map(triangles.len().div_ceil(CHUNK), |chunk| {
            (chunk * CHUNK..)
                .zip(&triangles[chunk * CHUNK..])
                .take(CHUNK)
                .filter_map(|(number, corners)| {
                    Some((number, corners, lattice.footprint(corners)?))
                })
                .collect::<Vec<_>>()
        });
        let parallel = lattice.space().is_directional();
        let turn = resolution.theta();
        let band = (turn as usize).div_ceil(BANDS) * bits;
        self.for_each_chunk(map.indices_mut(), band, |first, indices| {
            indices.fill(resolution.alpha());
            for (number, corners, footprint) in footprints.iter().flatten() {
                for (plane, indices) in (first / bits..).zip(indices.chunks_exact_mut(bits)) {
                    let plane_index = plane as u32;
                    let planes = &footprint.planes;
                    if !(planes.contains(&plane_index) || planes.contains(&(plane_index + turn))) {
                        continue;
                    }
                    for bit in footprint.bits.clone().map(|bit| bit as usize) {
                        let ray = lattice.light_ray(plane, bit);
                        if let Some((distance, [u, v])) = hit(&ray, corners, parallel)
                            && !holes.is_hole(*number, u, v)
                        {
                            let index = lattice.blocked_from(bit, distance);
                            indices[bit] = indices[bit].min(index);
                        }
                    }
                }
            }
        });
        Ok(())
    }
}

/// The distance at which a ray meets a triangle, and the barycentric coordinates of
/// its second and third corner there.
///
/// The three volumes of the ray with the edges have equal signs inside. The
/// volume of an edge is the same number with the other sign for the triangle on
/// its other side, so that no ray slips through between the two.
fn hit(ray: &LightRay, corners: &[Vec3; 3], parallel: bool) -> Option<(f32, [f32; 2])> {
    let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
    let [a, b, c] = corners.map(|corner| corner - origin);
    let volume = |p: Vec3, q: Vec3| direction.dot(p.cross(q));
    let (u, v, w) = (volume(b, c), volume(c, a), volume(a, b));
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    let sum = u + v + w;
    if !inside || sum == 0.0 {
        return None;
    }
    let along = |p: Vec3| p.dot(direction);
    let distance = (u * along(a) + v * along(b) + w * along(c)) / sum;
    let counts = distance.is_finite() && (parallel || distance >= 0.0);
    counts.then_some((distance, [v / sum, w / sum]))
}

// Shaders read the corners as consecutive numbers.
const _: () = assert!(size_of::<[Vec3; 3]>() == 36);

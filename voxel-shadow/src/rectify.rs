//! Voxelisation by rectifying a shadow map.
//!
//! Based on: Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013,
//! section 2.6: for every (θ, φ) the shadow map is sampled and its depth becomes an
//! α. Departure: the α are kept as a map of their own before any bit is set,
//! so that what is rounded (here) and what is exact (from here on) are apart.

use epipolar::{Lattice, LightRay};
use gpu_backend::{Backend, Cpu, Host};

use crate::error::same_resolution;
use crate::{Error, IndexMap};

/// Anything that knows the first blocker of a light: a shadow map of any kind,
/// or a ray tracer. Closures are one.
pub trait FirstBlocker: Sync {
    /// The distance in metres along `ray` to the first blocker; +∞ or
    /// [`f32::MAX`] if there is none. The rays of a directional light begin
    /// level with the eye, so that blockers nearer to the light are at
    /// negative distances. NaN counts as no blocker.
    fn distance(&self, ray: &LightRay) -> f32;

    /// The same for many rays, one distance for each.
    #[inline]
    fn distances(&self, rays: &[LightRay], distances: &mut [f32]) {
        for (ray, distance) in rays.iter().zip(distances) {
            *distance = self.distance(ray);
        }
    }
}

impl<F: Fn(&LightRay) -> f32 + Sync> FirstBlocker for F {
    fn distance(&self, ray: &LightRay) -> f32 {
        self(ray)
    }
}

/// Samples a blocker of type `S` along all light rays of a lattice.
pub trait Rectify<S: ?Sized>: Backend {
    /// Writes for every light ray, through the centres of its voxels, the first
    /// voxel in shadow: that which holds the first blocker of `source`.
    ///
    /// # Errors
    /// [`Error::Resolution`] unless `map` is as large as the lattice; errors of the
    /// backend.
    fn rectify(
        &self,
        lattice: &Lattice,
        source: &S,
        map: &mut IndexMap<Self::Memory>,
    ) -> Result<(), Error>;
}

impl<S: FirstBlocker + ?Sized> Rectify<S> for Cpu {
    fn rectify(
        &self,
        lattice: &Lattice,
        source: &S,
        map: &mut IndexMap<Host>,
    ) -> Result<(), Error> {
        check(lattice, map)?;
        let bits = lattice.resolution().bits() as usize;
        self.for_each_chunk(map.indices_mut(), bits, |first, plane| {
            rectify_plane(lattice, first / bits, plane, |rays, distances| {
                source.distances(rays, distances);
            });
        });
        Ok(())
    }
}

/// Light rays that are asked about together: bits come 32 at a time, and these fit into the
/// first-level cache beside what a source needs.
const TOGETHER: usize = 64;

/// The indices of the light rays of a plane, whose first blockers `distances` finds.
///
/// There is a loop for each step: rounds of short loops overlap in the processor, and the
/// angles at the end are computed with vector instructions. Most of the time is the source's:
/// cache misses in a shadow map take four fifths.
pub(crate) fn rectify_plane(
    lattice: &Lattice,
    theta: usize,
    plane: &mut [u32],
    distances: impl Fn(&[LightRay], &mut [f32]),
) {
    let none = LightRay {
        origin: [0.0; 3],
        direction: [0.0; 3],
    };
    let mut rays = [none; TOGETHER];
    let mut found = [f32::INFINITY; TOGETHER];
    for (block, indices) in plane.chunks_mut(TOGETHER).enumerate() {
        let first = block * TOGETHER;
        let rays = &mut rays[..indices.len()];
        let found = &mut found[..indices.len()];
        for (bit, ray) in rays.iter_mut().enumerate() {
            *ray = lattice.light_ray(theta, first + bit);
        }
        distances(rays, found);
        lattice.blocked_from_each(first, found, indices);
    }
}

pub(crate) fn check<M: gpu_backend::Memory>(
    lattice: &Lattice,
    map: &IndexMap<M>,
) -> Result<(), Error> {
    same_resolution(
        "a rectified shadow map",
        lattice.resolution(),
        map.resolution(),
    )
}

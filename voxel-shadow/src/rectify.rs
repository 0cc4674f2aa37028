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
            for (bit, index) in plane.iter_mut().enumerate() {
                let ray = lattice.light_ray(first / bits, bit);
                *index = lattice.blocked_from(bit, source.distance(&ray));
            }
        });
        Ok(())
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

//! The rectified shadow map: where along α each light ray is blocked.

use epipolar::Resolution;
use gpu_backend::{Backend, Buffer, Host, Memory};

use crate::Error;
use crate::error::{same_length, too_large};

/// For every light ray (θ, φ) the first voxel along α that is in shadow.
///
/// Entries lie plane by plane, `θ × bits + bit`. An entry of
/// [`Resolution::alpha`] or more means that nothing blocks the ray within the
/// range. Voxel (α, θ, φ) is in shadow exactly if the entry is ≤ α; the bit grid
/// is another form of the same, in which all of an eye ray is one texel.
#[derive(Debug)]
pub struct IndexMap<M: Memory> {
    resolution: Resolution,
    indices: M::Buffer<u32>,
}

impl<M: Memory> IndexMap<M> {
    /// A map for a step to write.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if it does not fit on the backend, with a resolution that does.
    pub fn new<B: Backend<Memory = M>>(backend: &B, resolution: Resolution) -> Result<Self, Error> {
        let named = too_large("a rectified shadow map", resolution, Resolution::light_rays);
        Ok(Self {
            indices: backend.zeros(resolution.light_rays()).map_err(named)?,
            resolution,
        })
    }

    /// A map from its entries.
    ///
    /// # Errors
    /// [`gpu_backend::Error::LengthMismatch`] unless there are
    /// [`Resolution::light_rays`] of them.
    pub fn from_indices(resolution: Resolution, indices: M::Buffer<u32>) -> Result<Self, Error> {
        same_length(
            "a rectified shadow map",
            resolution.light_rays(),
            indices.len(),
        )?;
        Ok(Self {
            resolution,
            indices,
        })
    }

    /// How many voxels it is for.
    pub fn resolution(&self) -> Resolution {
        self.resolution
    }

    /// The entries.
    pub fn indices(&self) -> &M::Buffer<u32> {
        &self.indices
    }

    pub(crate) fn indices_mut(&mut self) -> &mut M::Buffer<u32> {
        &mut self.indices
    }
}

impl IndexMap<Host> {
    /// The same map on another backend.
    ///
    /// # Errors
    /// [`gpu_backend::Error::TooLarge`] if it does not fit there.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<IndexMap<B::Memory>, Error> {
        Ok(IndexMap {
            resolution: self.resolution,
            indices: backend.upload(&self.indices)?,
        })
    }
}

//! Maps of transmittance in the memory of a backend.

use gpu_backend::{Backend, Memory};
use transmittance::{Filter, Packed};

use super::{TransmittanceMap, TransmittanceMapError};
use crate::shadow_map::raster::Face;

/// A [`TransmittanceMap`] of curves of 8 nodes in the memory of a backend, where
/// shaders look them up.
#[derive(Debug)]
pub struct StoredMap<M: Memory> {
    faces: Vec<Face>,
    resolution: u32,
    curves: transmittance::TransmittanceMap<M>,
    filter: Filter,
}

impl TransmittanceMap<Packed<8>> {
    /// The same map on another backend.
    ///
    /// # Errors
    /// [`TransmittanceMapError::Curves`] if it does not fit there.
    pub fn upload<B: Backend>(
        &self,
        backend: &B,
    ) -> Result<StoredMap<B::Memory>, TransmittanceMapError> {
        Ok(StoredMap {
            faces: self.faces().to_vec(),
            resolution: self.resolution(),
            curves: transmittance::TransmittanceMap::from_faces(backend, self.curves())?,
            filter: self.filter(),
        })
    }
}

impl<M: Memory> StoredMap<M> {
    /// One face, or six in the order +X −X +Y −Y +Z −Z; none without casters.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Texels per side of each face.
    pub fn resolution(&self) -> u32 {
        self.resolution
    }

    /// How it is asked between texel centres.
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// The curves as `transmittance` stores them, face by face, each row by row
    /// from the top; none without casters.
    pub fn words(&self) -> &M::Buffer<u32> {
        self.curves.words()
    }

    /// Words of each face.
    #[cfg(feature = "wgpu")]
    pub(crate) fn face_words(&self) -> u32 {
        // All faces are in one buffer, whose indices are u32.
        self.resolution.pow(2) * <Packed<8> as transmittance::Stored>::WORDS as u32
    }
}

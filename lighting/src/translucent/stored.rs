//! Maps of transmittance in the memory of a backend.

use gpu_backend::{Backend, Error, Memory};
use transmittance::{Filter, Packed, Stored};

use super::TransmittanceMap;
use crate::scene::raster::Face;

/// A [`TransmittanceMap`] of curves of 8 nodes in the memory of a backend, where
/// shaders look them up.
#[derive(Debug)]
pub struct StoredMap<M: Memory> {
    faces: Vec<Face>,
    resolution: u32,
    words: M::Buffer<u32>,
    filter: Filter,
}

impl TransmittanceMap<Packed<8>> {
    /// The same map on another backend.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if it does not fit there.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<StoredMap<B::Memory>, Error> {
        const WORDS: usize = <Packed<8> as Stored>::WORDS;
        let texels = || self.curves().iter().flat_map(|face| face.texels());
        let mut words = vec![0; texels().count() * WORDS];
        for (curve, words) in texels().zip(words.chunks_exact_mut(WORDS)) {
            curve.write(words);
        }
        if words.is_empty() {
            // Backends may not have buffers of nothing.
            words.push(0);
        }
        Ok(StoredMap {
            faces: self.faces().to_vec(),
            resolution: self.resolution(),
            words: backend.upload(&words)?,
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
    /// from the top; a single 0 without casters.
    pub fn words(&self) -> &M::Buffer<u32> {
        &self.words
    }

    /// Words of each face.
    #[cfg(feature = "wgpu")]
    pub(crate) fn face_words(&self) -> u32 {
        // All faces are in one buffer, whose indices are u32.
        self.resolution.pow(2) * <Packed<8> as Stored>::WORDS as u32
    }
}

//! Maps of transmittance in the memory of a GPU.

use gpu_backend::Backend;
use gpu_backend::Error;
use gpu_backend::gpu::{Encode, Gpu, GpuBuffer, GpuMemory};
use transmittance::{Packed, Stored};

use super::TransmittanceMap;
use super::map::CurveMemory;

/// Words of a curve.
const WORDS: usize = <Packed<8> as Stored>::WORDS;

/// The curves as `transmittance` stores them, face by face, each row by row from
/// the top; a single 0 without casters.
impl CurveMemory<Packed<8>> for GpuMemory {
    type Curves = GpuBuffer<u32>;
}

impl TransmittanceMap {
    /// The same map where shaders look it up.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if it does not fit there.
    pub fn upload<E: Encode>(&self, gpu: &Gpu<E>) -> Result<TransmittanceMap<GpuMemory>, Error> {
        let texels = || self.curves.iter().flat_map(|face| face.texels());
        let mut words = vec![0; texels().count() * WORDS];
        for (curve, words) in texels().zip(words.chunks_exact_mut(WORDS)) {
            curve.write(words);
        }
        if words.is_empty() {
            // Backends may not have buffers of nothing.
            words.push(0);
        }
        Ok(TransmittanceMap {
            faces: self.faces.clone(),
            resolution: self.resolution,
            curves: gpu.upload(&words)?,
            filter: self.filter,
        })
    }
}

impl TransmittanceMap<GpuMemory> {
    /// Words of each face.
    pub(crate) fn face_words(&self) -> u32 {
        // All faces are in one buffer, whose indices are u32.
        self.resolution.pow(2) * WORDS as u32
    }
}

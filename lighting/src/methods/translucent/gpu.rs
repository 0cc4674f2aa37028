//! Maps of transmittance in the memory of a GPU, and in shaders.

use std::fmt::Debug;

use gpu_backend::Host;
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuMemory, InShader};
use gpu_backend::shader::Part;
use transmittance::Stored;
use transmittance::gpu::{WgslStored, lookup_parts};

use super::map::CurveMemory;
use super::{TransmittanceMap, TransmittanceMapError};
use crate::gpu::scene::PicturesRecord;
use crate::gpu::{FACE, PLACE, PointSlot};

/// All faces in one map, one after the other, one colour after the other.
impl<T: Stored + Debug> CurveMemory<T> for GpuMemory {
    type Curves = transmittance::TransmittanceMap<GpuMemory, T>;
}

impl<T: Stored + Debug> TransmittanceMap<Host, T> {
    /// The same map where shaders look it up.
    ///
    /// # Errors
    /// [`TransmittanceMapError::Curves`] if it does not fit there.
    pub fn upload<E: Encode>(
        &self,
        gpu: &Gpu<E>,
    ) -> Result<TransmittanceMap<GpuMemory, T>, TransmittanceMapError> {
        Ok(TransmittanceMap {
            faces: self.faces.clone(),
            sides: self.sides.clone(),
            resolution: self.resolution,
            channels: self.channels,
            curves: transmittance::TransmittanceMap::in_one_row(gpu, &self.curves)?,
            filter: self.filter,
        })
    }
}

/// `light_CurveMap` of `transmittance_map.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct CurveMapRecord {
    pictures: PicturesRecord,
    /// Texels per side of a face, and its first word.
    places: [[u32; 4]; 6],
}

impl<T: Stored + Debug> TransmittanceMap<GpuMemory, T> {
    fn record(&self) -> CurveMapRecord {
        let mut record = CurveMapRecord {
            pictures: PicturesRecord::new(self.faces(), 1),
            places: [[0; 4]; 6],
        };
        let mut word = 0;
        for (place, &side) in record.places.iter_mut().zip(&self.sides) {
            *place = [side, word, 0, 0];
            // All faces are in one buffer, whose indices are u32.
            word += side.pow(2) * T::WORDS as u32;
        }
        record
    }

    /// Words of all faces in one colour.
    fn words_of_colour(&self) -> u32 {
        let texels = self.sides.iter().map(|side| side.pow(2));
        texels.sum::<u32>() * T::WORDS as u32
    }
}

/// WGSL of lookups in a map of transmittance.
const TRANSMITTANCE_MAP: &str = include_str!("transmittance_map.wgsl");

impl<T: WgslStored + Debug> InShader<PointSlot> for TransmittanceMap<GpuMemory, T> {
    fn part() -> Part {
        Part::new("light_curves")
            .sources(&[FACE, PLACE])
            .sources(&lookup_parts::<T, 1>())
            .source(TRANSMITTANCE_MAP)
            .uniform("light_curves", "light_CurveMap")
            .read("light_curve_words", "array<u32>")
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("SIDE", f64::from(self.filter().side())),
            ("COLOUR_WORDS", f64::from(self.words_of_colour())),
            ("COLOURS", f64::from(u8::from(self.channels() == 3))),
        ]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(self.record()),
            Argument::read(self.curves().words()),
        ]
    }
}

//! Maps of transmittance on GPUs.

use std::sync::Arc;

use gpu_backend::gpu::{Encode, Gpu, GpuMemory};

use super::method::{Curves, curve_resolution, map};
use super::{Casters, TransmittanceMap};
use crate::methods::march::March;
use crate::methods::{Frame, MethodError, OfLight, SourceOn};

/// The map of a light, where shaders look it up.
fn uploaded<E: Encode>(
    frame: &Frame<'_, Gpu<E>>,
    light: usize,
) -> Result<Arc<TransmittanceMap<GpuMemory>>, MethodError> {
    let inputs = &frame.inputs;
    let channels = Casters::new(inputs.translucent, Some(inputs.geometry)).channels();
    let resolution = curve_resolution(inputs.map, inputs.emitters, channels);
    let key = OfLight { light, resolution };
    frame
        .store
        .get("map of transmittance", key, TransmittanceMap::bytes, || {
            map(&frame.inputs, light)?
                .upload(frame.backend)
                .map_err(MethodError::resource("a map of transmittance"))
        })
}

impl<E: Encode> SourceOn<Gpu<E>> for Curves {
    type Source = March<Arc<TransmittanceMap<GpuMemory>>>;

    fn prepare(&self, frame: &Frame<'_, Gpu<E>>, light: usize, _: u32) -> Result<(), MethodError> {
        uploaded(frame, light).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, Gpu<E>>,
        light: usize,
        steps: u32,
    ) -> Result<March<Arc<TransmittanceMap<GpuMemory>>>, MethodError> {
        Ok(March::new(uploaded(frame, light)?, steps, self.spacing))
    }
}

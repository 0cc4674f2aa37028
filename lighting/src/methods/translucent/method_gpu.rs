//! Maps of transmittance on GPUs.

use std::sync::Arc;

use gpu_backend::gpu::{Encode, Gpu, GpuMemory};

use transmittance::Stream;

use super::method::{Curves, curve_resolution, map};
use super::{Casters, TransmittanceMap};
use crate::methods::march::March;
use crate::methods::{Frame, MethodError, OfLight, SourceOn};

/// The map of a light, where shaders look it up: made there, or on the CPU if shaders do not
/// know all casters.
fn uploaded<E: Encode>(
    frame: &Frame<'_, Gpu<E>>,
    light: usize,
) -> Result<Arc<TransmittanceMap<GpuMemory>>, MethodError> {
    let inputs = &frame.inputs;
    let casters = Casters::new(inputs.translucent, Some(inputs.geometry));
    let resolution = curve_resolution(inputs.map, inputs.emitters, casters.channels());
    let key = OfLight { light, resolution };
    frame
        .store
        .get("map of transmittance", key, TransmittanceMap::bytes, || {
            let failed = MethodError::resource("a map of transmittance");
            let (emitter, clear) = (&inputs.emitters[light], Stream::<8>::new());
            let gpu = frame.backend;
            match TransmittanceMap::build_in_shaders(gpu, &casters, emitter, resolution, &clear) {
                Ok(Some(map)) => Ok(map),
                Ok(None) => map(inputs, light)?.upload(gpu).map_err(failed),
                Err(error) => Err(failed(error)),
            }
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

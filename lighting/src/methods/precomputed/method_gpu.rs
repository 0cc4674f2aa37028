//! Precomputed shadows on GPUs.

use std::sync::Arc;

use gpu_backend::gpu::{Encode, Gpu, GpuMemory};

use super::dynamic::BesideDynamic;
use super::method::{Baked, WHAT, baked, turns};
use super::{BakedShadow, BakedShadows};
use crate::methods::many_lights::{SourcesTogether, Together};
use crate::methods::{Frame, FrameInputs, MethodError, OfLight, OfStatic, SourceOn};

impl<E: Encode> SourceOn<Gpu<E>> for Baked {
    type Source = BesideDynamic<GpuMemory>;

    fn prepare(
        &self,
        frame: &Frame<'_, Gpu<E>>,
        light: usize,
        side: u32,
    ) -> Result<(), MethodError> {
        self.source(frame, light, side).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, Gpu<E>>,
        light: usize,
        side: u32,
    ) -> Result<Self::Source, MethodError> {
        let resolution = side;
        let key = OfStatic(OfLight { light, resolution });
        let bytes = |shadow: &BakedShadow<GpuMemory>| shadow.bytes();
        let baked = frame.store.get(WHAT, key, bytes, || {
            baked(&frame.inputs, light, side)?
                .upload(frame.backend)
                .map_err(MethodError::resource(WHAT))
        })?;
        BesideDynamic::new(frame, light, baked)
    }
}

/// Groups of consecutive lights, each of which fits into one buffer.
type Groups = Vec<Together<Arc<BakedShadows<GpuMemory>>>>;

impl<E: Encode> SourcesTogether<Gpu<E>> for Baked {
    type Together = Arc<BakedShadows<GpuMemory>>;

    fn prepare_light(
        &self,
        frame: &Frame<'_, Gpu<E>>,
        light: usize,
        side: u32,
    ) -> Result<(), MethodError> {
        baked(&frame.inputs, light, side).map(|_| ())
    }

    fn together(
        &self,
        frame: &Frame<'_, Gpu<E>>,
        side: u32,
    ) -> Result<Vec<Together<Self::Together>>, MethodError> {
        let bytes = |groups: &Groups| groups.iter().map(|group| group.source.bytes()).sum();
        let groups = frame.store.get(WHAT, OfStatic(side), bytes, || {
            let lights = 0..frame.inputs.emitters.len();
            let all = lights
                .map(|light| Ok((*baked(&frame.inputs, light, side)?).clone()))
                .collect::<Result<Vec<BakedShadow>, MethodError>>()?;
            let parts = BakedShadows::upload_in_bindings(&all, frame.backend)
                .map_err(MethodError::resource(WHAT))?;
            let together = |part: BakedShadows<GpuMemory>| Together {
                lights: part.lights().len(),
                source: Arc::new(part),
            };
            Ok(parts.into_iter().map(together).collect())
        })?;
        Ok(groups.to_vec())
    }

    fn is_apart(&self, inputs: &FrameInputs<'_>, light: usize) -> bool {
        inputs.dynamic_reached(light).is_some()
    }

    fn turns(source: &Self::Together) -> f64 {
        turns(source.lights())
    }
}

//! Precomputed shadows on GPUs.

use std::sync::Arc;

use gpu_backend::gpu::{Encode, Gpu, GpuMemory};

use super::BakedShadow;
use super::method::{Baked, WHAT, baked};
use crate::methods::{Frame, MethodError, OfLight, SourceOn};

impl<E: Encode> SourceOn<Gpu<E>> for Baked {
    type Source = Arc<BakedShadow<GpuMemory>>;

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
    ) -> Result<Arc<BakedShadow<GpuMemory>>, MethodError> {
        let resolution = side;
        let key = OfLight { light, resolution };
        let bytes = |shadow: &BakedShadow<GpuMemory>| shadow.bytes();
        frame.store.get(WHAT, key, bytes, || {
            baked(&frame.inputs, light, side)?
                .upload(frame.backend)
                .map_err(MethodError::resource(WHAT))
        })
    }
}

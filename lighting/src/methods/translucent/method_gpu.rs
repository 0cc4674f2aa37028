//! Maps of transmittance on GPUs.

use std::fmt;
use std::sync::Arc;

use gpu_backend::Host;
use gpu_backend::gpu::{Encode, Gpu, GpuMemory};
use transmittance::gpu::{WgslRule, WgslStored};
use transmittance::{Evaluate, Stream};

use super::method::{Curves, map};
use super::{Casters, TransmittanceMap};
use crate::methods::march::March;
use crate::methods::{Frame, MethodError, OfLight, SourceOn};

/// The message about casters that shaders do not take.
const NOT_CANDIDATES: &str = "maps of transmittance are made on the CPU: shaders take \
    neither see-through triangles, pieces of strands longer than 128 texels and density grids of \
    more than 2048 cells along an axis, nor more casters or densities than a buffer holds";

/// The message about software drivers.
const IN_SOFTWARE: &str = "maps of transmittance are made on the CPU: a software driver would \
    take longer";

/// The map of a light in the memory of a GPU, each curve by the rule of `clear`: made in shaders,
/// or by `on_host` on the CPU if shaders do not take all casters or if the driver is software.
pub(in crate::methods) fn made<A, T, E>(
    frame: &Frame<'_, Gpu<E>>,
    (casters, light, resolution): (&Casters<'_>, usize, u32),
    clear: &A,
    on_host: impl FnOnce() -> Result<Arc<TransmittanceMap<Host, T>>, MethodError>,
) -> Result<TransmittanceMap<GpuMemory, T>, MethodError>
where
    A: WgslRule,
    A::Curve: Into<T>,
    T: Evaluate + WgslStored + fmt::Debug,
    E: Encode,
{
    let (inputs, gpu) = (&frame.inputs, frame.backend);
    let failed = MethodError::resource("a map of transmittance");
    // Where the processor plays the GPU, it is faster to let it rasterise the casters: in shaders
    // every texel goes through all that is listed in its squares.
    let why = if gpu.is_software() {
        IN_SOFTWARE
    } else {
        let goes_on = || inputs.go_on(light).is_ok();
        let emitter = &inputs.emitters[light];
        let made =
            TransmittanceMap::build_while(gpu, casters, emitter, resolution, clear, &goes_on);
        match made {
            Ok(Some(map)) => return Ok(map),
            Ok(None) => NOT_CANDIDATES,
            Err(error) => return Err(failed(error)),
        }
    };
    inputs.go_on(light)?;
    inputs.watch.told(why);
    on_host()?.upload(gpu).map_err(failed)
}

/// The map of a light, where shaders look it up.
fn uploaded<E: Encode>(
    frame: &Frame<'_, Gpu<E>>,
    light: usize,
) -> Result<Arc<TransmittanceMap<GpuMemory>>, MethodError> {
    let inputs = &frame.inputs;
    let casters = Casters::new(inputs.translucent, Some(inputs.geometry));
    let resolution = casters.resolution(inputs.map, inputs.emitters, &inputs.emitters[light]);
    let key = OfLight { light, resolution };
    frame
        .store
        .get("map of transmittance", key, TransmittanceMap::bytes, || {
            let (whose, clear) = ((&casters, light, resolution), Stream::<8>::new());
            made(frame, whose, &clear, || map(inputs, light))
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

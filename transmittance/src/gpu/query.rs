//! Receivers answered on a GPU.

use gpu_backend::Buffer;
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, Kernel, Workgroups,
};

use super::{GROUP, WgslStored, lookup_parts};
use crate::transmittance_map::room_for_answers;
use crate::{Error, Filter, QueryMap, Receiver, TransmittanceMap};

/// Uniforms of `query.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Parameters {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) count: u32,
    pub(super) side: u32,
}

/// All parts of the shader.
pub(super) fn parts<P: WgslStored<C>, const C: usize>() -> Vec<&'static str> {
    let entry = [INDEX_WGSL, include_str!("query.wgsl")];
    [&lookup_parts::<P, C>()[..], &entry].concat()
}

impl<P: WgslStored<C>, E: Encode, const C: usize> QueryMap<P, C> for Gpu<E> {
    fn query_map(
        &self,
        map: &TransmittanceMap<GpuMemory, P, C>,
        receivers: &GpuBuffer<Receiver>,
        filter: Filter,
        transmittances: &mut GpuBuffer<f32>,
    ) -> Result<(), Error> {
        room_for_answers::<C>(receivers.len(), transmittances.len())?;
        let [width, height] = map.extent();
        let has_texels = width > 0 && height > 0;
        let parameters = Parameters {
            // The words of a map are in memory: each fits.
            width: if has_texels { width as u32 } else { 0 },
            height: if has_texels { height as u32 } else { 0 },
            // More are refused by the dispatch.
            count: receivers.len() as u32,
            side: filter.side().into(),
        };
        self.dispatch(
            &Kernel {
                label: "query a shadow map",
                parts: &parts::<P, C>(),
                entry: "query",
                constants: &[],
            },
            &[&[
                Argument::uniform(parameters),
                Argument::read(map.words()),
                Argument::read(receivers),
                Argument::write(transmittances),
            ]],
            Workgroups::covering(receivers.len(), GROUP),
        )?;
        Ok(())
    }
}

//! Baked shadows in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, InShader};
use gpu_backend::shader::Part;
use gpu_backend::{Backend, Cpu};
use shadow_dag::gpu::{DagRecord, SpaceRecord};
use shadow_dag::{Error, Form};

use super::VisibilitySlot;
use crate::dag::{BakedShadow, HoldShadow};

/// `light_BakedGrid` of `baked.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GridRecord {
    pub(super) dag: DagRecord,
    pub(super) space: SpaceRecord,
    pub(super) base: u32,
    pub(super) padding: [u32; 3],
}

/// `light_Baked` of `baked.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct BakedRecord {
    pub(super) grids: [GridRecord; 6],
    pub(super) count: u32,
    pub(super) padding: [u32; 3],
}

/// The baked shadows of one light in the memory of a GPU, packed.
///
/// A ray takes a step for each homogeneous volume on its way. Ends of lit parts
/// differ from those of the CPU as [`shadow_dag::gpu`] says; where grids meet,
/// by the rounding of an f32.
#[derive(Debug)]
pub struct GpuShadow {
    record: BakedRecord,
    /// Those of all grids, one after the other.
    words: GpuBuffer<u32>,
}

impl GpuShadow {
    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        4 * gpu_backend::Buffer::len(&self.words) as u64
    }
}

impl<E: Encode> HoldShadow for Gpu<E> {
    type Shadow = GpuShadow;

    fn hold<B: AsRef<[u8]>>(&self, shadow: &BakedShadow<B>) -> Result<GpuShadow, Error> {
        let mut record = BakedRecord::zeroed();
        let mut words = Vec::new();
        let packed = shadow.to_form(Form::Packed)?;
        for (to, grid) in record.grids.iter_mut().zip(packed.grids()) {
            let resident = grid.upload(&Cpu::single_threaded())?;
            *to = GridRecord {
                dag: DagRecord::new(&resident),
                space: SpaceRecord::of(&resident),
                base: words.len() as u32,
                padding: [0; 3],
            };
            words.extend_from_slice(resident.words());
        }
        record.count = packed.grids().len() as u32;
        Ok(GpuShadow {
            record,
            words: self.upload(&words)?,
        })
    }
}

impl InShader<VisibilitySlot> for GpuShadow {
    fn part() -> Part {
        Part::new("light_baked")
            .sources(&[shadow_dag::gpu::POINT, shadow_dag::gpu::PACKED])
            .sources(&[shadow_dag::gpu::SPACE, shadow_dag::gpu::RAY])
            .source(include_str!("baked.wgsl"))
            .uniform("light_baked", "light_Baked")
            .read("light_baked_words", "array<u32>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![Argument::uniform(self.record), Argument::read(&self.words)]
    }
}

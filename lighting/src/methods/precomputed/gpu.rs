//! Precomputed voxelized shadows in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, GpuMemory, InShader};
use gpu_backend::shader::Part;
use shadow_dag::gpu::{DagRecord, SpaceRecord};

use super::BakedShadow;
use crate::gpu::VisibilitySlot;

/// `light_BakedGrid` of `baked.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GridRecord {
    pub(crate) dag: DagRecord,
    pub(crate) space: SpaceRecord,
}

/// `light_Baked` of `baked.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct BakedRecord {
    pub(crate) grids: [GridRecord; 6],
    pub(crate) count: u32,
    pub(crate) padding: [u32; 3],
}

impl BakedRecord {
    fn new(shadow: &BakedShadow<GpuMemory>) -> Self {
        let mut record = Self::zeroed();
        for (to, grid) in record.grids.iter_mut().zip(shadow.grids()) {
            *to = GridRecord {
                dag: DagRecord::new(grid),
                space: SpaceRecord::of(grid),
            };
        }
        record.count = shadow.grids().len() as u32;
        record
    }
}

impl InShader<VisibilitySlot> for BakedShadow<GpuMemory> {
    fn part() -> Part {
        Part::new("light_baked")
            .sources(&[shadow_dag::gpu::POINT, shadow_dag::gpu::PACKED])
            .sources(&[shadow_dag::gpu::SPACE, shadow_dag::gpu::RAY])
            .source(include_str!("baked.wgsl"))
            .uniform("light_baked", "light_Baked")
            .read("light_baked_words", "array<u32>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(BakedRecord::new(self)),
            // All grids are in one buffer.
            Argument::read(self.grids()[0].words()),
        ]
    }
}

//! Precomputed voxelized shadows in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, GpuMemory};
use shadow_dag::gpu::{DagRecord, SpaceRecord};

use super::WgslVisibility;
use crate::precomputed::BakedShadow;

/// `BakedGrid` of `baked_bindings.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GridRecord {
    pub(super) dag: DagRecord,
    pub(super) space: SpaceRecord,
}

/// `Baked` of `baked_bindings.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct BakedRecord {
    pub(super) grids: [GridRecord; 6],
    pub(super) count: u32,
    pub(super) padding: [u32; 3],
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

impl WgslVisibility for BakedShadow<GpuMemory> {
    fn parts() -> &'static [&'static str] {
        &[
            shadow_dag::gpu::POINT,
            shadow_dag::gpu::PACKED,
            shadow_dag::gpu::SPACE,
            shadow_dag::gpu::RAY,
            include_str!("baked.wgsl"),
            include_str!("baked_bindings.wgsl"),
        ]
    }

    /// A part that goes on in the next grid is one part.
    fn constants(&self) -> Vec<(&'static str, f64)> {
        vec![("MERGE", 1.0)]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(BakedRecord::new(self)),
            // All grids are in one buffer.
            Argument::read(self.grids()[0].words()),
        ]
    }
}

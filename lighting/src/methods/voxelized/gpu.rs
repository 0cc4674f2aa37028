//! Voxelized shadow volumes in shaders.

use std::borrow::Borrow;

use bytemuck::{Pod, Zeroable};
use epipolar::gpu::LatticeRecord;
use gpu_backend::gpu::{Argument, GpuMemory, InShader};
use gpu_backend::shader::Part;
use voxel_shadow::gpu::SamplingRecord;

use super::{Detail, State, VoxelShadow, VoxelVolume};
use crate::gpu::VisibilitySlot;

/// `light_Voxels` of `voxels.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct VoxelRecord {
    pub(crate) lattice: LatticeRecord,
    pub(crate) sampling: SamplingRecord,
    pub(crate) detail: u32,
    pub(crate) state: u32,
    pub(crate) padding: [u32; 2],
}

impl<V: Borrow<VoxelVolume<GpuMemory>>> InShader<VisibilitySlot> for VoxelShadow<V, GpuMemory> {
    fn part() -> Part {
        Part::new("light_voxels")
            .sources(&[epipolar::gpu::EPIPOLAR, epipolar::gpu::PHI])
            .sources(&[voxel_shadow::gpu::SHADOW, include_str!("voxels.wgsl")])
            .uniform("light_voxels", "light_Voxels")
            .read("light_voxel_bounds", "array<vec2<f32>>")
            .read("light_voxel_words", "array<u32>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let volume = self.volume();
        let (state, lattice, bounds): (_, _, &[[f32; 2]]) = match volume.state() {
            State::Lit => (0, LatticeRecord::zeroed(), &[]),
            State::Dark => (1, LatticeRecord::zeroed(), &[]),
            State::Voxels(lattice) => (2, LatticeRecord::new(lattice), lattice.bounds()),
        };
        let record = VoxelRecord {
            lattice,
            sampling: SamplingRecord::new(&volume.sampling()),
            detail: match self.detail() {
                Detail::Average => 0,
                Detail::Voxels => 1,
                Detail::Runs => 2,
            },
            state,
            padding: [0; 2],
        };
        vec![
            Argument::uniform(record),
            Argument::table(bounds),
            Argument::read(volume.grid().words()),
        ]
    }
}

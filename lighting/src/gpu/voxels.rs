//! Voxelized shadow volumes in shaders.

use bytemuck::{Pod, Zeroable};
use epipolar::gpu::LatticeRecord;
use gpu_backend::gpu::{Argument, GpuMemory};
use voxel_shadow::gpu::{SamplingRecord, WgslFirstBlocker};

use super::WgslVisibility;
use super::scene::Map;
use crate::shadow_map::ShadowMap;
use crate::voxels::{Detail, State, VoxelShadow};

/// `Voxels` of `voxel_bindings.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct VoxelRecord {
    pub(super) lattice: LatticeRecord,
    pub(super) sampling: SamplingRecord,
    pub(super) detail: u32,
    pub(super) state: u32,
    pub(super) padding: [u32; 2],
}

impl WgslVisibility for VoxelShadow<'_, GpuMemory> {
    fn parts() -> &'static [&'static str] {
        &[
            epipolar::gpu::EPIPOLAR,
            epipolar::gpu::PHI,
            voxel_shadow::gpu::SHADOW,
            include_str!("voxels.wgsl"),
            include_str!("voxel_bindings.wgsl"),
        ]
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

impl WgslFirstBlocker for ShadowMap<GpuMemory> {
    fn parts() -> &'static [&'static str] {
        &[
            super::FACE,
            super::PLACE,
            super::MAP,
            include_str!("map_faces.wgsl"),
            include_str!("map_bindings.wgsl"),
            include_str!("first_blocker.wgsl"),
        ]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(Map::new(self)),
            Argument::read(self.depth()),
        ]
    }
}

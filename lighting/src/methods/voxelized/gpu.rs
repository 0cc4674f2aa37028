//! Voxelized shadow volumes in shaders.

use std::borrow::Borrow;

use bytemuck::{Pod, Zeroable};
use epipolar::Lattice;
use epipolar::gpu::LatticeRecord;
use gpu_backend::gpu::{Argument, GpuMemory, InShader};
use gpu_backend::shader::Part;
use voxel_shadow::gpu::SamplingRecord;

use super::{Detail, Sampling, State, VoxelShadow, VoxelVolume};
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

/// What is read from the voxels of any light, through `light_voxels()`.
pub(crate) const VOXELS: &str = include_str!("voxels.wgsl");

impl VoxelRecord {
    pub(crate) fn new(state: State<&Lattice>, sampling: &Sampling, detail: Detail) -> Self {
        let (state, lattice) = match state {
            State::Lit => (0, LatticeRecord::zeroed()),
            State::Dark => (1, LatticeRecord::zeroed()),
            State::Voxels(lattice) => (2, LatticeRecord::new(lattice)),
        };
        Self {
            lattice,
            sampling: SamplingRecord::new(sampling),
            detail: match detail {
                Detail::Average => 0,
                Detail::Voxels => 1,
                Detail::Runs => 2,
            },
            state,
            padding: [0; 2],
        }
    }
}

impl<'a> State<&'a Lattice> {
    /// Those of the lattice along φ.
    pub(crate) fn bounds(self) -> &'a [[f32; 2]] {
        match self {
            Self::Lit | Self::Dark => &[],
            Self::Voxels(lattice) => lattice.bounds(),
        }
    }
}

impl<V: Borrow<VoxelVolume<GpuMemory>>> InShader<VisibilitySlot> for VoxelShadow<V, GpuMemory> {
    fn part() -> Part {
        Part::new("light_voxels")
            .sources(&[epipolar::gpu::EPIPOLAR, epipolar::gpu::PHI])
            .sources(&[voxel_shadow::gpu::SHADOW, VOXELS])
            .source(include_str!("volume.wgsl"))
            .uniform("light_voxel_volume", "light_Voxels")
            .read("light_voxel_bounds", "array<vec2<f32>>")
            .read("light_voxel_words", "array<u32>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let volume = self.volume();
        let record = VoxelRecord::new(volume.state(), &volume.sampling(), self.detail());
        vec![
            Argument::uniform(record),
            Argument::table(volume.state().bounds()),
            Argument::read(volume.grid().words()),
        ]
    }
}

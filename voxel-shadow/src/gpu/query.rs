//! Queries on a GPU.

use epipolar::gpu::{EPIPOLAR, LatticeRecord, PHI};
use gpu_backend::Buffer;
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, Kernel, Workgroups,
};

use super::{GROUP, SHADOW, SamplingRecord};
use crate::error::same_length;
use crate::query::{capacity, check_weights};
use crate::{Error, LitInterval, Query, ShadowVolume, Weights};

/// Uniforms of `query.wgsl` and `intervals.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Parameters {
    pub(super) lattice: LatticeRecord,
    pub(super) sampling: SamplingRecord,
    pub(super) count: u32,
    pub(super) capacity: u32,
    pub(super) first_word: u32,
    padding: u32,
}

impl Parameters {
    pub(super) fn new(volume: &ShadowVolume<'_, GpuMemory>, count: usize, capacity: usize) -> Self {
        Self {
            lattice: LatticeRecord::new(volume.lattice()),
            sampling: SamplingRecord::new(&volume.sampling()),
            // More are refused by the dispatch.
            count: count as u32,
            capacity: capacity as u32,
            // No buffer has as many words.
            first_word: volume.first_word() as u32,
            padding: 0,
        }
    }
}

pub(super) const QUERY: &[&str] = &[
    INDEX_WGSL,
    EPIPOLAR,
    PHI,
    SHADOW,
    include_str!("query.wgsl"),
];
pub(super) const INTERVALS: &[&str] = &[
    INDEX_WGSL,
    EPIPOLAR,
    PHI,
    SHADOW,
    include_str!("intervals.wgsl"),
];

/// Runs an entry point of `query.wgsl`.
fn query<E: Encode>(
    gpu: &Gpu<E>,
    entry: &'static str,
    volume: &ShadowVolume<'_, GpuMemory>,
    weights: Option<&Weights>,
    rays: &GpuBuffer<[f32; 4]>,
    results: &mut GpuBuffer<f32>,
) -> Result<(), Error> {
    let mut arguments = vec![
        Argument::uniform(Parameters::new(volume, rays.len(), 0)),
        Argument::table(volume.lattice().bounds()),
        Argument::read(volume.words()),
        Argument::read(rays),
        Argument::write(results),
    ];
    arguments.extend(weights.map(|weights| Argument::table(weights.sums())));
    gpu.dispatch(
        &Kernel {
            label: entry,
            parts: QUERY,
            entry,
            constants: &[],
        },
        &[&arguments],
        Workgroups::covering(rays.len(), GROUP),
    )?;
    Ok(())
}

impl<E: Encode> Query for Gpu<E> {
    fn visibility(
        &self,
        volume: &ShadowVolume<'_, GpuMemory>,
        points: &GpuBuffer<[f32; 4]>,
        visibility: &mut GpuBuffer<f32>,
    ) -> Result<(), Error> {
        same_length("the visibilities of points", points.len(), visibility.len())?;
        query(self, "visibility", volume, None, points, visibility)
    }

    fn lit_fraction(
        &self,
        volume: &ShadowVolume<'_, GpuMemory>,
        rays: &GpuBuffer<[f32; 4]>,
        fractions: &mut GpuBuffer<f32>,
    ) -> Result<(), Error> {
        same_length("the lit fractions of rays", rays.len(), fractions.len())?;
        query(self, "lit_fraction", volume, None, rays, fractions)
    }

    fn weighted_sum(
        &self,
        volume: &ShadowVolume<'_, GpuMemory>,
        weights: &Weights,
        rays: &GpuBuffer<[f32; 4]>,
        sums: &mut GpuBuffer<f32>,
    ) -> Result<(), Error> {
        same_length("the weighted sums of rays", rays.len(), sums.len())?;
        check_weights(volume, weights)?;
        query(self, "weighted_sum", volume, Some(weights), rays, sums)
    }

    fn lit_intervals(
        &self,
        volume: &ShadowVolume<'_, GpuMemory>,
        rays: &GpuBuffer<[f32; 4]>,
        intervals: &mut GpuBuffer<LitInterval>,
        counts: &mut GpuBuffer<u32>,
    ) -> Result<(), Error> {
        let capacity = capacity(rays.len(), intervals.len(), counts.len())?;
        self.dispatch(
            &Kernel {
                label: "lit intervals",
                parts: INTERVALS,
                entry: "lit_intervals",
                constants: &[],
            },
            &[&[
                Argument::uniform(Parameters::new(volume, rays.len(), capacity)),
                Argument::table(volume.lattice().bounds()),
                Argument::read(volume.words()),
                Argument::read(rays),
                Argument::write(intervals),
                Argument::write(counts),
            ]],
            Workgroups::covering(rays.len(), GROUP),
        )?;
        Ok(())
    }
}

//! Filling pictures from samples, on a GPU.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, Kernel, Workgroups,
};
use gpu_backend::{Backend, Buffer, Error};

use super::fill::{FillPicture, Filling, check};
use super::grid::{Filter, Grid};

/// Invocations per workgroup in `reduced.wgsl`.
const GROUP: u32 = 64;

/// The shader.
pub(super) const REDUCED: [&str; 2] = [INDEX_WGSL, include_str!("reduced.wgsl")];

/// `Grid` of `reduced.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct GridRecord {
    pub(super) columns: u32,
    pub(super) rows: u32,
    pub(super) sample_columns: u32,
    pub(super) sample_rows: u32,
    pub(super) window_columns: u32,
    pub(super) window_count: u32,
    pub(super) block: u32,
    pub(super) window: u32,
    pub(super) bilateral: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
    pub(super) padding_c: u32,
}

impl GridRecord {
    fn new(grid: &Grid) -> Self {
        Self {
            columns: grid.size[0],
            rows: grid.size[1],
            sample_columns: grid.samples[0],
            sample_rows: grid.samples[1],
            window_columns: grid.windows[0],
            window_count: grid.window_count(),
            block: grid.block,
            window: grid.window,
            bilateral: u32::from(grid.filter == Filter::Bilateral),
            padding_a: 0,
            padding_b: 0,
            padding_c: 0,
        }
    }
}

/// A pass over samples or pixels.
struct Pass<'a> {
    entry: &'static str,
    /// For each sample or pixel, the ray of its own.
    own: &'a GpuBuffer<u32>,
    gathered: &'a GpuBuffer<[f32; 4]>,
    samples: &'a GpuBuffer<[f32; 4]>,
}

fn run<E: Encode>(
    gpu: &Gpu<E>,
    filling: &Filling<'_, GpuMemory>,
    pass: &Pass<'_>,
    radiance: &mut GpuBuffer<[f32; 4]>,
) -> Result<(), Error> {
    let items = radiance.len();
    gpu.dispatch(
        &Kernel {
            label: pass.entry,
            parts: &REDUCED,
            entry: pass.entry,
            constants: &[],
        },
        &[&[
            Argument::uniform(GridRecord::new(&filling.choice.grid)),
            Argument::read(filling.rays),
            Argument::read(&filling.planes),
            Argument::read(pass.own),
            Argument::read(pass.gathered),
            Argument::read(pass.samples),
            Argument::write(radiance),
        ]],
        Workgroups::covering(items, GROUP),
    )
}

impl<E: Encode> FillPicture for Gpu<E> {
    fn fill_picture(
        &self,
        filling: &Filling<'_, GpuMemory>,
        gathered: &GpuBuffer<[f32; 4]>,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check(filling.choice, gathered.len(), radiance.len())?;
        let grid = &filling.choice.grid;
        let join = Pass {
            entry: "join_subsets",
            own: &filling.of_samples,
            gathered,
            samples: gathered,
        };
        if grid.block == 1 {
            return run(self, filling, &join, radiance);
        }
        let joined;
        let mut samples = gathered;
        if grid.window > 1 {
            let mut sums = self.zeros::<[f32; 4]>(grid.sample_count())?;
            run(self, filling, &join, &mut sums)?;
            joined = sums;
            samples = &joined;
        }
        let fill = Pass {
            entry: "fill_between",
            own: &filling.of_pixels,
            gathered,
            samples,
        };
        run(self, filling, &fill, radiance)
    }
}

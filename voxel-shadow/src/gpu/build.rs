//! Setting and extruding bits on a GPU.

use gpu_backend::Backend;
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, Kernel, Workgroups,
};

use super::GROUP;
use crate::error::same_resolution;
use crate::{BuildGrid, Error, Grid, IndexMap};

/// Rows that a workgroup of `extrude.wgsl` scans.
pub(super) const BLOCK: u32 = 128;

/// Columns that it scans.
const COLUMNS: u32 = 16;

/// Uniforms of `voxelise.wgsl` and `extrude.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Parameters {
    pub(super) rows: u32,
    pub(super) columns: u32,
}

pub(super) const VOXELISE: &[&str] = &[INDEX_WGSL, include_str!("voxelise.wgsl")];
pub(super) const EXTRUDE: &[&str] = &[INDEX_WGSL, include_str!("extrude.wgsl")];

fn kernel(parts: &'static [&'static str], entry: &'static str) -> Kernel<'static> {
    Kernel {
        label: entry,
        parts,
        entry,
        constants: &[],
    }
}

impl<E: Encode> BuildGrid for Gpu<E> {
    fn voxelise(&self, map: &IndexMap<GpuMemory>, grid: &mut Grid<GpuMemory>) -> Result<(), Error> {
        let resolution = grid.resolution();
        same_resolution("a rectified shadow map", resolution, map.resolution())?;
        let parameters = Parameters {
            rows: resolution.alpha(),
            columns: resolution.words_per_row() as u32,
        };
        let work = [
            ("clear", resolution.words()),
            ("voxelise", resolution.words_per_row()),
        ];
        for (entry, items) in work {
            self.dispatch(
                &kernel(VOXELISE, entry),
                &[&[
                    Argument::uniform(parameters),
                    Argument::write(grid.words_mut()),
                    Argument::read(map.indices()),
                ]],
                Workgroups::covering(items, GROUP),
            )?;
        }
        Ok(())
    }

    fn extrude(&self, grid: &mut Grid<GpuMemory>) -> Result<(), Error> {
        let scan = if self.is_software() {
            Scan::Columns
        } else {
            Scan::Blocks
        };
        extrude_by(self, grid, scan)
    }
}

/// How a grid is scanned; the result is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scan {
    /// In parallel along the rows too, in workgroups with barriers.
    Blocks,
    /// Each column by one invocation, which reads and writes every word once. A GPU with more
    /// lanes than there are columns is partly idle. For processors that play a GPU, which are
    /// ten times as slow at barriers.
    Columns,
}

pub(super) fn extrude_by<E: Encode>(
    gpu: &Gpu<E>,
    grid: &mut Grid<GpuMemory>,
    scan: Scan,
) -> Result<(), Error> {
    let resolution = grid.resolution();
    let parameters = Parameters {
        rows: resolution.alpha(),
        columns: resolution.words_per_row() as u32,
    };
    let words = grid.words_mut();
    match scan {
        Scan::Blocks => scan_blocks(gpu, parameters, words),
        Scan::Columns => Ok(gpu.dispatch(
            &kernel(EXTRUDE, "scan_columns"),
            &[&[Argument::uniform(parameters), Argument::write(words)]],
            Workgroups::covering(parameters.columns as usize, GROUP),
        )?),
    }
}

/// Scans blocks of rows, then the last rows of all blocks.
fn scan_blocks<E: Encode>(
    gpu: &Gpu<E>,
    parameters: Parameters,
    words: &mut GpuBuffer<u32>,
) -> Result<(), Error> {
    let Parameters { rows, columns } = parameters;
    let blocks = rows.div_ceil(BLOCK);
    let mut carry = gpu.zeros(blocks as usize * columns as usize)?;
    gpu.dispatch(
        &kernel(EXTRUDE, "scan_block"),
        &[&[
            Argument::uniform(parameters),
            Argument::write(words),
            Argument::write(&mut carry),
        ]],
        Workgroups::Grid([columns.div_ceil(COLUMNS), blocks, 1]),
    )?;
    if blocks == 1 {
        return Ok(());
    }
    let level = Parameters {
        rows: blocks,
        columns,
    };
    scan_blocks(gpu, level, &mut carry)?;
    let later = (rows - BLOCK) as usize * columns as usize;
    gpu.dispatch(
        &kernel(EXTRUDE, "add_carry"),
        &[&[
            Argument::uniform(parameters),
            Argument::write(words),
            Argument::write(&mut carry),
        ]],
        Workgroups::covering(later, GROUP),
    )?;
    Ok(())
}

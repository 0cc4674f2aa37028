//! Density grids as candidates of texels: what a shader needs to walk through one.
//!
//! Rays are given in cells of the grid, from the texel at which the grid begins in the picture
//! and from the plane through the middle of the grid, both computed in f64: a shader's rays are
//! then off by a few roundings of the size of the grid, wherever light and grid are.

use glam::Vec3;

use super::view::{Texels, View};
use crate::scene::gpu::GridRecord;
use crate::scene::{DensityGrid, Translucent};

/// The most cells along an axis of a grid that is met in shaders, where a position in it is off
/// by 2⁻²² of that, 5e-4 of a cell.
pub(super) const MOST_CELLS: u32 = 2048;

/// `light_GridRays` of `grid.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct GridRays {
    pub(super) grid: GridRecord,
    pub(super) start: Vec3,
    pub(super) reach: f32,
    pub(super) direction: Vec3,
    pub(super) tint: f32,
    pub(super) across: Vec3,
    pub(super) segments: u32,
    pub(super) down: Vec3,
    pub(super) padding: u32,
}

impl GridRays {
    /// The rays through a grid of the texels from the first of `texels` on, in a colour channel.
    /// The first of its densities has the index `first_density`.
    pub(super) fn new(
        grid: &DensityGrid,
        view: &View,
        texels: Texels,
        channel: usize,
        first_density: u32,
    ) -> Self {
        let bounds = grid.bounds();
        let middle = view.local(0.5 * (bounds.min() + bounds.max())).z as f32;
        // Central rays are not followed behind their origin.
        let reach = if view.is_parallel() {
            middle
        } else {
            middle.max(0.0)
        };
        let line = view.world_line(texels.x[0], texels.y[0], reach.into());
        let (corner, cells) = grid.cell_space();
        let [x, y, z] = grid.cells();
        Self {
            grid: GridRecord::new(grid, first_density),
            start: (cells * ((line.origin - corner) + line.offset)).as_vec3(),
            reach,
            direction: (cells * line.direction).as_vec3(),
            tint: grid.tint()[channel],
            across: (cells * line.across).as_vec3(),
            // A ray crosses each plane between cells at most once.
            segments: x + y + z - 2,
            down: (cells * line.down).as_vec3(),
            padding: 0,
        }
    }
}

/// The densities of all grids among casters, one behind the other.
#[derive(Debug, Default)]
pub(super) struct Densities {
    pub(super) all: Vec<f32>,
    /// For each caster the index of its first density, if it is a grid that takes any light.
    firsts: Vec<Option<u32>>,
}

impl Densities {
    /// `None` if there are more than `most`, or if a grid has more than [`MOST_CELLS`] along an
    /// axis.
    pub(super) fn new(casters: &[Translucent], most: usize) -> Option<Self> {
        let mut densities = Self::default();
        for caster in casters {
            let Translucent::Grid(grid) = caster else {
                densities.firsts.push(None);
                continue;
            };
            let is_clear = grid.scale() * grid.max_density() == 0.0;
            if is_clear {
                densities.firsts.push(None);
                continue;
            }
            let first = densities.all.len();
            let is_too_long = grid.cells().into_iter().any(|cells| cells > MOST_CELLS);
            if is_too_long || grid.density().len() > most - first {
                return None;
            }
            densities.all.extend_from_slice(grid.density());
            densities.firsts.push(Some(u32::try_from(first).ok()?));
        }
        Some(densities)
    }

    /// The index of the first density of the grid that is this caster; `None` if it is no grid,
    /// or takes no light.
    pub(super) fn first(&self, caster: usize) -> Option<u32> {
        self.firsts[caster]
    }
}

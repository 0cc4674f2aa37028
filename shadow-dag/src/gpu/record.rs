//! The data of shadows and lights that shaders read.

use glam::{DVec4, Vec4};
use gpu_backend::Memory;

use crate::layout::Stored;
use crate::{LightSpace, ResidentDag, Resolution, Slices};

/// Where things are in the words of shadows: `dag_Shadows` of shaders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DagRecord {
    pub(super) log2: u32,
    pub(super) root: u32,
    pub(super) top: u32,
    pub(super) cells: u32,
    pub(super) masks: u32,
    pub(super) levels: u32,
    pub(super) slice_shapes: u32,
    pub(super) node_shapes: u32,
}

impl DagRecord {
    /// The numbers of shadows.
    pub fn new<M: Memory>(dag: &ResidentDag<M>) -> Self {
        // Everything but the bits of packed nodes begins at a whole word, and
        // there are fewer than 2²⁷ of them.
        let word = |byte: usize| (dag.first_word() + byte / 4) as u32;
        let (cells, top) = dag.cell_words();
        let shapes = match &dag.layout.stored {
            Stored::Plain(_) => [0; 2],
            Stored::Packed { shapes, .. } => shapes.map(|(start, _)| word(start)),
        };
        Self {
            log2: dag.resolution().log2(),
            root: dag.layout.root,
            top,
            cells: cells as u32,
            masks: word(dag.layout.masks),
            levels: dag.level_words() as u32,
            slice_shapes: shapes[0],
            node_shapes: shapes[1],
        }
    }
}

/// The space of a light: `dag_Space` of shaders.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SpaceRecord {
    pub(super) x: Vec4,
    pub(super) y: Vec4,
    pub(super) depth: Vec4,
    pub(super) w: Vec4,
    pub(super) side: f32,
    pub(super) stretch: f32,
    pub(super) near: f32,
    pub(super) padding: f32,
}

impl SpaceRecord {
    /// The space of a light with a grid of `resolution`.
    pub fn new(light: &LightSpace, resolution: Resolution) -> Self {
        let row = |i: usize| -> DVec4 { light.matrix().row(i) };
        let (depth, near, stretch) = match light.slices() {
            Slices::Linear => (row(2), 0.0, 0.0),
            Slices::Logarithmic(ends) => (row(3), ends.near(), ends.stretch()),
        };
        Self {
            x: row(0).as_vec4(),
            y: row(1).as_vec4(),
            depth: depth.as_vec4(),
            w: row(3).as_vec4(),
            side: resolution.side() as f32,
            stretch: stretch as f32,
            near: near as f32,
            padding: 0.0,
        }
    }

    /// The space of the light of shadows; voxels themselves if it is not
    /// known.
    pub fn of<M: Memory>(dag: &ResidentDag<M>) -> Self {
        let voxels = LightSpace::of_voxels(dag.resolution());
        Self::new(dag.light().unwrap_or(&voxels), dag.resolution())
    }
}

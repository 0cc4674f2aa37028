//! Precomputed voxelized shadows in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, GpuMemory, InShader};
use gpu_backend::shader::Part;
use shadow_dag::gpu::{DagRecord, SpaceRecord};

use super::{BakedShadow, BakedShadows};
use crate::gpu::VisibilitySlot;
use crate::methods::many_lights::ManyVisibilitySlot;

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

/// The walk through the grids of a light.
fn walk() -> Part {
    Part::new("light_baked")
        .sources(&[shadow_dag::gpu::POINT, shadow_dag::gpu::PACKED])
        .sources(&[shadow_dag::gpu::SPACE, shadow_dag::gpu::RAY])
        .source(include_str!("baked.wgsl"))
}

impl InShader<VisibilitySlot> for BakedShadow<GpuMemory> {
    fn part() -> Part {
        walk()
            .source(include_str!("baked_one.wgsl"))
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

impl InShader<ManyVisibilitySlot> for BakedShadows<GpuMemory> {
    fn part() -> Part {
        walk()
            .source(include_str!("baked_many.wgsl"))
            .read("light_baked_lights", "array<light_Baked>")
            .read("light_baked_words", "array<u32>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let lights: Vec<_> = self.lights().iter().map(BakedRecord::new).collect();
        let mut arguments = vec![Argument::table(&lights)];
        // All grids of all lights are in one buffer, and a light has grids.
        let words = self.lights().iter().flat_map(|light| light.grids()).next();
        arguments.extend(words.map(|grid| Argument::read(grid.words())));
        arguments
    }
}

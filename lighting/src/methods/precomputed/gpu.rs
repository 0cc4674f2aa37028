//! Precomputed voxelized shadows in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuMemory, InShader};
use gpu_backend::shader::Part;
use shadow_dag::Error;
use shadow_dag::gpu::{DagRecord, SpaceRecord};

use super::{BakedShadow, BakedShadows, FilteredShadows};
use crate::direct_light::ManySurfacesSlot;
use crate::gpu::VisibilitySlot;
use crate::methods::many_lights::ManyVisibilitySlot;

/// `light_BakedGrid` of `grids.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GridRecord {
    pub(crate) dag: DagRecord,
    pub(crate) space: SpaceRecord,
}

/// `light_Baked` of `grids.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct BakedRecord {
    pub(crate) grids: [GridRecord; 6],
    pub(crate) count: u32,
    pub(crate) bias: f32,
    pub(crate) padding: [u32; 2],
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
        record.bias = shadow.bias();
        record
    }
}

impl BakedShadows<GpuMemory> {
    /// Uploads the shadows of many lights in as few buffers as possible. Each buffer fits into
    /// one binding of the device, unless it holds a single light that does not.
    ///
    /// # Errors
    /// As for [`BakedShadows::upload`].
    pub fn upload_in_bindings<E: Encode>(
        shadows: &[BakedShadow],
        gpu: &Gpu<E>,
    ) -> Result<Vec<Self>, Error> {
        let limits = gpu.context().limits();
        let most = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        Self::upload_in_parts(shadows, gpu, most)
    }
}

/// The part that walks through the grids of a light.
fn walk() -> Part {
    Part::new("light_baked")
        .sources(&[shadow_dag::gpu::POINT, shadow_dag::gpu::PACKED])
        .sources(&[shadow_dag::gpu::SPACE, shadow_dag::gpu::RAY])
        .sources(&[include_str!("grids.wgsl"), include_str!("baked.wgsl")])
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
        arguments(self)
    }
}

/// The lights, and their grids.
fn arguments(shadows: &BakedShadows<GpuMemory>) -> Vec<Argument<'_>> {
    let lights: Vec<_> = shadows.lights().iter().map(BakedRecord::new).collect();
    let mut arguments = vec![Argument::table(&lights)];
    // All grids of all lights are in one buffer, and a light has grids.
    let words = (shadows.lights().iter())
        .flat_map(|light| light.grids())
        .next();
    arguments.extend(words.map(|grid| Argument::read(grid.words())));
    arguments
}

impl InShader<ManySurfacesSlot> for FilteredShadows<'_, GpuMemory> {
    fn part() -> Part {
        Part::new("light_filtered")
            .sources(&[shadow_dag::gpu::POINT, shadow_dag::gpu::PACKED])
            .sources(&[shadow_dag::gpu::SPACE, shadow_dag::gpu::EXTENT])
            .source(include_str!("grids.wgsl"))
            .sources(&[
                include_str!("baked_many.wgsl"),
                include_str!("filtered.wgsl"),
            ])
            .read("light_baked_lights", "array<light_Baked>")
            .read("light_baked_words", "array<u32>")
            .uniform("light_filter_width", "u32")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = arguments(self.shadows());
        arguments.push(Argument::uniform(self.size().width()));
        arguments
    }
}

//! The same in shaders.

use bytemuck::Zeroable;
use gpu_backend::gpu::{Argument, GpuMemory, InShader};
use gpu_backend::shader::Part;

use super::FilteredHybrid;
use crate::gpu::scene::PicturesRecord;
use crate::gpu::{StepSlot, VisibilitySlot};
use crate::methods::hybrid::Spread;
use crate::methods::hybrid::gpu::{SEARCH, STORED, cells, volumes_in_shader};

impl<P: InShader<StepSlot>> InShader<VisibilitySlot> for FilteredHybrid<P, GpuMemory> {
    fn part() -> Part {
        let points = P::part();
        Part::new("light_filtered")
            .glue::<StepSlot>(&points)
            .with(points)
            // The pictures that volumes are in.
            .uniform("light_map", "light_Pictures")
            .uniform("light_hybrid", "light_Hybrid")
            .read("light_hybrid_near", "array<f32>")
            .read("light_hybrid_far", "array<f32>")
            .source(STORED)
            .source(SEARCH)
            .source(include_str!("filtered.wgsl"))
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        self.points().constants()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = self.points().arguments();
        let volumes = (self.volumes(), self.lit_volumes());
        arguments.push(Argument::uniform(match cells(volumes) {
            Some(cells) => PicturesRecord::new(&cells.faces, cells.resolution),
            None => PicturesRecord::zeroed(),
        }));
        arguments.extend(volumes_in_shader(volumes, self.steps(), Spread::Span));
        arguments
    }
}

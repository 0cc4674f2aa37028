//! A march in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;

use super::{March, Spacing};
use crate::gpu::{PointSlot, VisibilitySlot};

/// `light_March` of `march.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct MarchRecord {
    pub(crate) steps: u32,
    pub(crate) spacing: u32,
    pub(crate) stride: u32,
    pub(crate) each: u32,
}

impl<P: InShader<PointSlot>> InShader<VisibilitySlot> for March<P> {
    fn part() -> Part {
        let points = P::part();
        Part::new("light_march")
            .glue::<PointSlot>(&points)
            .with(points)
            .uniform("light_march", "light_March")
            .source(include_str!("march.wgsl"))
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        self.points().constants()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = self.points().arguments();
        arguments.push(Argument::uniform(MarchRecord {
            steps: self.steps(),
            spacing: match self.spacing() {
                Spacing::Distance => 0,
                Spacing::EquiAngular => 1,
                Spacing::Picture => 2,
            },
            stride: self.interleaving().of(),
            each: self.interleaving().each(),
        }));
        arguments
    }
}

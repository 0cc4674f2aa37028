//! Slices in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;

use super::Slices;
use crate::gpu::{PointSlot, VisibilitySlot};

/// `light_Slices` of `slices.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct SlicesRecord {
    pub(crate) forward: [f32; 3],
    pub(crate) thickness: f32,
    pub(crate) count: u32,
    pub(crate) near: f32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
}

impl<P: InShader<PointSlot>> InShader<VisibilitySlot> for Slices<P> {
    fn part() -> Part {
        let points = P::part();
        Part::new("light_slices")
            .glue::<PointSlot>(&points)
            .with(points)
            .uniform("light_slices", "light_Slices")
            .source(include_str!("slices.wgsl"))
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        self.points.constants()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = self.points.arguments();
        arguments.push(Argument::uniform(SlicesRecord {
            forward: self.forward.to_array(),
            thickness: (self.far - self.near) / self.count as f32,
            count: self.count,
            near: self.near,
            padding_a: 0,
            padding_b: 0,
        }));
        arguments
    }
}

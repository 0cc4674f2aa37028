//! No shadows, in shaders.

use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;

use super::Unshadowed;
use crate::gpu::VisibilitySlot;

impl InShader<VisibilitySlot> for Unshadowed {
    fn part() -> Part {
        Part::new("light_unshadowed").source(include_str!("unshadowed.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

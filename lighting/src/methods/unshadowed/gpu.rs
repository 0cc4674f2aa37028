//! No shadows, in shaders.

use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;

use super::Unshadowed;
use crate::gpu::{PointSlot, VisibilitySlot};

impl InShader<VisibilitySlot> for Unshadowed {
    fn part() -> Part {
        Part::new("light_unshadowed").source(include_str!("unshadowed.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

impl InShader<PointSlot> for Unshadowed {
    fn part() -> Part {
        Part::new("light_unshadowed").source(include_str!("unshadowed_point.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

//! Two visibility sources in one shader.

use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;

use super::slots::{First, FirstPoint, Second, SecondPoint};
use super::{PointSlot, VisibilitySlot};
use crate::visibility::Both;

/// The two must be of different kinds: two marches do not meet in one shader.
impl<A, B> InShader<VisibilitySlot> for Both<A, B>
where
    A: InShader<VisibilitySlot>,
    B: InShader<VisibilitySlot>,
{
    fn part() -> Part {
        let (first, second) = (A::part(), B::part());
        Part::new("light_both")
            .glue::<First>(&first)
            .glue::<Second>(&second)
            .with(first)
            .with(second)
            .source(include_str!("both.wgsl"))
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        [self.0.constants(), self.1.constants()].concat()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = self.0.arguments();
        arguments.extend(self.1.arguments());
        arguments
    }
}

/// The two must be of different kinds.
impl<A, B> InShader<PointSlot> for Both<A, B>
where
    A: InShader<PointSlot>,
    B: InShader<PointSlot>,
{
    fn part() -> Part {
        let (first, second) = (A::part(), B::part());
        Part::new("light_both_points")
            .glue::<FirstPoint>(&first)
            .glue::<SecondPoint>(&second)
            .with(first)
            .with(second)
            .source(include_str!("both_points.wgsl"))
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        [self.0.constants(), self.1.constants()].concat()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = self.0.arguments();
        arguments.extend(self.1.arguments());
        arguments
    }
}

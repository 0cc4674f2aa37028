//! Two visibility sources in one shader.

use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::{Part, Slot};

use super::slots::{First, FirstPoint, FirstSurface, Second, SecondPoint, SecondSurface};
use super::{PointSlot, VisibilitySlot};
use crate::direct_light::ManySurfacesSlot;
use crate::visibility::Both;

/// A slot that two parts can fill together.
pub(super) trait SharedSlot: Slot {
    /// The slot of the first of the two.
    type First: Slot;
    /// The slot of the second.
    type Second: Slot;
    /// The part that makes one answer of two, which needs both slots.
    fn part() -> Part;
}

impl SharedSlot for VisibilitySlot {
    type First = First;
    type Second = Second;

    fn part() -> Part {
        Part::new("light_both").source(include_str!("both.wgsl"))
    }
}

impl SharedSlot for PointSlot {
    type First = FirstPoint;
    type Second = SecondPoint;

    fn part() -> Part {
        Part::new("light_both_points").source(include_str!("both_points.wgsl"))
    }
}

impl SharedSlot for ManySurfacesSlot {
    type First = FirstSurface;
    type Second = SecondSurface;

    fn part() -> Part {
        Part::new("light_both_surfaces").source(include_str!("both_surfaces.wgsl"))
    }
}

/// The two must be of different kinds: two marches do not meet in one shader.
impl<S: SharedSlot, A: InShader<S>, B: InShader<S>> InShader<S> for Both<A, B> {
    fn part() -> Part {
        let (first, second) = (A::part(), B::part());
        S::part()
            .glue::<S::First>(&first)
            .glue::<S::Second>(&second)
            .with(first)
            .with(second)
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

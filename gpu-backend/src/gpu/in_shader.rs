//! Values that shaders read.

use std::sync::Arc;

use super::Argument;
use crate::shader::{Part, Slot};

/// A value that answers the question of the slot `S` in a shader.
///
/// The part is that of the type, so that a shader can be checked without a
/// device and its pipeline is found whatever the value.
pub trait InShader<S: Slot> {
    /// The text, and what it reads.
    fn part() -> Part;

    /// Values of `override` constants.
    fn constants(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// One argument for each of the [bindings](Part::bindings), in their order.
    fn arguments(&self) -> Vec<Argument<'_>>;
}

impl<S: Slot, T: InShader<S>> InShader<S> for &T {
    fn part() -> Part {
        T::part()
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        (**self).constants()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        (**self).arguments()
    }
}

impl<S: Slot, T: InShader<S>> InShader<S> for Arc<T> {
    fn part() -> Part {
        T::part()
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        (**self).constants()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        (**self).arguments()
    }
}

//! Pairs of exact visibility whose shaders know solid triangles alone.

use gpu_backend::Cpu;

use super::method::Traced;
use crate::methods::{Evaluators, Frame, MethodError, PerLight, RunOn, Wraps};

/// A pair that runs in shaders where all triangles are solid or cast no shadow. On a GPU
/// whose frame has others, or more than a binding or a software driver takes, the CPU computes
/// the light and the GPU adds it, and the [watch](crate::Watch::told) is told so. Nothing is
/// read back, so that it is the same in an encoder of the caller's.
#[derive(Debug, Clone)]
pub(super) struct SolidInShaders<A>(pub(super) PerLight<Traced, A>);

impl<A> SolidInShaders<A> {
    pub(super) fn new(pair: PerLight<Traced, A>) -> Self {
        Self(pair)
    }
}

impl<A: Evaluators> Wraps for SolidInShaders<A> {
    type Wrapped = PerLight<Traced, A>;

    fn wrapped(&self) -> &PerLight<Traced, A> {
        &self.0
    }
}

impl<A: Evaluators> RunOn<Cpu> for SolidInShaders<A> {
    fn prepare(&self, frame: &Frame<'_, Cpu>, quality: u32) -> Result<(), MethodError> {
        self.0.prepare(frame, quality)
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, Cpu>,
        quality: u32,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), MethodError> {
        self.0.add_radiance(frame, quality, radiance)
    }
}

//! Pairs of exact visibility whose shaders know solid triangles alone.

use gpu_backend::Cpu;

use super::method::Traced;
use crate::methods::{
    About, Evaluators, Frame, FrameInputs, Method, MethodError, PerLight, RunOn, Verdict, Work,
};
use crate::scene::Geometry;

/// A pair that runs in shaders where all triangles are solid or cast no shadow. On a GPU
/// whose frame has others, or more than a binding or a software driver takes, the CPU computes the light and
/// the GPU adds it, and the [watch](crate::Watch::told) is told so. Nothing is read back, so
/// that it is the same in an encoder of the caller's.
#[derive(Debug, Clone)]
pub(super) struct SolidInShaders<A>(pub(super) PerLight<Traced, A>);

impl<A> SolidInShaders<A> {
    pub(super) fn new(pair: PerLight<Traced, A>) -> Self {
        Self(pair)
    }
}

impl<A: Evaluators> Method for SolidInShaders<A> {
    fn about(&self) -> About {
        self.0.about()
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        self.0.applies(inputs)
    }

    fn uses_maps_of(&self, geometry: &Geometry) -> bool {
        self.0.uses_maps_of(geometry)
    }

    fn distinct<'q>(
        &self,
        inputs: &FrameInputs<'_>,
        qualities: &'q [u32],
    ) -> (&'q [u32], Option<&'static str>) {
        self.0.distinct(inputs, qualities)
    }

    fn sees_cover(&self) -> bool {
        self.0.sees_cover()
    }

    fn tolerance(&self, quality: u32) -> Option<f64> {
        self.0.tolerance(quality)
    }

    fn interleaves(&self, inputs: &FrameInputs<'_>) -> Verdict {
        self.0.interleaves(inputs)
    }

    fn takes_some_pixels(&self) -> Verdict {
        self.0.takes_some_pixels()
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        self.0.notes(inputs)
    }

    fn work(&self, inputs: &FrameInputs<'_>, quality: u32) -> Work {
        self.0.work(inputs, quality)
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

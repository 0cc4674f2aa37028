//! The step that evaluates a batch.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Buffer, Error};

use super::SEGMENT;
use crate::step::check_lengths;
use crate::{EvaluateAirlight, Segment};

/// Invocations per workgroup in `batch.wgsl`.
const GROUP: u32 = 64;

/// An evaluator that brings its part of a shader.
pub trait WgslEvaluator {
    /// WGSL after [`SEGMENT`] that defines
    /// `fn air_airlight(sigma_t: f32, segment: air_Segment) -> f32`, the
    /// airlight per unit of `σ_s I`. Its bindings are in `@group(1)`.
    fn parts() -> &'static [&'static str];

    /// What is bound to `@group(1)`.
    fn arguments(&self) -> Vec<Argument<'_>>;
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Batch {
    pub(super) sigma_t: f32,
    pub(super) segments: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
}

/// All parts of the shader of an evaluator.
pub(super) fn parts<A: WgslEvaluator>() -> Vec<&'static str> {
    let shared = [INDEX_WGSL, SEGMENT];
    let entry = [include_str!("batch.wgsl")];
    [&shared, A::parts(), &entry].concat()
}

impl<A: WgslEvaluator, E: Encode> EvaluateAirlight<A> for Gpu<E> {
    fn evaluate_airlight(
        &self,
        evaluator: &A,
        sigma_t: f32,
        segments: &GpuBuffer<Segment>,
        airlight: &mut GpuBuffer<f32>,
    ) -> Result<(), Error> {
        check_lengths(segments, airlight)?;
        let batch = Batch {
            sigma_t,
            // More segments than that are refused by the dispatch.
            segments: segments.len() as u32,
            padding_a: 0,
            padding_b: 0,
        };
        self.dispatch(
            &Kernel {
                label: "evaluate airlight",
                parts: &parts::<A>(),
                entry: "evaluate",
                constants: &[],
            },
            &[
                &[
                    Argument::uniform(batch),
                    Argument::read(segments),
                    Argument::write(airlight),
                ],
                &evaluator.arguments(),
            ],
            Workgroups::covering(segments.len(), GROUP),
        )
    }
}

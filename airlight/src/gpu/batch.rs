//! The step that evaluates a batch.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::{Assembly, Slot};
use gpu_backend::{Buffer, Error};

use super::SEGMENT;
use crate::step::check_lengths;
use crate::{EvaluateAirlight, Segment};

/// Invocations per workgroup in `batch.wgsl`.
const GROUP: u32 = 64;

/// *How much light arrives from this segment?* The question that an
/// [`Evaluator`](crate::Evaluator) answers, in shaders. A part `x` defines, after
/// [`SEGMENT`],
///
/// ```wgsl
/// fn x_airlight(sigma_t: f32, segment: air_Segment) -> f32
/// ```
///
/// the airlight per unit of `σ_s I`.
#[derive(Debug, Clone, Copy)]
pub struct EvaluatorSlot;

impl Slot for EvaluatorSlot {
    fn glue(part: &str) -> String {
        format!(
            "
fn air_airlight(sigma_t: f32, segment: air_Segment) -> f32 {{
    return {part}_airlight(sigma_t, segment);
}}
"
        )
    }
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Batch {
    pub(super) sigma_t: f32,
    pub(super) segments: u32,
    pub(super) padding_a: u32,
    pub(super) padding_b: u32,
}

/// The shader of an evaluator.
pub(super) fn shader<A: InShader<EvaluatorSlot>>() -> Result<Assembly, Error> {
    let mut shader = Assembly::new(&[INDEX_WGSL, SEGMENT, include_str!("batch.wgsl")]);
    shader.fill::<EvaluatorSlot>(&A::part())?;
    Ok(shader)
}

impl<A: InShader<EvaluatorSlot>, E: Encode> EvaluateAirlight<A> for Gpu<E> {
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
                parts: &shader::<A>()?.finish(1),
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

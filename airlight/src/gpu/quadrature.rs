//! Quadratures as shaders take them.

use bytemuck::{Pod, Zeroable};

/// What `air_quadrature_uniforms` returns, fit for a uniform buffer.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct QuadratureUniforms {
    /// The parameters of the phase function, as in
    /// [`PhaseRecord`](super::PhaseRecord).
    pub phase_parameters: [f32; 4],
    /// Which phase function.
    pub phase_kind: u32,
    /// Number of rules.
    pub rules: u32,
    /// Optical depth after which nothing that counts is left.
    pub opacity: f32,
    /// Growth of the distance from the light after which nothing is left.
    pub far: f32,
    /// Width of the forward peak.
    pub finest_front: f32,
    /// Width of the backward peak.
    pub finest_behind: f32,
    /// Absorption below which it is ignored behind the foot point.
    pub thin: f32,
    /// The most by which the variable of a piece may grow.
    pub growth: f32,
    /// The most by which the exponent may.
    pub fade: f32,
    /// Number of rules that a piece may get without nodes for a pattern.
    pub plain_rules: u32,
    /// The tolerance, 0 for a given number of nodes.
    pub tolerance: f32,
    /// Nothing.
    pub padding: u32,
}

#[cfg(feature = "wgpu")]
mod step {
    use gpu_backend::gpu::{Argument, InShader};
    use gpu_backend::shader::Part;

    use crate::Quadrature;
    use crate::gpu::{EvaluatorSlot, NODES, NUMERIC, PHASE, QUADRATURE, SCALED};

    impl InShader<EvaluatorSlot> for Quadrature {
        fn part() -> Part {
            Part::new("air_quadrature")
                .sources(&[NUMERIC, PHASE, SCALED, NODES, QUADRATURE])
                .source(include_str!("quadrature_bindings.wgsl"))
                .uniform("air_quadrature", "air_Quadrature")
                .read("air_entries", "array<vec4<f32>>")
        }

        fn arguments(&self) -> Vec<Argument<'_>> {
            vec![
                Argument::uniform(self.gpu_uniforms()),
                Argument::table(&self.gpu_entries()),
            ]
        }
    }
}

//! The rules of a quadrature for shaders.

use super::{FADE, GROWTH, Quadrature};
use crate::gpu::{PhaseRecord, QuadratureUniforms};
use crate::side::SHARPEST;

impl Quadrature {
    /// What `air_quadrature_uniforms` returns in a shader with the part
    /// [`NODES`](crate::gpu::NODES).
    pub fn gpu_uniforms(&self) -> QuadratureUniforms {
        let [front, behind] = self.peaks.map(|peak| peak.max(SHARPEST) as f32);
        let phase = PhaseRecord::from(self.phase);
        QuadratureUniforms {
            phase_parameters: phase.parameters,
            phase_kind: phase.kind,
            rules: self.rules.len() as u32,
            opacity: self.opacity as f32,
            far: self.far as f32,
            finest_front: front,
            finest_behind: behind,
            thin: self.thin() as f32,
            growth: GROWTH as f32,
            fade: FADE as f32,
            plain_rules: self.plain as u32,
            tolerance: self.tolerance,
            padding: 0,
        }
    }

    /// The array behind `air_quadrature_entry`: what each rule is good for and
    /// the number of its nodes, then the nodes of all rules.
    pub fn gpu_entries(&self) -> Vec<[f32; 4]> {
        let rules = self.rules.iter().map(|(rule, most)| {
            let [shifted, behind, depth] = most.bounds();
            [shifted, behind, depth, rule.nodes().len() as f32]
        });
        let nodes = self.rules.iter().flat_map(|(rule, _)| rule.nodes());
        let nodes = nodes.map(|&(t, weight)| [t, weight, 0.0, 0.0]);
        rules.chain(nodes).collect()
    }
}

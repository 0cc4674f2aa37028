//! Phase functions as shaders take them.

use crate::PhaseFunction;

/// The first two arguments of `air_phase`.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct PhaseRecord {
    /// Which function.
    pub kind: u32,
    /// Its `g` or `k`; 0 for those that have none.
    pub parameter: f32,
}

impl From<PhaseFunction> for PhaseRecord {
    fn from(phase: PhaseFunction) -> Self {
        let (kind, parameter) = match phase {
            PhaseFunction::Isotropic => (0, 0.0),
            PhaseFunction::HenyeyGreenstein { g } => (1, g),
            PhaseFunction::Rayleigh => (2, 0.0),
            PhaseFunction::Schlick { k } => (3, k),
            PhaseFunction::CornetteShanks { g } => (4, g),
        };
        Self { kind, parameter }
    }
}

#[cfg(test)]
mod tests {
    use gpu_backend::testing::Shader;

    use super::*;

    #[test]
    fn kinds_are_those_of_the_shader() {
        let shader = Shader::new(&[crate::gpu::PHASE]).unwrap();
        shader.require_part(&["air_"]).unwrap();
        for (name, phase) in [
            ("air_ISOTROPIC", PhaseFunction::Isotropic),
            (
                "air_HENYEY_GREENSTEIN",
                PhaseFunction::HenyeyGreenstein { g: 0.5 },
            ),
            ("air_RAYLEIGH", PhaseFunction::Rayleigh),
            ("air_SCHLICK", PhaseFunction::Schlick { k: 0.5 }),
            (
                "air_CORNETTE_SHANKS",
                PhaseFunction::CornetteShanks { g: 0.5 },
            ),
        ] {
            let kind = f64::from(PhaseRecord::from(phase).kind);
            assert_eq!(shader.values(name).unwrap(), [kind], "{name}");
        }
    }
}

//! Phase functions as shaders take them.

use crate::PhaseFunction;

/// The first two arguments of `air_phase`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseRecord {
    /// Which function.
    pub kind: u32,
    /// Its parameters, 0 where it has fewer: `g` or `k`; both `g` and the weight of
    /// the first; `g`, `g_D`, `α` and the weight of Draine's function.
    pub parameters: [f32; 4],
}

impl From<PhaseFunction> for PhaseRecord {
    fn from(phase: PhaseFunction) -> Self {
        let (kind, parameters) = match phase {
            PhaseFunction::Isotropic => (0, [0.0; 4]),
            PhaseFunction::HenyeyGreenstein { g } => (1, [g, 0.0, 0.0, 0.0]),
            PhaseFunction::Rayleigh => (2, [0.0; 4]),
            PhaseFunction::Schlick { k } => (3, [k, 0.0, 0.0, 0.0]),
            PhaseFunction::CornetteShanks { g } => (4, [g, 0.0, 0.0, 0.0]),
            PhaseFunction::DoubleHenyeyGreenstein { g, weight } => (5, [g[0], g[1], weight, 0.0]),
            PhaseFunction::HenyeyGreensteinDraine {
                g,
                draine_g,
                alpha,
                weight,
            } => (6, [g, draine_g, alpha, weight]),
        };
        Self { kind, parameters }
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
            (
                "air_DOUBLE_HENYEY_GREENSTEIN",
                PhaseFunction::DoubleHenyeyGreenstein {
                    g: [0.5, -0.2],
                    weight: 0.5,
                },
            ),
            (
                "air_HENYEY_GREENSTEIN_DRAINE",
                PhaseFunction::droplets(10.0).unwrap(),
            ),
        ] {
            let kind = f64::from(PhaseRecord::from(phase).kind);
            assert_eq!(shader.values(name).unwrap(), [kind], "{name}");
        }
    }
}

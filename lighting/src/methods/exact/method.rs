//! The lit parts of rays from the triangles themselves, found by tracing.

use std::sync::Arc;

use gpu_backend::Cpu;

use super::Exact;
use super::pair::SolidInShaders;
use crate::Touching;
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, Role, SourceAbout, SourceOn,
    Work,
};
use crate::scene::trace::Tracer;

/// Exact lit intervals of every light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Traced;

impl LightSources for Traced {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: "exact",
            title: "exact visibility",
            quality: None,
            touching: Touching::Apart,
            is_sampled: false,
            sees_translucent: false,
            sees_panes: true,
            uses_shadow_map: false,
        }
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn work(&self, inputs: &FrameInputs<'_>, _: u32) -> Work {
        let triangles = inputs.geometry.triangles().len() as f64;
        Work {
            once: triangles,
            // Triangles that its plane cuts, at a few lookups each; those in the dark of
            // others cost less than what lies open.
            per_ray: inputs.emitters.len() as f64 * (32.0 + 2.0 * triangles.sqrt()),
            ..Work::default()
        }
    }
}

impl SourceOn<Cpu> for Traced {
    type Source = Exact<Arc<Tracer>>;

    fn prepare(&self, frame: &Frame<'_, Cpu>, light: usize, _: u32) -> Result<(), MethodError> {
        self.source(frame, light, 0).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, Cpu>,
        _: usize,
        _: u32,
    ) -> Result<Exact<Arc<Tracer>>, MethodError> {
        frame.inputs.tracer().map(Exact::new)
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let compared = |role, airlight, title, purpose, paper, qualities| Compared {
        airlight,
        detail: None,
        title,
        purpose,
        paper,
        qualities,
        role,
        is_baseline: false,
    };
    pairs!(
            within SolidInShaders::new: Traced,
            &[
                Compared {
                    is_baseline: true,
                    ..compared(
    Role::Paper,
                        "gauss",
                        "exact visibility",
                        "truth at the price of tracing; sharp shafts from thin blockers",
                        "the shadow-volume half of Wyman and Ramsey, Interactive Volumetric Shadows, RT 2008",
                        (&[2, 4, 8, 16], &[2, 8], 8),
                    )
                },
                compared(
    Role::Paper,
                    "quadrature",
                    "exact visibility, quadrature to a tolerance",
                    "any light and any phase function to as many digits as asked for",
                    "the integral of Sun et al., SIGGRAPH 2005, in a half-angle variable",
                    (&[2, 3, 4, 5], &[4], 4),
                ),
                compared(
    Role::Variant,
                    "table",
                    "exact visibility, airlight table",
                    "point lights: two lookups for a lit run, wherever the light is",
                    "Sun et al., SIGGRAPH 2005, with a table of the scaled tail instead of theirs",
                    (&[16, 64], &[64], 64),
                ),
                compared(
    Role::Variant,
                    "published",
                    "exact visibility, published airlight table",
                    "what the table of 2005 costs in error: dense fog, looks away from the light",
                    "Sun et al., A Practical Analytic Single Scattering Model, SIGGRAPH 2005",
                    (&[512], &[512], 512),
                ),
                compared(
    Role::Variant,
                    "double",
                    "exact visibility, closed form in double precision",
                    "point lights to all digits; the rest of the error is that of positions in f32",
                    "Sun et al., SIGGRAPH 2005, by the scaled exponential integral",
                    (&[64], &[64], 64),
                ),
            ]
        )
}

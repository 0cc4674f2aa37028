//! No shadows in the air: this shows how much shadows matter, and is the lower bound of the run
//! time.

use gpu_backend::Backend;

use super::Unshadowed;
use crate::Touching;
use crate::methods::many_lights::{SourcesTogether, Together};
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, Role, SourceAbout, SourceOn,
    Work,
};

/// Its name in pairs.
pub(in crate::methods) const NAME: &str = "none";

/// Nothing is in the way of any light.
#[derive(Debug, Clone, Copy)]
struct Nothing;

impl LightSources for Nothing {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: NAME,
            title: "no shadows",
            quality: None,
            touching: Touching::Apart,
            is_sampled: false,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: false,
        }
    }

    fn work(&self, _: &FrameInputs<'_>, _: u32) -> Work {
        Work::default()
    }
}

impl<B: Backend> SourceOn<B> for Nothing {
    type Source = Unshadowed;

    fn prepare(&self, _: &Frame<'_, B>, _: usize, _: u32) -> Result<(), MethodError> {
        Ok(())
    }

    fn source(&self, _: &Frame<'_, B>, _: usize, _: u32) -> Result<Unshadowed, MethodError> {
        Ok(Unshadowed)
    }
}

impl<B: Backend> SourcesTogether<B> for Nothing {
    type Together = Unshadowed;

    fn prepare_light(&self, _: &Frame<'_, B>, _: usize, _: u32) -> Result<(), MethodError> {
        Ok(())
    }

    fn together(
        &self,
        frame: &Frame<'_, B>,
        _: u32,
    ) -> Result<Vec<Together<Unshadowed>>, MethodError> {
        Ok(vec![Together {
            source: Unshadowed,
            lights: frame.inputs.emitters.len(),
        }])
    }

    fn turns(_: &Unshadowed) -> f64 {
        1.0
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    pairs!(
        many: Nothing,
        &[Compared {
            airlight: "gauss",
            detail: None,
            title: "no shadows",
            purpose: "what leaving the shadows out would cost; the floor of the run time",
            paper: "Sun et al., A Practical Analytic Single Scattering Model, SIGGRAPH 2005 (the integral)",
            qualities: (&[8], &[8], 8),
            role: Role::Unshadowed,
            is_baseline: true,
        }]
    )
}

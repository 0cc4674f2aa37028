//! No shadows: nothing blocks any light.

#[cfg(feature = "wgpu")]
mod gpu;
#[cfg(feature = "methods")]
mod method;

#[cfg(feature = "methods")]
pub(super) use method::{NAME, methods};

use glam::Vec3;

use crate::LightPath;
use crate::visibility::{LitInterval, PointVisibility, SurfaceShadow, VisibilitySource};

/// A source in which nothing blocks the light: the whole span is lit.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unshadowed;

impl VisibilitySource for Unshadowed {
    type Share = f32;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let span = path.span();
        lit.push(LitInterval::unshadowed(span.start, span.end));
    }
}

impl PointVisibility for Unshadowed {
    type Share = f32;

    fn visibility(&self, _: Vec3) -> f32 {
        1.0
    }
}

impl SurfaceShadow for Unshadowed {
    fn visibility(&self, _: Vec3, _: Vec3) -> Vec3 {
        Vec3::ONE
    }
}

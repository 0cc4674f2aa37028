//! Which parts of an eye ray see the light.

mod both;
#[cfg(feature = "trace")]
mod exact;
#[cfg(feature = "shadow-map")]
mod march;
mod point;
mod share;

pub use both::Both;
#[cfg(feature = "shadow-dag")]
pub(crate) use both::product;
#[cfg(feature = "trace")]
pub use exact::Exact;
#[cfg(feature = "shadow-map")]
pub use march::{March, Spacing};
pub use point::{PointVisibility, SurfaceShadow};
pub use share::{Behind, LitInterval, Share, join_touching};

use std::sync::Arc;

use glam::Vec3;

use crate::LightPath;

/// Tells which parts of a ray a light reaches.
///
/// A source belongs to one light: the one its shadow map was rendered for, say.
pub trait VisibilitySource: Sync {
    /// What it knows of a share: one number, or one for each colour.
    type Share: Share;

    /// Appends the lit parts of `path.span()` to `lit`: in order along the
    /// ray, not overlapping, none of them dark. Parts may touch (a march yields one
    /// per lit step); [`Gather`](crate::Gather) joins them where that is asked for.
    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<Self::Share>>);
}

impl<V: VisibilitySource + ?Sized> VisibilitySource for &V {
    type Share = V::Share;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<V::Share>>) {
        (**self).lit_intervals(path, lit);
    }
}

impl<V: VisibilitySource + Send + ?Sized> VisibilitySource for Arc<V> {
    type Share = V::Share;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<V::Share>>) {
        (**self).lit_intervals(path, lit);
    }
}

/// Nothing is in the way: all of the span is lit.
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
    fn visibility(&self, _: Vec3, _: Vec3) -> f32 {
        1.0
    }
}

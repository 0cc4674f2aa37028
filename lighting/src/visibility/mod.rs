//! Which parts of an eye ray see the light.

mod both;
mod point;
mod share;

#[cfg(feature = "trace")]
pub use crate::methods::exact::Exact;
#[cfg(feature = "methods")]
pub(crate) use crate::methods::exact::may_shadow;
#[cfg(feature = "shadow-map")]
pub use crate::methods::march::{March, Spacing};
pub use crate::methods::unshadowed::Unshadowed;
pub use both::Both;
#[cfg(feature = "shadow-dag")]
pub(crate) use both::product;
pub use point::{PointVisibility, SurfaceShadow};
pub use share::{Behind, LitInterval, Share, join_touching};

use std::sync::Arc;

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

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

use crate::{Emitter, LightPath, Ray};

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

    /// The order in which rays are best asked about: the numbers of all of them, so that
    /// those that follow each other have much in their way in common. `None` if a ray costs
    /// as much by itself, for which a source need not say anything.
    fn neighbours(&self, _rays: &[Ray], _emitter: &Emitter) -> Option<Vec<u32>> {
        None
    }

    /// Appends the lit parts of each path to the list of the same number: the bits of
    /// [`lit_intervals`](Self::lit_intervals), at less cost if the paths are of
    /// [neighbours](Self::neighbours).
    ///
    /// There are as many lists as paths.
    fn lit_of_neighbours(
        &self,
        paths: &[LightPath<'_>],
        lit: &mut [Vec<LitInterval<Self::Share>>],
    ) {
        for (path, lit) in paths.iter().zip(lit) {
            self.lit_intervals(path, lit);
        }
    }
}

impl<V: VisibilitySource + ?Sized> VisibilitySource for &V {
    type Share = V::Share;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<V::Share>>) {
        (**self).lit_intervals(path, lit);
    }

    fn neighbours(&self, rays: &[Ray], emitter: &Emitter) -> Option<Vec<u32>> {
        (**self).neighbours(rays, emitter)
    }

    fn lit_of_neighbours(&self, paths: &[LightPath<'_>], lit: &mut [Vec<LitInterval<V::Share>>]) {
        (**self).lit_of_neighbours(paths, lit);
    }
}

impl<V: VisibilitySource + Send + ?Sized> VisibilitySource for Arc<V> {
    type Share = V::Share;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<V::Share>>) {
        (**self).lit_intervals(path, lit);
    }

    fn neighbours(&self, rays: &[Ray], emitter: &Emitter) -> Option<Vec<u32>> {
        (**self).neighbours(rays, emitter)
    }

    fn lit_of_neighbours(&self, paths: &[LightPath<'_>], lit: &mut [Vec<LitInterval<V::Share>>]) {
        (**self).lit_of_neighbours(paths, lit);
    }
}

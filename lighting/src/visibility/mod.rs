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

/// Is told the index of a path and the list of its lit parts, which it may change.
pub type LitOfEach<'a, S> = dyn FnMut(usize, &mut Vec<LitInterval<S>>) + 'a;

/// Finds the parts of a ray that a light reaches.
///
/// A source belongs to one light, for example to the one that its shadow map was rendered for.
pub trait VisibilitySource: Sync {
    /// The type of its shares: one number, or one for each colour.
    type Share: Share;

    /// Appends the lit parts of `path.span()` to `lit`. They are in order along the ray, do not
    /// overlap, and none is dark. Parts may touch, as those of a march do, which yields one per
    /// lit step; [`Gather`](crate::Gather) joins them if it is asked to.
    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<Self::Share>>);

    /// The order in which rays are best asked about: a permutation of their indices that puts
    /// rays with similar blockers next to each other. `None`, the default, if asking about
    /// several rays together saves nothing, or if their own order is as good as any.
    fn neighbours(&self, _rays: &[Ray], _emitter: &Emitter) -> Option<Vec<u32>> {
        None
    }

    /// Calls `each` once for each path, in any order, with the index of the path and the list of
    /// its lit parts. All paths are of one light. The parts have the same
    /// bits as those of [`lit_intervals`](Self::lit_intervals), but cost less where a source can
    /// answer for several paths together, above all for those of
    /// [neighbours](Self::neighbours).
    fn lit_of_neighbours(&self, paths: &[LightPath<'_>], each: &mut LitOfEach<'_, Self::Share>) {
        let mut lit = Vec::new();
        for (index, path) in paths.iter().enumerate() {
            lit.clear();
            self.lit_intervals(path, &mut lit);
            each(index, &mut lit);
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

    fn lit_of_neighbours(&self, paths: &[LightPath<'_>], each: &mut LitOfEach<'_, V::Share>) {
        (**self).lit_of_neighbours(paths, each);
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

    fn lit_of_neighbours(&self, paths: &[LightPath<'_>], each: &mut LitOfEach<'_, V::Share>) {
        (**self).lit_of_neighbours(paths, each);
    }
}

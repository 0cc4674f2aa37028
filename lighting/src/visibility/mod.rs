//! Which parts of an eye ray see the light.

#[cfg(feature = "trace")]
mod exact;
#[cfg(feature = "march")]
mod march;
mod merge;
#[cfg(feature = "translucent")]
mod translucent;

#[cfg(feature = "trace")]
pub use exact::Exact;
#[cfg(feature = "march")]
pub use march::{ShadowMapMarch, Spacing};
pub use merge::MergeTouching;
#[cfg(feature = "translucent")]
pub use translucent::TransmittanceMarch;

use crate::{LightPath, LitInterval};

/// Tells which parts of a ray a light reaches.
///
/// A source belongs to one light: the one its shadow map was rendered for, say.
pub trait VisibilitySource: Sync {
    /// Appends the lit parts of `path.span()` to `lit`: in order along the
    /// ray, not overlapping, each with a visibility above 0. Parts may touch
    /// (a march yields one per lit step); see [`MergeTouching`].
    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>);
}

/// Nothing is in the way: all of the span is lit.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unshadowed;

impl VisibilitySource for Unshadowed {
    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let span = path.span();
        lit.push(LitInterval::unshadowed(span.start, span.end));
    }
}

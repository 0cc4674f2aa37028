//! Which parts of an eye ray see the light.

mod both;
#[cfg(feature = "trace")]
mod exact;
#[cfg(feature = "shadow-map")]
mod march;
mod merge;
#[cfg(feature = "translucent")]
mod translucent;

pub use both::Both;
#[cfg(feature = "shadow-dag")]
pub(crate) use both::product;
#[cfg(feature = "trace")]
pub use exact::Exact;
#[cfg(feature = "shadow-map")]
pub use march::{ShadowMapMarch, Spacing};
pub use merge::MergeTouching;
#[cfg(feature = "translucent")]
pub use translucent::TransmittanceMarch;

use glam::Vec3;

use crate::{Interval, LightPath};

/// A part of a ray that the light reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LitInterval {
    /// Which part.
    pub interval: Interval,
    /// Share of the light that gets there, from 0 to 1: 1 where nothing is in
    /// the way, less behind translucent blockers.
    pub visibility: f32,
}

impl LitInterval {
    /// A part that nothing hides from the light.
    pub const fn unshadowed(start: f32, end: f32) -> Self {
        Self {
            interval: Interval::new(start, end),
            visibility: 1.0,
        }
    }
}

/// Tells which parts of a ray a light reaches.
///
/// A source belongs to one light: the one its shadow map was rendered for, say.
pub trait VisibilitySource: Sync {
    /// Appends the lit parts of `path.span()` to `lit`: in order along the
    /// ray, not overlapping, each with a visibility above 0. Parts may touch
    /// (a march yields one per lit step); see [`MergeTouching`].
    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>);
}

impl<V: VisibilitySource + ?Sized> VisibilitySource for &V {
    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        (**self).lit_intervals(path, lit);
    }
}

/// Tells how much of a light reaches a point of a surface.
///
/// It belongs to one light, like a [`VisibilitySource`]: the same question
/// asked at a point.
pub trait SurfaceShadow: Sync {
    /// The share of the light, 0 to 1, that is not blocked on its way to
    /// `point` on a surface with the unit `normal`, on the side of the light.
    fn reaching(&self, point: Vec3, normal: Vec3) -> f32;
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

impl SurfaceShadow for Unshadowed {
    fn reaching(&self, _: Vec3, _: Vec3) -> f32 {
        1.0
    }
}

//! How much of a light reaches a point.

use std::sync::Arc;

use glam::Vec3;

use super::Share;

/// Tells which share of a light reaches a point of the air. Shadow maps and transmittance maps
/// do.
///
/// Like a [`VisibilitySource`](super::VisibilitySource) it belongs to one light. A `March` asks
/// it along rays.
pub trait PointVisibility: Sync {
    /// The type of its shares: one number, or one for each colour.
    type Share: Share;

    /// The share of the light that is not blocked on its way to `point`.
    fn visibility(&self, point: Vec3) -> Self::Share;

    /// The mean share along a short way between two points. The default is the share at the
    /// middle; a source that can be filtered gives the mean.
    fn visibility_between(&self, from: Vec3, to: Vec3) -> Self::Share {
        self.visibility(0.5 * (from + to))
    }
}

impl<P: PointVisibility + ?Sized> PointVisibility for &P {
    type Share = P::Share;

    fn visibility(&self, point: Vec3) -> P::Share {
        (**self).visibility(point)
    }

    fn visibility_between(&self, from: Vec3, to: Vec3) -> P::Share {
        (**self).visibility_between(from, to)
    }
}

impl<P: PointVisibility + Send + ?Sized> PointVisibility for Arc<P> {
    type Share = P::Share;

    fn visibility(&self, point: Vec3) -> P::Share {
        (**self).visibility(point)
    }

    fn visibility_between(&self, from: Vec3, to: Vec3) -> P::Share {
        (**self).visibility_between(from, to)
    }
}

/// Tells which share of a light reaches a point of a surface.
pub trait SurfaceShadow: Sync {
    /// The share of the light, 0 to 1 per colour, that reaches `point` unblocked. The point is
    /// on a surface with the unit `normal`, which points to the side of the light.
    fn visibility(&self, point: Vec3, normal: Vec3) -> Vec3;
}

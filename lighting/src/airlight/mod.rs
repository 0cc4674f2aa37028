//! How much light arrives from a part of an eye ray.
//!
//! The airlight of the interval `[a, b]` of a ray, for one light, is
//!
//! ```text
//! L[a, b] = ∫_a^b σ_s p(cos θ) I exp(−σ_t (x + d)) / d² dx        (point light)
//! L[a, b] = ∫_a^b σ_s p(cos θ) E exp(−σ_t (x + l)) dx             (sun)
//! ```
//!
//! with `d` the distance to the light and `l` the way of sunlight inside the
//! medium; see [`LightPath`].

mod analytic;
mod cookie;
mod directional;
mod equi_angular;
mod lamp;
mod midpoint;
mod quadrature;

pub use analytic::Analytic;
pub use directional::directional;
pub use equi_angular::EquiAngular;
pub use midpoint::Midpoint;
pub use quadrature::Quadrature;

#[cfg(feature = "shadow-map")]
pub(crate) use directional::mean_exponential;
pub(crate) use midpoint::far_end;

use glam::Vec3;

use crate::{Interval, LightPath};

/// Integrates the light that is scattered towards the eye.
pub trait AirlightEvaluator: Sync {
    /// Radiance that reaches the eye from `interval` of the path, which lies
    /// within `path.span()`, if all of it is lit. Never NaN; +∞ for an
    /// interval that contains a point light (see
    /// [`LightPath::off_the_light`]).
    fn radiance(&self, path: &LightPath<'_>, interval: Interval) -> Vec3;

    /// Appends the radiance of each part to `radiances`: what
    /// [`radiance`](AirlightEvaluator::radiance) is to rounding, sooner where there are
    /// many. The paths have one light and one medium; a part is the number of its path
    /// and the interval. What the others are changes no bit of one.
    fn radiances(
        &self,
        paths: &[LightPath<'_>],
        parts: &[(usize, Interval)],
        radiances: &mut Vec<Vec3>,
    ) {
        let each = |&(path, interval): &(usize, Interval)| self.radiance(&paths[path], interval);
        radiances.extend(parts.iter().map(each));
    }
}

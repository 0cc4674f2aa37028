//! One sample per interval: what a classical march does.

use glam::Vec3;

use super::AirlightEvaluator;
use crate::scene::Medium;
use crate::{Emitter, Interval, LightPath};

/// The integrand at the middle of the interval times its length.
///
/// Together with a march of equal steps this is brute-force ray marching.
/// Second order in the length of the interval for smooth integrands, but it
/// does not see the inverse square of a near light coming: compare
/// [`EquiAngular`](super::EquiAngular) with one node.
///
/// Over an infinite interval there is no middle; it counts as one of ten mean
/// free paths.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Midpoint;

impl AirlightEvaluator for Midpoint {
    fn radiance(&self, path: &LightPath<'_>, interval: Interval) -> Vec3 {
        let start = interval.start;
        let end = interval.end.min(start + far_end(path.medium()));
        if !(start < end) {
            return Vec3::ZERO;
        }
        let x = start + 0.5 * (end - start);
        let inverse_square = match path.emitter() {
            Emitter::Directional(_) => 1.0,
            Emitter::Point(_) => {
                let s = x - path.foot();
                1.0 / (s * s + path.h() * path.h())
            }
        };
        path.source(x) * (inverse_square * (end - start))
    }
}

/// Distance after which a ray to the sky is cut off by methods that need an
/// end: ten mean free paths of the thinnest channel that scatters, where
/// 4.5e-5 of the light of a sun is left.
pub(crate) fn far_end(medium: &Medium) -> f32 {
    10.0 / medium.sigma_t().min_element().max(f32::MIN_POSITIVE)
}

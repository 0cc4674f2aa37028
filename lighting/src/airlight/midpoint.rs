//! One sample per interval, as a classical march takes it.

use glam::Vec3;

use super::AirlightEvaluator;
use super::directional::midpoints;
use crate::path::{Parts, in_lanes};
use crate::scene::Medium;
use crate::{Emitter, Interval, LightPath};

/// The integrand at the middle of the interval, times the interval's length.
///
/// Together with a march of equal steps this is brute-force ray marching. It is of second order
/// in the length of the interval for smooth integrands, but inaccurate close to a light, where
/// the inverse square varies within a step: compare [`EquiAngular`](super::EquiAngular) with
/// one node.
///
/// An infinite interval has no middle; it counts as one that ends after ten mean free paths.
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

    /// Evaluates eight intervals at a time.
    fn radiances(
        &self,
        paths: &[LightPath<'_>],
        parts: &[(usize, Interval)],
        radiances: &mut Vec<Vec3>,
    ) {
        let Some(first) = paths.first() else {
            return;
        };
        let longest = far_end(first.medium());
        let point = match first.emitter() {
            Emitter::Directional(sun) => {
                return midpoints(sun, paths, parts, longest, radiances);
            }
            Emitter::Point(point) => point,
        };
        let mut clipped = Vec::with_capacity(parts.len());
        for (i, (path, Interval { start, end })) in (radiances.len()..).zip(parts) {
            let end = end.min(start + longest);
            if *start < end {
                clipped.push((i, (&paths[*path], Interval::new(*start, end))));
            }
        }
        radiances.resize(radiances.len() + parts.len(), Vec3::ZERO);
        for (some, eight) in in_lanes(&clipped) {
            let lanes = Parts::new(point, eight);
            let [start, end] = lanes.ends();
            let x = start + 0.5 * (end - start);
            let weight = (end - start) / lanes.distances_squared(x);
            let [red, green, blue] = lanes.sources(x).map(|source| (source * weight).to_array());
            for (lane, (i, _)) in some.iter().enumerate() {
                radiances[*i] = Vec3::new(red[lane], green[lane], blue[lane]);
            }
        }
    }
}

/// The distance at which methods that need an end cut off a ray to the sky: ten mean free paths
/// of the thinnest channel that scatters, behind which 4.5e-5 of the light of a sun is left.
///
/// Channels that do not scatter are ignored, however clear they are, because no light comes
/// from them. If no channel scatters the distance is 0. It is at most 1e16 m, because a
/// coefficient above 0 is at least 1e-15 / m.
pub(crate) fn far_end(medium: &Medium) -> f32 {
    let (scattering, extinction) = (medium.sigma_s().to_array(), medium.sigma_t().to_array());
    let scatters = scattering.iter().zip(extinction).filter(|(s, _)| **s > 0.0);
    let thinnest = scatters.map(|(_, t)| t).fold(f32::INFINITY, f32::min);
    10.0 / thinnest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::PhaseFunction;

    #[test]
    fn the_far_end_is_that_of_channels_that_scatter_and_always_finite() {
        let end = |sigma_s: [f32; 3], sigma_a: [f32; 3]| {
            let medium = Medium::new(sigma_s, sigma_a, PhaseFunction::Isotropic);
            far_end(&medium.unwrap())
        };
        assert_eq!(end([0.5, 0.25, 1.0], [0.0; 3]), 40.0);
        assert_eq!(end([0.5, 0.0, 0.0], [0.0; 3]), 20.0);
        assert_eq!(end([0.5, 0.0, 1.0], [0.5, 0.01, 1.5]), 10.0);
        assert_eq!(end([0.0; 3], [0.0; 3]), 0.0);
        assert_eq!(end([0.0; 3], [1.0, 0.0, 2.0]), 0.0);
        let longest = end([1e-15, 0.0, 0.0], [0.0; 3]);
        assert!(longest > 0.99e16 && longest < f32::INFINITY, "{longest}");
    }
}

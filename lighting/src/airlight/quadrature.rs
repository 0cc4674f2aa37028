//! The quadrature of the crate `airlight`, for any light.

use airlight::{Error, PhaseFunction};
use glam::Vec3;

use super::{AirlightEvaluator, directional};
use crate::{Emitter, Interval, LightPath};

/// Gauss–Legendre quadrature by the pieces of [`airlight::Quadrature`], for
/// any emission and any medium.
///
/// Unlike [`EquiAngular`](super::EquiAngular), whose fixed number of nodes
/// stalls at half a percent beside a lamp and misses what deep fog leaves, it
/// divides an interval where its light changes by scale, so that few nodes
/// serve every ray; see there for its errors. The interval is divided at the
/// [kinks](LightPath::kinks) that it contains as well. The texels of a slide
/// are kinks too, at which it is not. Lights with a pattern are not what the nodes
/// were chosen for: their error is larger than the tolerance says by as much as
/// the pattern varies along a piece. Lights that stand outside of a bounded medium
/// get two nodes more on each piece; where the medium is many mean free paths
/// deep, their error may be larger as well.
///
/// A coloured medium has nodes of its own for each channel. A directional
/// light needs no quadrature: see [`directional`].
#[derive(Debug, Clone, PartialEq)]
pub struct Quadrature {
    rule: airlight::Quadrature<PhaseFunction>,
}

/// Nodes more on each piece if the light stands outside of the medium: the way
/// through the medium is not the distance then.
const OUTSIDE: usize = 2;

impl Quadrature {
    /// With `nodes` nodes per piece, for media with this phase function.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless there are 1 to 4096 nodes and the parameter
    /// of the phase function is in range.
    pub fn fixed(phase: PhaseFunction, nodes: u32) -> Result<Self, Error> {
        airlight::Quadrature::fixed(phase, nodes).map(|rule| Self { rule })
    }

    /// With as few nodes as keep the relative error below `tolerance`.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless the tolerance is between 1e-6 and 0.1 and
    /// the parameter of the phase function is in range.
    pub fn with_tolerance(phase: PhaseFunction, tolerance: f32) -> Result<Self, Error> {
        airlight::Quadrature::with_tolerance(phase, tolerance).map(|rule| Self { rule })
    }

    /// Where the nodes come from.
    pub fn rule(&self) -> &airlight::Quadrature<PhaseFunction> {
        &self.rule
    }

    /// The radiance of an interval without a kink inside.
    fn smooth(&self, path: &LightPath<'_>, interval: Interval) -> Vec3 {
        if !(interval.start < interval.end) {
            return Vec3::ZERO;
        }
        if path.meets_light(interval) {
            return Vec3::INFINITY;
        }
        let segment = path.part(interval);
        let sigma_t = path.medium().sigma_t();
        let extra = if path.is_immersed() { 0 } else { OUTSIDE };
        let sum = |sigma: f32| {
            self.rule
                .nodes(sigma, &segment, extra)
                .fold(Vec3::ZERO, |sum, node| {
                    sum + node.weight * path.source(interval.start + node.distance)
                })
        };
        let red = sum(sigma_t.x);
        if sigma_t == Vec3::splat(sigma_t.x) {
            red
        } else {
            Vec3::new(red.x, sum(sigma_t.y).y, sum(sigma_t.z).z)
        }
    }
}

impl AirlightEvaluator for Quadrature {
    fn radiance(&self, path: &LightPath<'_>, interval: Interval) -> Vec3 {
        match path.emitter() {
            Emitter::Directional(sun) => directional(path, sun, interval),
            Emitter::Point(_) => path
                .without_kinks(interval)
                .fold(Vec3::ZERO, |sum, piece| sum + self.smooth(path, piece)),
        }
    }
}

//! Gauss–Legendre quadrature in the equi-angular variable.

use airlight::{Error, gauss};
use glam::Vec3;

use super::directional::directionals;
use super::{AirlightEvaluator, directional};
use crate::path::{Arcs, LANES, Lanes, PartOf, Parts, in_lanes};
use crate::scene::PointEmitter;
use crate::{Emitter, Interval, LightPath};

/// Gauss–Legendre quadrature in the equi-angular variable, for any phase
/// function, emission and medium.
///
/// Let `η` be the angle at the light between the foot point and the position. With `s = h tan
/// η` the inverse square cancels, and the integrand is bounded:
///
/// ```text
/// L[a, b] = ∫ σ_s p(−sin η) I exp(−σ_t (x + d)) dη / h
/// ```
///
/// Nodes are placed without forming `η` itself. A position between two ends is their convex
/// combination with weights `sin((1−t) Δη)/d_a` and `sin(t Δη)/d_b`. This keeps its digits for
/// short parts and next to the axis; the limits for a light on the line of the ray (`h = 0`)
/// and for an infinite end are included.
///
/// # Accuracy
///
/// The rule converges spectrally where the integrand is smooth over the interval. Few nodes
/// suffice for optical depths up to about 10 and |g| up to about 0.8. Beyond that the integrand
/// has a narrow peak and needs more nodes: with 16 nodes the error is 9e-4 at optical depth
/// 100.
///
/// The interval is divided at the [kinks](LightPath::kinks) that it contains, and each part has
/// all the nodes. It is not divided at the texels of a cookie, which are kinks too; so
/// convergence falls to second order there. [`Quadrature`](super::Quadrature) does divide at
/// them.
///
/// A directional light needs no quadrature: see [`directional`].
#[derive(Debug, Clone, PartialEq)]
pub struct EquiAngular {
    /// Nodes in (0, 1) with their weights, which sum to 1.
    nodes: Vec<(f32, f32)>,
    /// The same in groups of eight; the last group is filled up with weights of 0.
    groups: Vec<(Lanes, Lanes)>,
}

impl EquiAngular {
    /// A rule with `nodes` nodes per interval.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless there are 1 to 4096 nodes.
    pub fn new(nodes: u32) -> Result<Self, Error> {
        let rule = gauss::Rule::new(nodes)?;
        let single = |(node, weight)| (node as f32, weight as f32);
        let nodes: Vec<_> = rule.iter().map(single).collect();
        let groups = nodes.chunks(LANES).map(|some| {
            let of_lane = |i: usize| some.get(i).copied().unwrap_or((0.5, 0.0));
            let lanes = std::array::from_fn(of_lane);
            let [nodes, weights] = [lanes.map(|(node, _)| node), lanes.map(|(_, weight)| weight)];
            (Lanes::new(nodes), Lanes::new(weights))
        });
        Ok(Self {
            groups: groups.collect(),
            nodes,
        })
    }

    /// Nodes and weights.
    #[cfg(feature = "wgpu")]
    pub(crate) fn rule(&self) -> &[(f32, f32)] {
        &self.nodes
    }

    /// Number of nodes per interval.
    pub fn nodes(&self) -> u32 {
        self.nodes.len() as u32
    }
}

impl AirlightEvaluator for EquiAngular {
    fn radiance(&self, path: &LightPath<'_>, interval: Interval) -> Vec3 {
        match path.emitter() {
            Emitter::Directional(sun) => directional(path, sun, interval),
            Emitter::Point(point) => path
                .without_kinks(interval)
                .filter(|piece| piece.start < piece.end)
                .fold(Vec3::ZERO, |sum, piece| {
                    sum + self.smooth(point, (path, piece))
                }),
        }
    }

    /// Evaluates eight pieces at a time.
    fn radiances(
        &self,
        paths: &[LightPath<'_>],
        parts: &[(usize, Interval)],
        radiances: &mut Vec<Vec3>,
    ) {
        let point = match paths.first().map(LightPath::emitter) {
            None => return,
            Some(Emitter::Directional(sun)) => return directionals(sun, paths, parts, radiances),
            Some(Emitter::Point(point)) => point,
        };
        let first = radiances.len();
        radiances.resize(first + parts.len(), Vec3::ZERO);
        let radiances = &mut radiances[first..];
        let mut pieces = Vec::with_capacity(parts.len());
        for (i, (path, interval)) in parts.iter().enumerate() {
            let path = &paths[*path];
            for piece in path.without_kinks(*interval) {
                if piece.start < piece.end {
                    pieces.push((i, (path, piece)));
                }
            }
        }
        for (pieces, eight) in in_lanes(&pieces) {
            let lights = self.several(point, eight);
            for ((i, _), light) in pieces.iter().zip(lights) {
                radiances[*i] += light;
            }
        }
    }
}

impl EquiAngular {
    /// The radiance of a part that has no kink inside, with eight nodes at a time.
    fn smooth(&self, point: &PointEmitter, part: PartOf<'_, '_>) -> Vec3 {
        let arcs = Arcs::new(Parts::new(point, [part; LANES]));
        let extent = arcs.extent().to_array()[0];
        if extent == f32::INFINITY {
            return Vec3::INFINITY;
        }
        let mut sums = [Lanes::ZERO; 3];
        for (nodes, weights) in &self.groups {
            let sources = arcs.parts().sources(arcs.positions(*nodes));
            for (sum, source) in sums.iter_mut().zip(sources) {
                *sum += *weights * source;
            }
        }
        extent * Vec3::from(sums.map(Lanes::reduce_add))
    }

    /// The radiances of eight such parts.
    fn several(&self, point: &PointEmitter, parts: [PartOf<'_, '_>; LANES]) -> [Vec3; LANES] {
        let arcs = Arcs::new(Parts::new(point, parts));
        let mut sums = [Lanes::ZERO; 3];
        for (node, weight) in &self.nodes {
            let sources = arcs.parts().sources(arcs.positions((*node).into()));
            for (sum, source) in sums.iter_mut().zip(sources) {
                *sum += *weight * source;
            }
        }
        let sums = sums.map(Lanes::to_array);
        let extents = arcs.extent().to_array();
        std::array::from_fn(|i| {
            if extents[i] == f32::INFINITY {
                Vec3::INFINITY
            } else {
                extents[i] * Vec3::from(sums.map(|sum| sum[i]))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ray;
    use crate::scene::{Bounds, Cone, Emission, Medium, PhaseFunction};

    #[test]
    fn the_number_of_nodes_is_limited() {
        assert!(EquiAngular::new(0).is_err() && EquiAngular::new(5000).is_err());
        assert_eq!(EquiAngular::new(7).map(|q| q.nodes()), Ok(7));
    }

    /// Fog so thin that only the inverse square is left, whose integral is
    /// known in closed form, here in f64.
    fn check_thin(light: Vec3, a: f32, b: f32) {
        let medium = Medium::new(Vec3::splat(1e-9), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let lamp = Emitter::point(light, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
        let ray = Ray::new(Vec3::ZERO, Vec3::NEG_Z, f32::INFINITY).unwrap();
        let path = LightPath::new(&ray, &lamp, &medium).unwrap();
        let value = EquiAngular::new(4)
            .unwrap()
            .radiance(&path, Interval::new(a, b));
        let (h, foot) = (f64::from(path.h()), f64::from(path.foot()));
        let (s_a, s_b) = (f64::from(a) - foot, f64::from(b) - foot);
        let along = if b.is_finite() {
            h * h + s_a * s_b
        } else {
            s_a
        };
        let across = if b.is_finite() { h * (s_b - s_a) } else { h };
        let extent = if h == 0.0 {
            1.0 / s_a - if b.is_finite() { 1.0 / s_b } else { 0.0 }
        } else {
            across.atan2(along) / h
        };
        let expected = 1e-9 / (4.0 * std::f64::consts::PI) * extent;
        let error = (f64::from(value.x) / expected - 1.0).abs();
        assert!(error < 3e-6, "{light} [{a}, {b}]: {value} {expected}");
    }

    #[test]
    fn thin_fog_is_the_arctangent_wherever_the_light_is() {
        let inf = f32::INFINITY;
        for light in [
            Vec3::new(1.0, 0.0, -5.0),
            Vec3::new(0.0, 1e-5, -5.0),
            Vec3::new(0.0, 0.0, -5.0),
            Vec3::new(0.0, 1e-12, 5.0),
            Vec3::new(3.0, 0.0, 4.0),
            Vec3::new(1e-6, 0.0, -1e-6),
        ] {
            for (a, b) in [
                (0.0, 1.0),
                (0.5, 0.500_01),
                (0.0, 4.9),
                (5.1, inf),
                (7.0, 9.0),
            ] {
                let holds_light = light.length() == -light.z && (a..=b).contains(&-light.z);
                if !holds_light {
                    check_thin(light, a, b);
                }
            }
        }
    }

    #[test]
    fn kinks_do_not_slow_convergence() {
        let fog = Medium::new(Vec3::splat(0.3), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let bounds = Bounds::new(Vec3::new(-2.0, -1.0, -6.0), Vec3::new(2.0, 1.5, -1.0)).unwrap();
        let cone = Cone {
            inner: 0.3,
            outer: 0.5,
        };
        let spot = Emission::spot(glam::Quat::IDENTITY, cone, None).unwrap();
        let lamp = |position, emission| {
            Emitter::point(position, Vec3::ONE, f32::INFINITY, emission).unwrap()
        };
        let cases = [
            (lamp(Vec3::new(0.1, 0.2, 0.0), spot), fog),
            (
                lamp(Vec3::new(-4.0, 5.0, 1.0), Emission::Isotropic),
                fog.within(bounds),
            ),
        ];
        for (lamp, medium) in &cases {
            let mut most = 0;
            for i in 0..100 {
                let towards = Vec3::new(1.0, 0.01 * i as f32 - 0.4, -0.03 * i as f32);
                let origin = Vec3::new(-3.0, 0.1, -2.0);
                let ray = Ray::new(origin, towards, 9.0).unwrap();
                let Some(path) = LightPath::new(&ray, lamp, medium) else {
                    continue;
                };
                most = most.max(path.kinks().count());
                let value = |n| EquiAngular::new(n).unwrap().radiance(&path, path.span()).x;
                let (few, many) = (value(12), value(800));
                assert!((few / many - 1.0).abs() < 2e-5, "{few} {many} {ray:?}");
            }
            assert!(most >= 2, "{most}");
        }
    }

    #[test]
    fn through_the_light_is_infinite_and_an_empty_interval_is_dark() {
        let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
        let lamp =
            Emitter::point(Vec3::NEG_Z, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
        let ray = Ray::new(Vec3::ZERO, Vec3::NEG_Z, 5.0).unwrap();
        let path = LightPath::new(&ray, &lamp, &medium).unwrap();
        let rule = EquiAngular::new(8).unwrap();
        assert_eq!(
            rule.radiance(&path, Interval::new(0.0, 2.0)),
            Vec3::INFINITY
        );
        assert_eq!(rule.radiance(&path, Interval::new(0.5, 0.5)), Vec3::ZERO);
        let off = path.off_the_light();
        assert!(rule.radiance(&off, Interval::new(0.0, 2.0)).is_finite());
    }
}

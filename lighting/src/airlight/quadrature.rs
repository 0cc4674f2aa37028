//! The quadrature of the crate `airlight`, for any light.

use airlight::quadrature::Node;
use airlight::{Error, PhaseFunction, Segment64};
use glam::{Vec2, Vec3};

use super::{AirlightEvaluator, directional};
use crate::scene::{Emission, PointEmitter};
use crate::{Emitter, Interval, LightPath};

/// Gauss–Legendre quadrature by the pieces of [`airlight::Quadrature`], for
/// any emission and any medium.
///
/// Unlike [`EquiAngular`](super::EquiAngular), whose fixed number of nodes
/// stalls at half a percent beside a lamp and misses what deep fog leaves, it
/// divides an interval where its light changes by scale, so that few nodes
/// serve every ray; see there for its errors. The interval is divided at the
/// [kinks](LightPath::kinks) that it contains as well, and where a light with a
/// pattern has its rims, it gets the nodes that the pattern asks for
/// ([`airlight::Quadrature::nodes_of`]): spotlights and cosines keep the tolerance
/// too, relative to their own light. The texels of a slide are kinks at which the
/// interval is not divided. Lights that stand outside of a bounded medium get two
/// nodes more on each piece; where the medium is many mean free paths deep, their
/// error may be larger.
///
/// On a GPU the cosine between the axis of a spotlight and a direction has an
/// error of about 1e-7, which counts by the difference of the cosines of its
/// cones.
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

    /// The radiance of an interval without a kink inside, of a light that shines
    /// alike in all directions.
    fn smooth(&self, path: &LightPath<'_>, interval: Interval) -> Vec3 {
        if !(interval.start < interval.end) {
            return Vec3::ZERO;
        }
        if path.meets_light(interval) {
            return Vec3::INFINITY;
        }
        let segment = path.part(interval);
        let extra = if path.is_immersed() { 0 } else { OUTSIDE };
        by_channel(path, |sigma| {
            self.rule
                .nodes(sigma, &segment, extra)
                .fold(Vec3::ZERO, |sum, node| {
                    sum + node.weight * path.source(interval.start + node.distance)
                })
        })
    }

    /// The radiance of an interval of a light with a pattern, without a kink of
    /// the way through the medium inside.
    fn patterned(&self, path: &LightPath<'_>, lamp: &Lamp<'_>, interval: Interval) -> Vec3 {
        if !(interval.start < interval.end) {
            return Vec3::ZERO;
        }
        if path.meets_light(interval) {
            return Vec3::INFINITY;
        }
        let segment = lamp.part(path, interval);
        let extra = if path.is_immersed() { 0 } else { OUTSIDE };
        by_channel(path, |sigma| {
            self.rule
                .nodes_of(sigma, &segment, &lamp.emission, extra)
                .fold(Vec3::ZERO, |sum, node| {
                    sum + node.weight * lamp.source(path, interval.start, node)
                })
        })
    }
}

/// A colour whose channels have nodes of their own where their extinctions
/// differ.
fn by_channel(path: &LightPath<'_>, sum: impl Fn(f32) -> Vec3) -> Vec3 {
    let sigma_t = path.medium().sigma_t();
    let red = sum(sigma_t.x);
    if sigma_t == Vec3::splat(sigma_t.x) {
        red
    } else {
        Vec3::new(red.x, sum(sigma_t.y).y, sum(sigma_t.z).z)
    }
}

/// A light with a pattern as a ray sees it, in double precision: from afar a
/// narrow cone is a small difference of large lengths.
#[derive(Debug)]
struct Lamp<'a> {
    point: &'a PointEmitter,
    emission: airlight::Emission,
    /// Distance of the foot point from the eye, and between light and ray.
    foot: f64,
    h: f64,
}

impl<'a> Lamp<'a> {
    /// `None` for a light that shines alike in all directions.
    fn new(path: &LightPath<'_>, point: &'a PointEmitter) -> Option<Self> {
        let axis = match point.emission() {
            Emission::Isotropic => return None,
            Emission::Cosine { normal } => *normal,
            Emission::Spot(spot) => spot.axis(),
        };
        let axis = axis.as_dvec3().normalize();
        let direction = path.ray().direction().as_dvec3().normalize();
        let to_light = point.position().as_dvec3() - path.ray().origin().as_dvec3();
        let foot = to_light.dot(direction);
        let h = to_light.cross(direction).length();
        let to_foot = (direction * foot - to_light)
            .try_normalize()
            .unwrap_or_else(|| path.from_light(0.0).0.as_dvec3());
        let (along, across) = (axis.dot(direction), axis.dot(to_foot));
        let emission = match point.emission() {
            Emission::Spot(spot) => {
                let (inner, outer) = (spot.cos_inner().into(), spot.cos_outer().into());
                airlight::Emission::spot(along, across, inner, outer)
            }
            _ => airlight::Emission::cosine(along, across),
        };
        Some(Self {
            point,
            emission: emission.expect("parts of a unit vector, and cosines in order"),
            foot,
            // Rays through the light are moved off it.
            h: if path.h() > 1.001 * h as f32 {
                path.h().into()
            } else {
                h
            },
        })
    }

    fn part(&self, path: &LightPath<'_>, interval: Interval) -> Segment64 {
        let start = f64::from(interval.start);
        Segment64 {
            x: start - f64::from(path.entry()),
            s: start - self.foot,
            h: self.h,
            length: f64::from(interval.end) - start,
        }
    }

    /// [`LightPath::source`] at a node behind `start` but for the emission, which
    /// is a factor of its weight, up to the slide.
    fn source(&self, path: &LightPath<'_>, start: f32, node: Node) -> Vec3 {
        let medium = path.medium();
        let x = start + node.distance;
        let (direction, d) = path.from_light(x - path.foot());
        let light_leg = medium.length_inside(path.ray().at(x), -direction, d);
        let optical_length = x - path.entry() + light_leg;
        let transmittance = (-medium.sigma_t() * optical_length).exp();
        let light = medium.phase().value(node.angle) * self.point.intensity();
        medium.sigma_s() * light * self.slide(direction) * transmittance
    }

    /// What the slide of a spotlight lets through.
    fn slide(&self, direction: Vec3) -> Vec3 {
        let Emission::Spot(spot) = self.point.emission() else {
            return Vec3::ONE;
        };
        let Some(texture) = spot.texture() else {
            return Vec3::ONE;
        };
        let local = spot.rotation().inverse() * direction;
        let plane = Vec2::new(local.x, -local.y) / (-local.z * spot.tan_outer());
        texture.clamp(0.5 + 0.5 * plane)
    }
}

impl AirlightEvaluator for Quadrature {
    fn radiance(&self, path: &LightPath<'_>, interval: Interval) -> Vec3 {
        let point = match path.emitter() {
            Emitter::Directional(sun) => return directional(path, sun, interval),
            Emitter::Point(point) => point,
        };
        match Lamp::new(path, point) {
            None => path
                .without_kinks(interval)
                .fold(Vec3::ZERO, |sum, piece| sum + self.smooth(path, piece)),
            // All kinks are rims of the light then.
            Some(lamp) if path.is_immersed() => self.patterned(path, &lamp, interval),
            Some(lamp) => path.without_kinks(interval).fold(Vec3::ZERO, |sum, piece| {
                sum + self.patterned(path, &lamp, piece)
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Quat};

    use super::*;
    use crate::Ray;
    use crate::scene::{Bounds, Cone, Medium};

    /// The midpoint rule in the angle at the light, in f64 from the definition,
    /// between the ends of what the path says is lit.
    fn sum(path: &LightPath<'_>, light: DVec3, emission: &crate::scene::Emission) -> f64 {
        let (medium, ray) = (path.medium(), path.ray());
        let sigma_t = f64::from(medium.sigma_t().x);
        let direction = ray.direction().as_dvec3().normalize();
        let to_light = light - ray.origin().as_dvec3();
        let foot = to_light.dot(direction);
        let h = to_light.cross(direction).length();
        let span = path.span();
        let [from, to] = [span.start, span.end].map(|x| ((f64::from(x) - foot) / h).atan());
        let steps = 40_000;
        let step = (to - from) / f64::from(steps);
        let total: f64 = (0..steps)
            .map(|i| {
                let s = h * (from + (f64::from(i) + 0.5) * step).tan();
                let x = s + foot;
                let offset = direction * x - to_light;
                let d = offset.length();
                let inside = match medium.bounds() {
                    None => d,
                    Some(bounds) => {
                        // From the face that the light enters by.
                        let [low, high] = [bounds.min(), bounds.max()].map(|v| v.as_dvec3());
                        let faces = [(low - light) / offset, (high - light) / offset];
                        (1.0 - faces[0].min(faces[1]).max_element().max(0.0)) * d
                    }
                };
                let factor = match emission {
                    crate::scene::Emission::Spot(spot) => {
                        let cos = spot.axis().as_dvec3().normalize().dot(offset) / d;
                        let (inner, outer) =
                            (f64::from(spot.cos_inner()), f64::from(spot.cos_outer()));
                        let edge = (cos - outer) / (inner - outer).max(0.001);
                        edge.clamp(0.0, 1.0).powi(2)
                    }
                    crate::scene::Emission::Cosine { normal } => {
                        (normal.as_dvec3().normalize().dot(offset) / d).max(0.0)
                    }
                    crate::scene::Emission::Isotropic => 1.0,
                };
                let depth = sigma_t * (x - f64::from(path.entry()) + inside);
                factor * (-depth).exp() * step / h
            })
            .sum();
        f64::from(medium.sigma_s().x) / (4.0 * std::f64::consts::PI) * total
    }

    /// A light from the side, seen from 5 m away by rays across its beam and
    /// beside it, one of them along the middle.
    #[test]
    fn narrow_and_wide_beams_keep_every_tolerance() {
        let open = Medium::new(
            Vec3::splat(0.05),
            Vec3::splat(0.01),
            PhaseFunction::Isotropic,
        )
        .unwrap();
        let bounds = Bounds::new(Vec3::new(-2.0, -9.0, -4.0), Vec3::new(9.0, 9.0, 9.0)).unwrap();
        let light = Vec3::new(-3.0, 0.25, -0.5);
        let turn = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
        let mut compared = 0;
        for medium in [open, open.within(bounds)] {
            for degrees in [0.5_f32, 2.0, 8.0, 30.0, 60.0, 89.5] {
                for share in [0.0, 0.5, 0.98] {
                    let outer = degrees.to_radians();
                    let inner = share * outer;
                    let spot =
                        crate::scene::Emission::spot(turn, Cone { inner, outer }, None).unwrap();
                    let normal = turn * Vec3::NEG_Z;
                    for emission in [spot, crate::scene::Emission::Cosine { normal }] {
                        let lamp =
                            Emitter::point(light, Vec3::ONE, f32::INFINITY, emission.clone())
                                .unwrap();
                        for row in 0..9 {
                            let rise =
                                0.3 * (f64::from(row) - 4.0) * f64::from(outer).tan().min(2.0);
                            let target = Vec3::new(-1.0, 0.25 + rise as f32, -0.5);
                            let origin = Vec3::new(1.0, 0.0, 4.5);
                            let ray = Ray::new(origin, target - origin, 30.0).unwrap();
                            let Some(path) = LightPath::new(&ray, &lamp, &medium) else {
                                continue;
                            };
                            let truth = sum(&path, light.as_dvec3(), &emission);
                            if truth < 1e-12 {
                                continue;
                            }
                            for tolerance in [1e-2, 1e-3, 1e-4, 1e-5] {
                                let rule =
                                    Quadrature::with_tolerance(PhaseFunction::Isotropic, tolerance);
                                let value = rule.unwrap().radiance(&path, path.span()).x;
                                let error = (f64::from(value) / truth - 1.0).abs();
                                assert!(
                                    error <= f64::from(tolerance),
                                    "{degrees} {share} {row} {tolerance}: {value} {truth}"
                                );
                                compared += 1;
                            }
                        }
                    }
                }
            }
        }
        assert!(compared > 1000, "{compared}");
    }
}

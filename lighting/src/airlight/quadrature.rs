//! The quadrature of the crate `airlight`, for any light.

use airlight::{Error, PhaseFunction};
use glam::Vec3;

use super::directional::directionals;
use super::lamp::Lamp;
use super::{AirlightEvaluator, cookie, directional};
use crate::{Emitter, Interval, LightPath};

/// Gauss–Legendre quadrature with the pieces of [`airlight::Quadrature`], for any emission and
/// any medium.
///
/// [`EquiAngular`](super::EquiAngular) has a fixed number of nodes, stalls at half a percent
/// beside a lamp, and misses what deep fog leaves. This quadrature divides an interval where
/// its light changes by scale, so that few nodes serve every ray; see [`airlight::Quadrature`]
/// for its errors.
///
/// * The interval is also divided at the [kinks](LightPath::kinks) that it contains.
/// * Next to the rims of a light with a pattern it gets as many nodes as the pattern needs
///   ([`airlight::Quadrature::nodes_of`]). So spotlights and cosine emitters keep the tolerance
///   too, relative to their own light.
/// * A cookie is a bilinear blend between the centres of its texels. The interval is divided at
///   the lines through these centres, and the tolerance is relative to the light without the
///   cookie. Two nodes on each texel mostly suffice, and the time grows with the number of
///   texels that the image of the ray crosses, up to
///   [`MOST_COOKIE_LINES`](crate::scene::MOST_COOKIE_LINES) lines. Rays that cross more use
///   coarser mip levels. This changes their light by up to 8e-3 of the light without the cookie
///   for noise of one texel, by up to 8e-5 for patterns of 32 texels, and never by more than
///   the levels differ from the cookie.
/// * Lights outside of a bounded medium get two more nodes on each piece. Where the medium is
///   many mean free paths deep, their error may exceed the tolerance.
/// * A coloured medium has nodes of its own for each channel.
/// * A directional light needs no quadrature: see [`directional`].
///
/// On a GPU, directions have an error of about 1e-7, which matters in proportion to how narrow
/// the cone of a spotlight is.
#[derive(Debug, Clone, PartialEq)]
pub struct Quadrature {
    rule: airlight::Quadrature<PhaseFunction>,
}

/// Additional nodes on each piece if the light is outside of the medium: the length in the
/// medium then differs from the distance to the light, and its variation needs them.
const OUTSIDE: usize = 2;

impl Quadrature {
    /// A rule with `nodes` nodes per piece, for media with this phase function.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless there are 1 to 4096 nodes and the parameter
    /// of the phase function is in range.
    pub fn fixed(phase: PhaseFunction, nodes: u32) -> Result<Self, Error> {
        airlight::Quadrature::fixed(phase, nodes).map(|rule| Self { rule })
    }

    /// A rule with as few nodes as keep the relative error below `tolerance`.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless the tolerance is between 1e-6 and 0.1 and
    /// the parameter of the phase function is in range.
    pub fn with_tolerance(phase: PhaseFunction, tolerance: f32) -> Result<Self, Error> {
        airlight::Quadrature::with_tolerance(phase, tolerance).map(|rule| Self { rule })
    }

    /// The rule that the nodes come from.
    pub fn rule(&self) -> &airlight::Quadrature<PhaseFunction> {
        &self.rule
    }

    /// The radiance of an interval that has no kink inside, for a light that shines alike in
    /// all directions.
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

    /// The radiance of an interval for a light with a pattern, if the length in the medium has
    /// no kink inside.
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

/// The sum for each channel; channels with the same extinction share their nodes.
fn by_channel(path: &LightPath<'_>, sum: impl Fn(f32) -> Vec3) -> Vec3 {
    let sigma_t = path.medium().sigma_t();
    let red = sum(sigma_t.x);
    if sigma_t == Vec3::splat(sigma_t.x) {
        red
    } else {
        Vec3::new(red.x, sum(sigma_t.y).y, sum(sigma_t.z).z)
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
            Some(lamp) if lamp.cookie().is_some() => {
                path.without_kinks(interval).fold(Vec3::ZERO, |sum, piece| {
                    sum + cookie::radiance(&self.rule, path, &lamp, piece)
                })
            }
            // All kinks are then rims of the light.
            Some(lamp) if path.is_immersed() => self.patterned(path, &lamp, interval),
            Some(lamp) => path.without_kinks(interval).fold(Vec3::ZERO, |sum, piece| {
                sum + self.patterned(path, &lamp, piece)
            }),
        }
    }

    /// Evaluates eight parts of a directional light at a time.
    fn radiances(
        &self,
        paths: &[LightPath<'_>],
        parts: &[(usize, Interval)],
        radiances: &mut Vec<Vec3>,
    ) {
        if let Some(Emitter::Directional(sun)) = paths.first().map(LightPath::emitter) {
            return directionals(sun, paths, parts, radiances);
        }
        let each = |&(path, interval): &(usize, Interval)| self.radiance(&paths[path], interval);
        radiances.extend(parts.iter().map(each));
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
                        let outer = 1.0 - f64::from(spot.outer_versine());
                        let edge = (cos - outer) / f64::from(spot.rim());
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

//! Several parts of eye rays at a time, and the integrand of their airlight.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;
use wide::{CmpEq, CmpGe, CmpGt, CmpLe, f32x8};

use super::LightPath;
use crate::Interval;
use crate::scene::{Emission, PhaseFunction, PointEmitter};

/// Number of lanes.
pub(crate) const LANES: usize = 8;

/// A number for each lane.
pub(crate) type Lanes = f32x8;

/// A path and a part of it.
pub(crate) type PartOf<'p, 'a> = (&'p LightPath<'a>, Interval);

/// Eight parts with their indices at a time, and the same parts for the lanes. The last group
/// is filled up with copies of its first part.
pub(crate) fn in_lanes<'s, 'p, 'a>(
    parts: &'s [(usize, PartOf<'p, 'a>)],
) -> impl Iterator<Item = (&'s [(usize, PartOf<'p, 'a>)], [PartOf<'p, 'a>; LANES])> {
    parts.chunks(LANES).map(|some| {
        let part = |i: usize| some.get(i).unwrap_or(&some[0]).1;
        (some, std::array::from_fn(part))
    })
}

/// Parts of paths, one in each lane, and the light of a point light along them. All paths have
/// the same light and medium.
pub(crate) struct Parts<'p, 'a> {
    parts: [PartOf<'p, 'a>; LANES],
    point: &'a PointEmitter,
    start: Lanes,
    end: Lanes,
    foot: Lanes,
    h: Lanes,
    entry: Lanes,
    /// Cosines of the light's normal, if it has one, with the ray and with the direction to the
    /// foot point.
    cosine: [Lanes; 2],
}

impl<'p, 'a> Parts<'p, 'a> {
    pub(crate) fn new(point: &'a PointEmitter, parts: [PartOf<'p, 'a>; LANES]) -> Self {
        let normal = match point.emission() {
            Emission::Cosine { normal } => *normal,
            _ => Vec3::ZERO,
        };
        let mut columns = [[0.0; LANES]; 7];
        for (i, (path, interval)) in parts.iter().enumerate() {
            let row = [
                interval.start,
                interval.end,
                path.foot,
                path.h,
                path.entry,
                normal.dot(path.ray.direction()),
                normal.dot(path.to_foot),
            ];
            for (column, value) in columns.iter_mut().zip(row) {
                column[i] = value;
            }
        }
        let [start, end, foot, h, entry, along_normal, foot_along_normal] = columns.map(Lanes::new);
        Self {
            parts,
            point,
            start,
            end,
            foot,
            h,
            entry,
            cosine: [along_normal, foot_along_normal],
        }
    }

    /// Distances from the eye at which the parts begin and end.
    pub(crate) fn ends(&self) -> [Lanes; 2] {
        [self.start, self.end]
    }

    /// Squared distances of positions from the light.
    pub(crate) fn distances_squared(&self, x: Lanes) -> Lanes {
        let s = x - self.foot;
        s * s + self.h * self.h
    }

    /// [`LightPath::source`] at a position in each lane, by channel. It agrees to 2e-6 for
    /// optical lengths up to 87, and is 0 beyond.
    pub(crate) fn sources(&self, x: Lanes) -> [Lanes; 3] {
        let s = x - self.foot;
        let d = self.distances_squared(x).sqrt();
        let first = self.parts[0].0;
        let medium = first.medium();
        let phase = Angles::from_foot(s, self.h, d).phase(medium.phase());
        let leg = if first.is_immersed() {
            d
        } else {
            lane_by_lane([x, d], |i, [x, d]| {
                let path = self.parts[i].0;
                let to_light = -path.from_light(x - path.foot()).0;
                medium.length_inside(path.ray().at(x), to_light, d)
            })
        };
        let window = if self.point.fades() {
            lane_by_lane([d], |_, [d]| self.point.window_inside(d))
        } else {
            Lanes::ONE
        };
        let way = (x - self.entry) + leg;
        let (sigma_t, sigma_s) = (medium.sigma_t(), medium.sigma_s());
        let transmittance = |sigma: f32| (-sigma * way).exp();
        let mut through = transmittance(sigma_t.x);
        let mut light = self.intensities(s, d);
        for (channel, light) in light.iter_mut().enumerate() {
            // Grey media are common, and exponentials are most of the work.
            if channel > 0 && sigma_t[channel] != sigma_t[channel - 1] {
                through = transmittance(sigma_t[channel]);
            }
            *light *= sigma_s[channel] * (phase * window) * through;
        }
        light
    }

    /// The intensities towards positions behind the foot points; `d` are their distances from
    /// the light.
    fn intensities(&self, s: Lanes, d: Lanes) -> [Lanes; 3] {
        let intensity = self.point.intensity().to_array().map(Lanes::from);
        match self.point.emission() {
            Emission::Isotropic => intensity,
            Emission::Cosine { .. } => {
                let [along, across] = self.cosine;
                let cos = ((s * along + self.h * across) / d).fast_max(Lanes::ZERO);
                intensity.map(|channel| channel * cos)
            }
            emission @ Emission::Spot(_) => {
                let s = s.to_array();
                let factors: [_; LANES] =
                    std::array::from_fn(|i| emission.factor(self.parts[i].0.from_light(s[i]).0));
                std::array::from_fn(|channel| {
                    intensity[channel] * Lanes::new(factors.map(|factor| factor[channel]))
                })
            }
        }
    }
}

/// Parts of paths as arcs seen from a point light, one in each lane, as `Arc` is for a single
/// part.
pub(crate) struct Arcs<'p, 'a> {
    parts: Parts<'p, 'a>,
    /// Distances of the ends from the light.
    d_a: Lanes,
    d_b: Lanes,
    /// The angle between the ends at the light, and π minus this angle.
    angle: Lanes,
    supplement: Lanes,
    /// The angle over h, 1/m.
    extent: Lanes,
}

impl<'p, 'a> Arcs<'p, 'a> {
    /// The arcs of parts, which must not be empty.
    pub(crate) fn new(parts: Parts<'p, 'a>) -> Self {
        let Parts {
            start,
            end,
            foot,
            h,
            ..
        } = parts;
        let endless = end.cmp_eq(f32::INFINITY);
        let (s_a, s_b) = (start - foot, endless.blend(Lanes::ZERO, end - foot));
        let (d_a, d_b) = (length(s_a, h), endless.blend(end, length(s_b, h)));
        // The tangent of the angle is across / along. For an infinite end, both are divided by
        // the distance of the end.
        let across = h * endless.blend(Lanes::ONE, s_b - s_a);
        let along = endless.blend(s_a, h * h + s_a * s_b);
        // Of the angle and its supplement, the smaller one has all its digits.
        let smaller = across.atan2(along.abs());
        let larger = PI - smaller;
        let ahead = along.cmp_ge(0.0);
        let (angle, supplement) = (ahead.blend(smaller, larger), ahead.blend(larger, smaller));
        // A series for angle / h, which is finite for h = 0.
        let ratio = across / along;
        let per_h = endless.blend(1.0 / s_a, (end - start) / along);
        let series = per_h * (1.0 - ratio * ratio * (1.0 / 3.0));
        let is_thin = along.cmp_gt(0.0) & across.cmp_le(1e-4 * along);
        let beside = h.cmp_gt(0.0).blend(angle / h, f32::INFINITY.into());
        Self {
            extent: is_thin.blend(series, beside),
            parts,
            d_a,
            d_b,
            angle,
            supplement,
        }
    }

    /// The parts.
    pub(crate) fn parts(&self) -> &Parts<'p, 'a> {
        &self.parts
    }

    /// `Δη / h = ∫ dx / d²`, 1/m; infinite if the light is on the part.
    pub(crate) fn extent(&self) -> Lanes {
        self.extent
    }

    /// The distances from the eye at the fraction `t` in (0, 1) of each angle.
    pub(crate) fn positions(&self, t: Lanes) -> Lanes {
        let rest = 1.0 - t;
        let is_wide = self.angle.cmp_gt(1e-3);
        // Sines, or for small angles the limit of their ratio.
        let from_a = is_wide.blend(self.sines(rest, t), rest);
        let from_b = is_wide.blend(self.sines(t, rest), t);
        let (weight_a, weight_b) = (from_a * self.d_b, from_b * self.d_a);
        let x = self.parts.start
            + (self.parts.end - self.parts.start) * (weight_b / (weight_a + weight_b));
        let endless = self.parts.start + self.d_a * (from_b / from_a);
        let x = x.fast_max(self.parts.start).fast_min(self.parts.end);
        (self.parts.end.cmp_eq(f32::INFINITY)).blend(endless, x)
    }

    /// `sin(part Δη)`, where `part` and `rest` add up to 1.
    fn sines(&self, part: Lanes, rest: Lanes) -> Lanes {
        let angle = part * self.angle;
        let other = self.supplement + rest * self.angle;
        sine(angle.cmp_gt(FRAC_PI_2).blend(other, angle))
    }
}

/// [`ScatteringAngle`](crate::scene::ScatteringAngle)s.
struct Angles {
    one_minus_cos: Lanes,
    one_plus_cos: Lanes,
}

impl Angles {
    /// Angles of light from `d` away, at `s` behind the foot point of a light that is `h`
    /// beside the ray.
    fn from_foot(s: Lanes, h: Lanes, d: Lanes) -> Self {
        let large = 1.0 + s.abs() / d;
        let sine = h / d;
        let small = sine * sine / large;
        let behind = s.cmp_ge(0.0);
        Self {
            one_minus_cos: behind.blend(large, small),
            one_plus_cos: behind.blend(small, large),
        }
    }

    /// [`PhaseFunction::value`].
    fn phase(&self, phase: PhaseFunction) -> Lanes {
        let of = |share: f32| share / PI;
        match phase {
            PhaseFunction::Isotropic => of(0.25).into(),
            PhaseFunction::HenyeyGreenstein { g } => of(0.25) * self.henyey_greenstein(g),
            PhaseFunction::Rayleigh => of(0.1875) * self.rayleigh(),
            PhaseFunction::Schlick { k } => {
                let distance = if k >= 0.0 {
                    (1.0 - k) + k * self.one_minus_cos
                } else {
                    (1.0 + k) - k * self.one_plus_cos
                };
                of(0.25) * ((1.0 - k) * (1.0 + k)) / (distance * distance)
            }
            PhaseFunction::CornetteShanks { g } => {
                of(0.375) / (2.0 + g * g) * self.rayleigh() * self.henyey_greenstein(g)
            }
            PhaseFunction::DoubleHenyeyGreenstein { g, weight } => {
                let [first, second] = g.map(|g| self.henyey_greenstein(g));
                of(0.25) * (weight * first + (1.0 - weight) * second)
            }
            PhaseFunction::HenyeyGreensteinDraine {
                g,
                draine_g,
                alpha,
                weight,
            } => {
                let norm = 1.0 + alpha * (1.0 + 2.0 * draine_g * draine_g) / 3.0;
                let across = (1.0 + alpha * (self.rayleigh() - 1.0)) / norm;
                let draine = across * self.henyey_greenstein(draine_g);
                of(0.25) * ((1.0 - weight) * self.henyey_greenstein(g) + weight * draine)
            }
        }
    }

    /// `1 + cos² θ`.
    fn rayleigh(&self) -> Lanes {
        let cos = 0.5 * (self.one_plus_cos - self.one_minus_cos);
        1.0 + cos * cos
    }

    /// `(1 − g²) / (1 + g² − 2 g cos θ)^{3/2}`.
    fn henyey_greenstein(&self, g: f32) -> Lanes {
        let distance2 = if g >= 0.0 {
            (1.0 - g) * (1.0 - g) + 2.0 * g * self.one_minus_cos
        } else {
            (1.0 + g) * (1.0 + g) - 2.0 * g * self.one_plus_cos
        };
        ((1.0 - g) * (1.0 + g)) / (distance2 * distance2.sqrt())
    }
}

/// The sine of angles from 0 to π/2 with a relative error of 2e-7: its power series without
/// x¹⁵/15! < 7e-10 and later terms.
fn sine(x: Lanes) -> Lanes {
    let z = x * x;
    let p = 1.0 / 362_880.0 - z * (1.0 / 39_916_800.0 - z * (1.0 / 6_227_020_800.0));
    let p = 1.0 / 6.0 - z * (1.0 / 120.0 - z * (1.0 / 5040.0 - z * p));
    x - x * z * p
}

/// Lengths of vectors without underflow.
fn length(x: Lanes, y: Lanes) -> Lanes {
    let (x, y) = (x.abs(), y.abs());
    let (small, large) = (x.fast_min(y), x.fast_max(y));
    let ratio = small / large;
    let length = large * (1.0 + ratio * ratio).sqrt();
    large.cmp_gt(0.0).blend(length, Lanes::ZERO)
}

/// Evaluates `f` for each lane in turn, for functions without vector instructions.
fn lane_by_lane<const N: usize>(values: [Lanes; N], f: impl Fn(usize, [f32; N]) -> f32) -> Lanes {
    let values = values.map(Lanes::to_array);
    Lanes::new(std::array::from_fn(|i| f(i, values.map(|lanes| lanes[i]))))
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::Ray;
    use crate::path::Arc;
    use crate::scene::{Bounds, Cone, Medium};

    #[test]
    fn sines_keep_their_digits() {
        for i in 0..10_000 {
            let x = std::f32::consts::FRAC_PI_2 * (i as f32 + 0.5) / 1e4;
            let (found, truth) = (sine(x.into()).to_array()[0], f64::from(x).sin());
            assert!(
                (f64::from(found) / truth - 1.0).abs() < 2e-7,
                "{x}: {found}"
            );
        }
    }

    /// Lights of every kind, in every kind of medium: eight positions at once are what
    /// each is alone.
    #[test]
    fn positions_at_once_are_positions_one_by_one() {
        let bounds = Bounds::new(Vec3::new(-2.0, -1.0, -6.0), Vec3::new(2.0, 1.5, -1.0)).unwrap();
        let sigma = [Vec3::new(0.1, 0.1, 0.4), Vec3::splat(3.0)];
        let phases = [
            PhaseFunction::Isotropic,
            PhaseFunction::HenyeyGreenstein { g: 0.7 },
            PhaseFunction::HenyeyGreenstein { g: -0.9 },
            PhaseFunction::Rayleigh,
            PhaseFunction::Schlick { k: 0.8 },
            PhaseFunction::Schlick { k: -0.5 },
            PhaseFunction::CornetteShanks { g: 0.6 },
            PhaseFunction::DoubleHenyeyGreenstein {
                g: [0.8, -0.4],
                weight: 0.7,
            },
            PhaseFunction::droplets(10.0).unwrap(),
        ];
        let emissions = [
            Emission::Isotropic,
            Emission::Cosine {
                normal: Vec3::NEG_Y,
            },
            Emission::spot(
                Quat::from_rotation_x(-1.2),
                Cone {
                    inner: 0.3,
                    outer: 0.9,
                },
                None,
            )
            .unwrap(),
        ];
        let mut compared = 0;
        for (sigma, phase, emission) in sigma
            .into_iter()
            .flat_map(|sigma| phases.map(|phase| (sigma, phase)))
            .flat_map(|(sigma, phase)| emissions.clone().map(|emission| (sigma, phase, emission)))
        {
            let open = Medium::new(sigma, 0.1 * sigma, phase).unwrap();
            for (medium, range) in [(open, f32::INFINITY), (open.within(bounds), 7.0)] {
                let position = Vec3::new(0.3, 2.0, -3.5);
                let lamp = crate::Emitter::point(
                    position,
                    Vec3::new(1.0, 2.0, 3.0),
                    range,
                    emission.clone(),
                )
                .unwrap();
                for i in 0..40 {
                    let towards = Vec3::new(0.05 * i as f32 - 1.0, 0.1, -2.0);
                    let length = if i % 5 == 0 { f32::INFINITY } else { 8.0 };
                    let ray = Ray::new(Vec3::ZERO, towards, length).unwrap();
                    let Some(path) = LightPath::new(&ray, &lamp, &medium) else {
                        continue;
                    };
                    let crate::Emitter::Point(point) = &lamp else {
                        continue;
                    };
                    let Some(arc) = Arc::new(&path, path.span()) else {
                        continue;
                    };
                    let arcs = Arcs::new(Parts::new(point, [(&path, path.span()); LANES]));
                    let t = Lanes::new([0.07, 0.2, 0.33, 0.5, 0.6, 0.75, 0.93, 0.99]);
                    let x = arcs.positions(t).to_array();
                    for (x, t) in x.into_iter().zip(t.to_array()) {
                        let alone = arc.position(t);
                        let d = path.from_light(alone - path.foot()).1;
                        assert!((x - alone).abs() <= 1e-6 * (x + d), "{t}: {x} {alone}");
                    }
                    let found = arcs.parts().sources(x.into());
                    for (lane, x) in x.into_iter().enumerate() {
                        let alone = path.source(x);
                        for (channel, found) in found.iter().enumerate() {
                            let (found, alone) = (found.to_array()[lane], alone[channel]);
                            assert!(
                                (found - alone).abs() <= 2e-6 * alone + 1e-36,
                                "{found} {alone}"
                            );
                            compared += usize::from(alone > 0.0);
                        }
                    }
                }
            }
        }
        assert!(compared > 5000, "{compared}");
    }
}

//! The part of a ray that a light can reach, and the kinks of the light along it.

use glam::DVec3;

use super::MOST_KINKS;
use crate::scene::{Bounds, DirectionalEmitter, Emission, Medium, PointEmitter, SpotEmission};
use crate::{Interval, Ray};

/// The line of a ray relative to a point light, in f64.
pub(super) struct Clip<'a> {
    pub(super) point: &'a PointEmitter,
    /// The vector from the light to the ray's origin.
    pub(super) from_light: DVec3,
    pub(super) direction: DVec3,
    pub(super) foot: f64,
    pub(super) h: f64,
}

impl Clip<'_> {
    /// The part of `inside` that is within the range and the cone of the light.
    pub(super) fn span(&self, inside: Interval) -> Option<Interval> {
        let Self {
            point,
            from_light,
            direction,
            foot,
            h,
        } = *self;
        let mut clipped = inside;
        let mut intersect = |start: f64, end: f64| {
            clipped.start = clipped.start.max(start as f32);
            clipped.end = clipped.end.min(end as f32);
        };
        let range = f64::from(point.range());
        if range.is_finite() {
            let half = (range * range - h * h).max(0.0).sqrt();
            intersect(foot - half, foot + half);
        }
        match point.emission() {
            Emission::Isotropic => {}
            Emission::Cosine { normal } => {
                let (start, end) = clip_to_half_space(from_light, direction, normal.as_dvec3())?;
                intersect(start, end);
            }
            Emission::Spot(spot) => {
                let cos = 1.0 - f64::from(spot.outer_versine());
                let (start, end) = clip_to_cone(from_light, direction, axis_of(spot), cos)?;
                intersect(start, end);
            }
        }
        (clipped.start < clipped.end).then_some(clipped)
    }

    /// Positions inside `span` where the light has a kink, in order, followed by infinities.
    pub(super) fn kinks(&self, medium: &Medium, span: Interval) -> [f32; MOST_KINKS] {
        let mut kinks = [f32::INFINITY; MOST_KINKS];
        let mut count = 0;
        let mut add = |x: f64| {
            let x = x as f32;
            if span.start < x && x < span.end {
                kinks[count] = x;
                count += 1;
            }
        };
        if let Emission::Spot(spot) = self.point.emission()
            && spot.outer_versine() > spot.rim()
        {
            let cos = 1.0 - f64::from(spot.outer_versine()) + f64::from(spot.rim());
            let full = clip_to_cone(self.from_light, self.direction, axis_of(spot), cos);
            if let Some((start, end)) = full {
                add(start);
                add(end);
            }
        }
        if let Some(bounds) = medium.bounds() {
            // Light enters through the face of the box that it meets last. For two faces, the
            // shares of the light's path at which it meets them are linear in the position on
            // the ray, so they are equal at one position. If the light is between the two faces
            // of an axis, it meets neither on its way in.
            let light = self.point.position().as_dvec3();
            let (min, max) = (bounds.min().as_dvec3(), bounds.max().as_dvec3());
            let to_face = DVec3::select(light.cmplt(min), min - light, DVec3::ZERO)
                + DVec3::select(light.cmpgt(max), max - light, DVec3::ZERO);
            for axis in 0..3 {
                let next = (axis + 1) % 3;
                if to_face[axis] != 0.0 && to_face[next] != 0.0 {
                    let slope =
                        to_face[next] * self.direction[axis] - to_face[axis] * self.direction[next];
                    let offset = to_face[axis] * self.from_light[next]
                        - to_face[next] * self.from_light[axis];
                    add(offset / slope);
                }
            }
        }
        if count > 1 {
            kinks.sort_by(f32::total_cmp);
        }
        kinks
    }
}

/// The axis of a spotlight with more digits than [`SpotEmission::axis`] has; narrow cones need
/// them.
pub(crate) fn axis_of(spot: &SpotEmission) -> DVec3 {
    spot.rotation().as_dquat().normalize() * DVec3::NEG_Z
}

/// The part of the line `v + x w` that is on the side of a plane through the origin to which
/// `normal` points.
fn clip_to_half_space(v: DVec3, w: DVec3, normal: DVec3) -> Option<(f64, f64)> {
    let (before, along) = (v.dot(normal), w.dot(normal));
    let border = -before / along;
    if along > 0.0 {
        Some((border, f64::INFINITY))
    } else if along < 0.0 {
        Some((f64::NEG_INFINITY, border))
    } else {
        (before >= 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY))
    }
}

/// The part of the line `v + x w` inside the cone of all `p` with `p·axis ≥ cos |p|`, for 0 ≤
/// cos < 1. The cone is convex, so this is a single interval, which may be unbounded.
pub(super) fn clip_to_cone(v: DVec3, w: DVec3, axis: DVec3, cos: f64) -> Option<(f64, f64)> {
    let inside = |x: f64| {
        let p = v + x * w;
        p.dot(axis) >= cos * p.length()
    };
    // The crossings of the line with the double cone (p·axis)² = cos² p², and with the plane
    // through the apex that separates its two halves.
    let (va, wa) = (v.dot(axis), w.dot(axis));
    let c2 = cos * cos;
    let a = wa * wa - c2 * w.length_squared();
    let b = va * wa - c2 * v.dot(w);
    let c = va * va - c2 * v.length_squared();
    let mut cuts = Vec::with_capacity(5);
    cuts.push(f64::NEG_INFINITY);
    let discriminant = b * b - a * c;
    if discriminant >= 0.0 {
        let q = -(b + discriminant.sqrt().copysign(b));
        cuts.extend([q / a, c / q].into_iter().filter(|x| x.is_finite()));
    }
    if wa != 0.0 {
        cuts.push(-va / wa);
    }
    cuts.push(f64::INFINITY);
    cuts.sort_by(f64::total_cmp);
    let scale = 1.0 + v.length();
    let mut result: Option<(f64, f64)> = None;
    for pair in cuts.windows(2) {
        let (start, end) = (pair[0], pair[1]);
        let probe = match (start.is_finite(), end.is_finite()) {
            (true, true) => 0.5 * (start + end),
            (true, false) => start + scale,
            (false, true) => end - scale,
            (false, false) => 0.0,
        };
        if start < end && inside(probe) {
            result = Some((result.map_or(start, |(first, _)| first), end));
        }
    }
    result
}

/// Positions at which the face of the box through which sunlight has entered changes, in order;
/// `f32::INFINITY` where there are fewer than two.
///
/// The distance to the entry is the smallest of three functions, one per axis, that are linear
/// in `x`. So it is concave and has at most two kinks, each where two of the functions are
/// equal.
pub(super) fn face_changes(bounds: Bounds, ray: &Ray, sun: &DirectionalEmitter) -> [f32; 2] {
    let (origin, direction) = (ray.origin(), ray.direction());
    let back = -sun.direction();
    // Distance to the face along one axis: base + slope x.
    let mut lines = [(0.0_f32, 0.0_f32); 3];
    let mut count = 0;
    for axis in 0..3 {
        if back[axis] != 0.0 {
            let face = if back[axis] > 0.0 {
                bounds.max()[axis]
            } else {
                bounds.min()[axis]
            };
            lines[count] = (
                (face - origin[axis]) / back[axis],
                -direction[axis] / back[axis],
            );
            count += 1;
        }
    }
    let mut kinks = [f32::INFINITY; 2];
    let mut found = 0;
    for i in 0..count {
        for j in i + 1..count {
            let x = (lines[j].0 - lines[i].0) / (lines[i].1 - lines[j].1);
            if !x.is_finite() {
                continue;
            }
            let here = lines[i].0 + lines[i].1 * x;
            // At a kink the third function must not be smaller, apart from rounding.
            let least = (0..count)
                .filter(|k| *k != i && *k != j)
                .map(|k| lines[k].0 + lines[k].1 * x)
                .fold(f32::INFINITY, f32::min);
            if here <= least + 1e-5 * here.abs() && found < 2 {
                kinks[found] = x;
                found += 1;
            }
        }
    }
    kinks.sort_by(f32::total_cmp);
    kinks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_along_the_cone_and_through_its_apex_is_clipped_too() {
        let axis = DVec3::NEG_Z;
        assert_eq!(
            clip_to_cone(DVec3::Z, DVec3::NEG_Z, axis, 0.5),
            Some((1.0, f64::INFINITY))
        );
        assert_eq!(clip_to_cone(DVec3::Z, DVec3::X, axis, 0.5), None);
        let (start, end) = clip_to_cone(DVec3::NEG_Z, DVec3::X, axis, 0.5).unwrap();
        assert!((start + 3_f64.sqrt()).abs() < 1e-12 && (end - 3_f64.sqrt()).abs() < 1e-12);
        let along_edge = DVec3::new(3_f64.sqrt(), 0.0, -1.0);
        assert!(clip_to_cone(DVec3::NEG_Z * 2.0, along_edge, axis, 0.5).is_some());
    }
}

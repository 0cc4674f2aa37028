//! The convex hull of a light and of the air that it lights along some rays.

use glam::DVec3;

use crate::hull::{Hull, MARGIN, Place};
use crate::scene::Interval;

/// A ray from the eye: its unit direction, and the part of it that the light can reach.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub(super) direction: DVec3,
    pub(super) lit: Interval,
}

impl Span {
    /// The far end.
    fn end(&self) -> Place {
        Place::on_ray(self.direction, f64::from(self.lit.end))
    }
}

/// The convex hull of a light, given by its corners, and of the spans of some rays from one
/// eye. It contains the path of light to every point of these spans. Positions are relative to
/// the eye.
///
/// `None` if the directions of the rays differ too much.
pub(super) fn hull(spans: &[Span], light: &[Place]) -> Option<Hull> {
    let sum: DVec3 = spans.iter().map(|span| span.direction).sum();
    let axis = sum.try_normalize()?;
    let (across, up) = axis.any_orthonormal_pair();
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let (mut near, mut far) = (f64::INFINITY, 0.0_f64);
    for Span { direction, lit } in spans {
        let depth = direction.dot(axis);
        if depth < 0.1 {
            return None;
        }
        near = near.min(depth * f64::from(lit.start));
        far = far.max(depth * f64::from(lit.end));
        for (i, side) in [across, up].into_iter().enumerate() {
            let slope = direction.dot(side) / depth;
            low[i] = low[i].min(slope);
            high[i] = high[i].max(slope);
        }
    }
    // Directions of depth 1 along the edges of a pyramid around the rays, in order.
    let corners = [
        (low[0], low[1]),
        (high[0], low[1]),
        (high[0], high[1]),
        (low[0], high[1]),
    ]
    .map(|(x, y)| axis + x * across + y * up);
    let far_place = |corner: DVec3| match far.is_finite() {
        true => Place::At(far * corner),
        false => Place::Towards(corner.normalize()),
    };
    let places: Vec<Place> = (corners.iter().map(|corner| Place::At(near * *corner)))
        .chain(corners.map(far_place))
        .chain(light.iter().copied())
        .collect();
    let normals = normals(axis, &corners, [near, far], light);
    let both = normals.into_iter().flat_map(|normal| [normal, -normal]);
    Some(Hull::new(both, &places))
}

/// Normals of planes that may separate a hull from what is outside: those of the axes, of the
/// pyramid of rays, and of planes through its edges and the light.
fn normals(axis: DVec3, corners: &[DVec3; 4], depths: [f64; 2], light: &[Place]) -> Vec<DVec3> {
    let mut normals = vec![axis, DVec3::X, DVec3::Y, DVec3::Z];
    let mut add = |normal: DVec3| normals.extend(normal.try_normalize());
    if let [Place::At(a), Place::At(b), Place::At(c), ..] = light {
        add((b - a).cross(c - a));
    }
    for (i, corner) in corners.iter().enumerate() {
        let next = corners[(i + 1) % 4];
        add(corner.cross(next));
        for light in light {
            add(light.from(DVec3::ZERO).cross(*corner));
            for depth in depths {
                if depth.is_finite() {
                    add((next - *corner).cross(light.from(depth * *corner)));
                }
            }
        }
    }
    normals
}

/// Whether the light and all spans are on the same side of a triangle's plane, so that the
/// triangle cannot be between them. `is_end` tells for which spans the triangle is their end,
/// which rounding must not put behind the plane.
pub(super) fn is_behind_all(
    corners: &[DVec3; 3],
    light: &[Place],
    spans: &[Span],
    is_end: impl Fn(usize) -> bool,
) -> bool {
    let [a, b, c] = *corners;
    let Some(normal) = (b - a).cross(c - a).try_normalize() else {
        return false;
    };
    // The eye is at the origin.
    let distance = -normal.dot(a);
    let (normal, distance) = (normal * distance.signum(), distance.abs());
    let margin = |place: DVec3| MARGIN * (a.abs().max_element() + place.abs().max_element());
    let is_before = |place: Place| match place {
        Place::At(place) => normal.dot(place) + distance > margin(place),
        Place::Towards(way) => normal.dot(way) > MARGIN,
    };
    let is_not_behind = |place: Place| match place {
        Place::At(place) => normal.dot(place) + distance >= 0.0,
        Place::Towards(way) => normal.dot(way) >= 0.0,
    };
    distance > margin(DVec3::ZERO)
        && light.iter().all(|corner| is_before(*corner))
        && (spans.iter().enumerate()).all(|(i, span)| is_not_behind(span.end()) || is_end(i))
}

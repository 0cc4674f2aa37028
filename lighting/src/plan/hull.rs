//! The air of some rays that a light lights, and what can be between the two.

use glam::DVec3;

use crate::scene::{Emitter, Interval};

/// What roundings take from the distance of a caster from a hull, relative to the numbers
/// that go into it.
const MARGIN: f64 = 1e-9;

/// The convex hull of the lit spans of some rays from one eye and of their light: all ways
/// of light to these spans are in it.
///
/// It is known by planes that it lies behind. Positions are relative to the eye.
#[derive(Debug)]
pub(super) struct Hull {
    /// Unit normals, and how far the hull reaches along each.
    planes: Vec<(DVec3, f64)>,
    /// The size of its finite coordinates.
    scale: f64,
}

/// A position, or a direction without end.
#[derive(Debug, Clone, Copy)]
pub(super) enum Place {
    At(DVec3),
    Towards(DVec3),
}

/// A ray from the eye: its unit direction, and what of it is lit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub(super) direction: DVec3,
    pub(super) lit: Interval,
}

impl Place {
    /// Where a light is.
    pub(super) fn of(emitter: &Emitter, eye: DVec3) -> Self {
        match emitter {
            Emitter::Point(point) => Self::At(point.position().as_dvec3() - eye),
            Emitter::Directional(sun) => Self::Towards(-sun.direction().as_dvec3().normalize()),
        }
    }

    /// How far it is along a unit vector.
    fn along(self, normal: DVec3) -> f64 {
        match self {
            Self::At(place) => normal.dot(place),
            Self::Towards(way) if normal.dot(way) > 1e-3 * MARGIN => f64::INFINITY,
            Self::Towards(_) => f64::NEG_INFINITY,
        }
    }

    /// Direction from a place to this one.
    fn from(self, place: DVec3) -> DVec3 {
        match self {
            Self::At(at) => at - place,
            Self::Towards(way) => way,
        }
    }
}

impl Span {
    /// Where it ends.
    fn end(&self) -> Place {
        let end = f64::from(self.lit.end);
        match end.is_finite() {
            true => Place::At(end * self.direction),
            false => Place::Towards(self.direction),
        }
    }
}

impl Hull {
    /// `None` if the rays do not look in about one direction.
    pub(super) fn new(spans: &[Span], light: Place) -> Option<Self> {
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
        // Of depth 1, in order around the pyramid of rays.
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
            .chain([light])
            .collect();
        let normals = normals(axis, &corners, [near, far], light);
        let scale = places.iter().map(|place| match place {
            Place::At(place) => place.abs().max_element(),
            Place::Towards(_) => 0.0,
        });
        let reach = |normal: DVec3| {
            let reach = places.iter().map(|place| place.along(normal));
            reach.fold(f64::NEG_INFINITY, f64::max)
        };
        let both = normals.into_iter().flat_map(|normal| [normal, -normal]);
        Some(Self {
            scale: scale.fold(0.0, f64::max),
            planes: both
                .map(|normal| (normal, reach(normal)))
                .filter(|(_, reach)| reach.is_finite())
                .collect(),
        })
    }

    /// False only if a box of this centre and half extent is outside.
    pub(super) fn may_meet_box(&self, centre: DVec3, half: DVec3) -> bool {
        let margin = MARGIN * (self.scale + centre.abs().max_element() + half.max_element());
        let is_outside = |&(normal, reach): &(DVec3, f64)| {
            normal.dot(centre) - normal.abs().dot(half) > reach + margin
        };
        !self.planes.iter().any(is_outside)
    }

    /// False only if a triangle is outside.
    pub(super) fn may_meet_triangle(&self, corners: &[DVec3; 3]) -> bool {
        let size = corners.iter().map(|corner| corner.abs().max_element());
        let margin = MARGIN * (self.scale + size.fold(0.0, f64::max));
        let is_outside = |&(normal, reach): &(DVec3, f64)| {
            let along = corners.map(|corner| normal.dot(corner));
            along[0].min(along[1]).min(along[2]) > reach + margin
        };
        !self.planes.iter().any(is_outside)
    }
}

/// Normals of planes that may separate a hull from what is outside: those of the axes, of
/// the pyramid of rays, and of planes through its edges and the light.
fn normals(axis: DVec3, corners: &[DVec3; 4], depths: [f64; 2], light: Place) -> Vec<DVec3> {
    let mut normals = vec![axis, DVec3::X, DVec3::Y, DVec3::Z];
    let mut add = |normal: DVec3| normals.extend(normal.try_normalize());
    for (i, corner) in corners.iter().enumerate() {
        let next = corners[(i + 1) % 4];
        add(corner.cross(next));
        add(light.from(DVec3::ZERO).cross(*corner));
        for depth in depths {
            if depth.is_finite() {
                add((next - *corner).cross(light.from(depth * *corner)));
            }
        }
    }
    normals
}

/// Whether a triangle has the light and all of the spans on the same side of its plane, so
/// that it cannot be between them: rays may end on it. `is_end` tells of which spans it is
/// the end itself, whatever their last digit says.
pub(super) fn is_behind_all(
    corners: &[DVec3; 3],
    light: Place,
    spans: &[Span],
    is_end: impl Fn(usize) -> bool,
) -> bool {
    let [a, b, c] = *corners;
    let Some(normal) = (b - a).cross(c - a).try_normalize() else {
        return false;
    };
    // Towards the eye, which is at zero.
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
        && is_before(light)
        && (spans.iter().enumerate()).all(|(i, span)| is_not_behind(span.end()) || is_end(i))
}

//! Convex hulls as sets of planes, and tests for what is certainly outside of them.

use glam::DVec3;

use crate::scene::Emitter;

/// A margin for rounding in the distance of a caster from a hull, relative to the largest
/// coordinates.
pub(crate) const MARGIN: f64 = 1e-9;

/// A convex part of space, given by planes that it lies behind.
#[derive(Debug)]
pub(crate) struct Hull {
    /// Unit normals, and how far the hull extends along each.
    planes: Vec<(DVec3, f64)>,
    /// The largest of its finite coordinates.
    scale: f64,
}

/// A position, or a direction that stands for a point at infinity.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Place {
    At(DVec3),
    Towards(DVec3),
}

impl Place {
    /// The place of a light, relative to an eye.
    pub(crate) fn of(emitter: &Emitter, eye: DVec3) -> Self {
        match emitter {
            Emitter::Point(point) => Self::At(point.position().as_dvec3() - eye),
            Emitter::Directional(sun) => Self::Towards(-sun.direction().as_dvec3().normalize()),
        }
    }

    /// The place at a distance, which may be infinite, along a unit vector.
    pub(crate) fn on_ray(direction: DVec3, distance: f64) -> Self {
        match distance.is_finite() {
            true => Self::At(distance * direction),
            false => Self::Towards(direction),
        }
    }

    /// The vector or the direction from another place to this one.
    pub(crate) fn from(self, place: DVec3) -> DVec3 {
        match self {
            Self::At(at) => at - place,
            Self::Towards(way) => way,
        }
    }

    /// The coordinate along a unit vector, which may be infinite.
    fn along(self, normal: DVec3) -> f64 {
        match self {
            Self::At(place) => normal.dot(place),
            Self::Towards(way) if normal.dot(way) > 1e-3 * MARGIN => f64::INFINITY,
            Self::Towards(_) => f64::NEG_INFINITY,
        }
    }
}

impl Hull {
    /// The hull of some places, bounded by planes with these unit normals. Normals along which
    /// the hull is infinite are left out.
    pub(crate) fn new(normals: impl IntoIterator<Item = DVec3>, places: &[Place]) -> Self {
        let scale = places.iter().map(|place| match place {
            Place::At(place) => place.abs().max_element(),
            Place::Towards(_) => 0.0,
        });
        let reach = |normal: DVec3| {
            let reach = places.iter().map(|place| place.along(normal));
            reach.fold(f64::NEG_INFINITY, f64::max)
        };
        Self {
            scale: scale.fold(0.0, f64::max),
            planes: normals
                .into_iter()
                .map(|normal| (normal, reach(normal)))
                .filter(|(_, reach)| reach.is_finite())
                .collect(),
        }
    }

    /// False only if a box with this centre and half extent is certainly outside.
    pub(crate) fn may_meet_box(&self, centre: DVec3, half: DVec3) -> bool {
        let margin = MARGIN * (self.scale + centre.abs().max_element() + half.max_element());
        let is_outside = |&(normal, reach): &(DVec3, f64)| {
            normal.dot(centre) - normal.abs().dot(half) > reach + margin
        };
        !self.planes.iter().any(is_outside)
    }

    /// False only if a triangle is certainly outside.
    pub(crate) fn may_meet_triangle(&self, corners: &[DVec3; 3]) -> bool {
        let size = corners.iter().map(|corner| corner.abs().max_element());
        let margin = MARGIN * (self.scale + size.fold(0.0, f64::max));
        let is_outside = |&(normal, reach): &(DVec3, f64)| {
            let along = corners.map(|corner| normal.dot(corner));
            along[0].min(along[1]).min(along[2]) > reach + margin
        };
        !self.planes.iter().any(is_outside)
    }
}

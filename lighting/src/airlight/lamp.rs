//! A light with a pattern, as a ray sees it.

use airlight::Segment64;
use airlight::quadrature::Node;
use glam::{DVec3, Vec3};

use crate::path::axis_of;
use crate::scene::{Emission, PointEmitter, SpotEmission, Texture};
use crate::{Interval, LightPath};

/// A light with a pattern, as seen along a ray. It is in double precision, because seen from
/// afar a narrow cone is a small difference of large lengths.
#[derive(Debug)]
pub(super) struct Lamp<'a> {
    pub(super) point: &'a PointEmitter,
    pub(super) emission: airlight::Emission,
    /// Distance of the foot point from the eye, and of the light from the ray.
    pub(super) foot: f64,
    pub(super) h: f64,
    /// Unit vectors along the ray, and from the light to the foot point.
    pub(super) direction: DVec3,
    pub(super) to_foot: DVec3,
}

impl<'a> Lamp<'a> {
    /// `None` for a light that shines alike in all directions and does not fade.
    pub(super) fn new(path: &LightPath<'_>, point: &'a PointEmitter) -> Option<Self> {
        if point.is_plain() {
            return None;
        }
        let direction = path.ray().direction().as_dvec3().normalize();
        let to_light = point.position().as_dvec3() - path.ray().origin().as_dvec3();
        let foot = to_light.dot(direction);
        let across = to_light.cross(direction);
        let h = across.length();
        // A second product makes it normal to the ray, however close the ray passes the light.
        let to_foot = (across.try_normalize())
            .and_then(|across| across.cross(direction).try_normalize())
            .unwrap_or_else(|| direction.any_orthonormal_vector());
        let parts = |axis: DVec3| (axis.dot(direction), axis.dot(to_foot));
        let emission = match point.emission() {
            Emission::Isotropic => Ok(airlight::Emission::isotropic()),
            Emission::Cosine { normal } => {
                let (along, across) = parts(normal.as_dvec3().normalize());
                airlight::Emission::cosine(along, across)
            }
            Emission::Spot(spot) => {
                let (along, across) = parts(axis_of(spot));
                let outer = 1.0 - f64::from(spot.outer_versine());
                let full = (outer + f64::from(spot.rim())).min(1.0);
                airlight::Emission::spot(along, across, full, outer)
            }
        };
        let range = point.range().into();
        let emission = emission.and_then(|emission| {
            if point.fades() {
                emission.fading_within(range)
            } else {
                Ok(emission)
            }
        });
        Some(Self {
            point,
            emission: emission.expect("parts of a unit vector, and cosines in order"),
            foot,
            direction,
            to_foot,
            // A ray through the light counts as one that passes beside it.
            h: if path.h() > 1.001 * h as f32 {
                path.h().into()
            } else {
                h
            },
        })
    }

    pub(super) fn part(&self, path: &LightPath<'_>, interval: Interval) -> Segment64 {
        let start = f64::from(interval.start);
        Segment64 {
            x: start - f64::from(path.entry()),
            s: start - self.foot,
            h: self.h,
            length: f64::from(interval.end) - start,
        }
    }

    /// [`LightPath::source`] at a node behind `start`, without the emission, which is a factor
    /// of the node's weight.
    pub(super) fn source(&self, path: &LightPath<'_>, start: f32, node: Node) -> Vec3 {
        let medium = path.medium();
        let x = start + node.distance;
        let (direction, d) = path.from_light(x - path.foot());
        let light_leg = medium.length_inside(path.ray().at(x), -direction, d);
        let optical_length = x - path.entry() + light_leg;
        let transmittance = (-medium.sigma_t() * optical_length).exp();
        let light = medium.phase().value(node.angle) * self.point.intensity();
        medium.sigma_s() * light * transmittance
    }

    /// The spotlight and its cookie, if it has one.
    pub(super) fn cookie(&self) -> Option<(&'a SpotEmission, &'a Texture)> {
        match self.point.emission() {
            Emission::Spot(spot) => spot.texture().map(|texture| (spot, texture)),
            _ => None,
        }
    }
}

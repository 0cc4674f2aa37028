//! The emission of a spotlight along a ray.

use glam::{DVec2, DVec3};

use crate::LightPath;
use crate::path::axis_of;
use crate::scene::{PointEmitter, SpotEmission};

/// A ray as a spotlight sees it. Positions are distances behind the foot point.
#[derive(Debug)]
pub(super) struct Beam<'a> {
    point: &'a PointEmitter,
    h: f64,
    axis: DVec3,
    /// The vector from the light to the foot point, and the change per metre of the ray.
    foot: DVec3,
    along: DVec3,
    /// The same in the coordinates of the cookie, to the right and down, in which its half side
    /// is 1 at distance 1; and along the axis.
    side: [DVec2; 2],
    front: [f64; 2],
    outer_versine: f64,
    rim: f64,
}

impl<'a> Beam<'a> {
    pub(super) fn new(path: &LightPath<'_>, point: &'a PointEmitter, spot: &SpotEmission) -> Self {
        let along = path.ray().direction().as_dvec3().normalize();
        let to_light = point.position().as_dvec3() - path.ray().origin().as_dvec3();
        let across = to_light.cross(along);
        // A second product makes it normal to the ray, however close the ray passes the light.
        let to_foot = (across.try_normalize())
            .and_then(|across| across.cross(along).try_normalize())
            .unwrap_or_else(|| along.any_orthonormal_vector());
        let h = f64::from(path.h());
        let foot = h * to_foot;
        let back = spot.rotation().as_dquat().normalize().inverse();
        let local = [back * foot, back * along];
        let tan = f64::from(spot.tan_outer());
        Self {
            point,
            h,
            axis: axis_of(spot),
            foot,
            along,
            side: local.map(|v| DVec2::new(v.x, -v.y) / tan),
            front: local.map(|v| -v.z),
            outer_versine: spot.outer_versine().into(),
            rim: spot.rim().into(),
        }
    }

    /// The place in the cookie at which a position is seen, from 0 to 1.
    pub(super) fn uv(&self, s: f64) -> DVec2 {
        let front = self.front[0] + self.front[1] * s;
        let plane = (self.side[0] + s * self.side[1]) / front;
        // At the light itself no direction is defined.
        match plane.is_finite() {
            true => 0.5 + 0.5 * plane,
            false => DVec2::splat(0.5),
        }
    }

    /// The share of the light that passes the rim of the cone.
    pub(super) fn rim(&self, s: f64) -> f64 {
        let direction = (self.foot + s * self.along).normalize_or(self.axis);
        let versine = 0.5 * (self.axis - direction).length_squared();
        let ramp = ((self.outer_versine - versine) / self.rim).clamp(0.0, 1.0);
        ramp * ramp
    }

    /// The share of the light that the window of a fading light leaves.
    pub(super) fn window(&self, s: f64) -> f64 {
        let d = s.hypot(self.h) as f32;
        f64::from(self.point.window_inside(d))
    }
}

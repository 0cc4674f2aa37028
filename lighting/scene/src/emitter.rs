//! Lights as algorithms see them: points with an angular emission, and directions.

use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::{Quat, Vec2, Vec3};

use crate::{Cone, SceneError, Texture, is_near};

/// The smallest difference between the cosines of a spotlight's cones, as in
/// KHR_lights_punctual.
const LEAST_RIM: f64 = 0.001;

/// If a ray crosses more lines between the centres of a cookie's texels than this, coarser
/// levels of the cookie are blended in; see [`SpotEmission::mip`].
pub const MOST_COOKIE_LINES: u32 = 4096;

/// A light that reaches each point of space from a single direction.
///
/// [`Light::emitters`](crate::Light::emitters) and the constructors here make emitters, whose
/// numbers are therefore valid. A further kind would be a breaking change, because every
/// algorithm has to handle each kind.
#[derive(Debug, Clone, PartialEq)]
pub enum Emitter {
    /// At a point.
    Point(PointEmitter),
    /// Infinitely far away.
    Directional(DirectionalEmitter),
}

/// A point that emits.
#[derive(Debug, Clone, PartialEq)]
pub struct PointEmitter {
    position: Vec3,
    intensity: Vec3,
    range: f32,
    falloff: Falloff,
    emission: Emission,
}

/// How the light of a point ends at its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Falloff {
    /// The light is undiminished up to the range, and 0 beyond it.
    #[default]
    Hard,
    /// The light is multiplied by `max(1 − (d / range)⁴, 0)` at the distance `d`, the window
    /// that KHR_lights_punctual recommends. With an infinite range it does not fade.
    Smooth,
}

/// Parallel light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalEmitter {
    direction: Vec3,
    irradiance: Vec3,
}

/// How the intensity of a point spreads over directions.
#[derive(Debug, Clone, PartialEq)]
pub enum Emission {
    /// The same everywhere.
    Isotropic,
    /// Proportional to the cosine to `normal`, 0 behind it.
    Cosine {
        /// Unit normal of the emitting surface.
        normal: Vec3,
    },
    /// A cone with a smooth edge; see [`Cone`].
    Spot(SpotEmission),
}

/// The emission of a spotlight, prepared for evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct SpotEmission {
    rotation: Quat,
    cos_inner: f32,
    cos_outer: f32,
    /// 1 − cos of the outer half angle, which has more digits.
    outer_versine: f32,
    /// Difference between the cosines of the inner and the outer half angle, at
    /// least 0.001.
    rim: f32,
    tan_outer: f32,
    texture: Option<Texture>,
    /// Coarser levels of the texture, see [`SpotEmission::mip_levels`].
    mip_levels: Arc<[Texture]>,
}

impl Emission {
    /// A spotlight along the local −Z of `rotation`.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if the angles are not 0 ≤ inner < outer ≤ π/2,
    /// the rotation is not a finite quaternion other than 0, or there is a
    /// texture and `outer` exceeds 1.5 rad (the cookie would be infinite).
    pub fn spot(rotation: Quat, cone: Cone, texture: Option<Texture>) -> Result<Self, SceneError> {
        let Cone { inner, outer } = cone;
        let largest = if texture.is_some() { 1.5 } else { FRAC_PI_2 };
        if !(inner >= 0.0 && inner < outer && outer <= largest) {
            return Err(SceneError::bad_value(
                "spotlight",
                "cone",
                format!("{inner} to {outer} rad"),
                "0 <= inner < outer <= pi/2 (1.5 with a texture)",
            ));
        }
        let length = rotation.length();
        if !(length.is_finite() && length > 0.0) {
            return Err(SceneError::bad_value(
                "spotlight",
                "rotation",
                rotation,
                "a finite quaternion other than 0",
            ));
        }
        // 1 − cos x = 2 sin²(x/2) keeps its digits; the cone must stay convex.
        let versine = |angle: f32| (2.0 * (0.5 * f64::from(angle)).sin().powi(2)).min(1.0);
        let [full, dark] = [inner, outer].map(versine);
        Ok(Self::Spot(SpotEmission {
            rotation: rotation.normalize(),
            cos_inner: (1.0 - full) as f32,
            cos_outer: (1.0 - dark) as f32,
            outer_versine: dark as f32,
            rim: (dark - full).max(LEAST_RIM) as f32,
            tan_outer: outer.tan(),
            mip_levels: texture.as_ref().map(mip_levels).unwrap_or_default(),
            texture,
        }))
    }

    /// The factor on the intensity in the unit `direction`, which points away from the light.
    pub fn factor(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Isotropic => Vec3::ONE,
            Self::Cosine { normal } => Vec3::splat(normal.dot(direction).max(0.0)),
            Self::Spot(spot) => spot.factor(direction),
        }
    }
}

impl SpotEmission {
    /// Unit direction of the axis.
    pub fn axis(&self) -> Vec3 {
        self.rotation * Vec3::NEG_Z
    }

    /// From the light's space to the world's.
    pub fn rotation(&self) -> Quat {
        self.rotation
    }

    /// 1 − cos of the half angle at which the light ends, at most 1: for narrow
    /// cones it has the digits that [`SpotEmission::cos_outer`] lacks.
    pub fn outer_versine(&self) -> f32 {
        self.outer_versine
    }

    /// The difference between the cosines of the half angles at which the light is full and at
    /// which it ends, at least 0.001.
    pub fn rim(&self) -> f32 {
        self.rim
    }

    /// Cosine of the half angle up to which the intensity is full.
    pub fn cos_inner(&self) -> f32 {
        self.cos_inner
    }

    /// Cosine of the half angle up to which the intensity really is full: that of the inner
    /// cone, or 0.001 more than that of the outer cone if the two are closer than this.
    pub fn cos_full(&self) -> f32 {
        self.cos_outer + self.rim
    }

    /// Cosine of the half angle at which the light ends, at least 0.
    pub fn cos_outer(&self) -> f32 {
        self.cos_outer
    }

    /// Half the side of the cookie at distance 1 in front of the light: the
    /// tangent of the half angle at which the light ends.
    pub fn tan_outer(&self) -> f32 {
        self.tan_outer
    }

    /// The cookie in front of the light.
    pub fn texture(&self) -> Option<&Texture> {
        self.texture.as_ref()
    }

    /// The detail of the cookie for a ray that crosses `lines` lines between the centres of its
    /// texels: a mip level, 0 for the cookie itself, and the share of the next coarser level,
    /// from 0 to 1.
    ///
    /// For up to [`MOST_COOKIE_LINES`] lines this is the cookie itself. From there the share
    /// grows with the number of lines up to twice that number, at which the next level takes
    /// over, so that there is no seam in the image. The level never exceeds those of
    /// [`SpotEmission::mip_levels`].
    pub fn mip(&self, lines: f64) -> (usize, f64) {
        let most = f64::from(MOST_COOKIE_LINES);
        let (mut level, mut lines) = (0, lines);
        while lines > 2.0 * most && level < self.mip_levels.len() {
            level += 1;
            lines *= 0.5;
        }
        if level == self.mip_levels.len() {
            return (level, 0.0);
        }
        (level, (lines / most - 1.0).clamp(0.0, 1.0))
    }

    /// Coarser levels of the cookie, of which the first has half as many texels along each side
    /// as the cookie, and each further one half as many as the one before. There are as many as
    /// [`SpotEmission::mip`] needs: none for cookies whose width and height together are at
    /// most [`MOST_COOKIE_LINES`].
    pub fn mip_levels(&self) -> &[Texture] {
        &self.mip_levels
    }

    fn factor(&self, direction: Vec3) -> Vec3 {
        // 1 − cos θ is half the square of the distance between two unit vectors:
        // the cosines themselves would differ in their last digits only.
        let versine = 0.5 * (self.axis() - direction).length_squared();
        let edge = ((self.outer_versine - versine) / self.rim).clamp(0.0, 1.0);
        let falloff = Vec3::splat(edge * edge);
        match &self.texture {
            Some(texture) if edge > 0.0 => {
                let local = self.rotation.inverse() * direction;
                let plane = Vec2::new(local.x, -local.y) / (-local.z * self.tan_outer);
                falloff * texture.clamp(0.5 + 0.5 * plane)
            }
            _ => falloff,
        }
    }
}

impl Emitter {
    /// A point of radiant intensity `intensity` (times the factor of
    /// `emission`) that lights nothing farther away than `range`.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if the position is not finite or beyond 1e9 m, an
    /// intensity is neither 0 nor from 1e-20 to 1e20, or the range is not above
    /// 0 (it may be infinite).
    pub fn point(
        position: impl Into<[f32; 3]>,
        intensity: impl Into<[f32; 3]>,
        range: f32,
        emission: Emission,
    ) -> Result<Self, SceneError> {
        let [position, intensity] = [position.into(), intensity.into()].map(Vec3::from_array);
        if !is_near(position) {
            return Err(SceneError::bad_value(
                "light",
                "position",
                position,
                "coordinates within 1e9 m",
            ));
        }
        check_power("intensity", intensity)?;
        if !(range > 0.0) {
            return Err(SceneError::bad_value(
                "light",
                "range",
                range,
                "a distance above 0",
            ));
        }
        Ok(Self::Point(PointEmitter {
            position,
            intensity,
            range,
            falloff: Falloff::Hard,
            emission,
        }))
    }

    /// The same light with another falloff at its range. Directional light has no range and
    /// stays as it is.
    #[must_use]
    pub fn with_falloff(self, falloff: Falloff) -> Self {
        match self {
            Self::Point(point) => Self::Point(PointEmitter { falloff, ..point }),
            sun @ Self::Directional(_) => sun,
        }
    }

    /// What a spotlight sends out; `None` for any other light.
    pub fn spot(&self) -> Option<&SpotEmission> {
        match self {
            Self::Point(point) => match point.emission() {
                Emission::Spot(spot) => Some(spot),
                _ => None,
            },
            Self::Directional(_) => None,
        }
    }

    /// The same light without a pattern: a point light shines alike in all directions up to its
    /// range, and is 0 beyond. Directional light has no pattern.
    #[must_use]
    pub fn bare(&self) -> Self {
        match self {
            Self::Point(point) => Self::Point(PointEmitter {
                falloff: Falloff::Hard,
                emission: Emission::Isotropic,
                ..*point
            }),
            Self::Directional(sun) => Self::Directional(*sun),
        }
    }

    /// Parallel light that travels along `direction`, a vector of any length except 0.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] if the direction is 0 or not finite, or an
    /// irradiance is neither 0 nor from 1e-20 to 1e20.
    pub fn directional(
        direction: impl Into<[f32; 3]>,
        irradiance: impl Into<[f32; 3]>,
    ) -> Result<Self, SceneError> {
        let [direction, irradiance] = [direction.into(), irradiance.into()].map(Vec3::from_array);
        check_power("irradiance", irradiance)?;
        match direction.try_normalize() {
            Some(direction) => Ok(Self::Directional(DirectionalEmitter {
                direction,
                irradiance,
            })),
            None => Err(SceneError::bad_value(
                "directional light",
                "direction",
                direction,
                "a finite vector other than 0",
            )),
        }
    }

    /// Radiant intensity on the axis, or irradiance.
    #[inline]
    pub fn intensity(&self) -> Vec3 {
        match self {
            Self::Point(point) => point.intensity,
            Self::Directional(sun) => sun.irradiance,
        }
    }
}

impl PointEmitter {
    /// World position, m.
    #[inline]
    pub fn position(&self) -> Vec3 {
        self.position
    }

    /// Radiant intensity before the factor of the emission.
    pub fn intensity(&self) -> Vec3 {
        self.intensity
    }

    /// Nothing farther away than this is lit; may be infinite.
    #[inline]
    pub fn range(&self) -> f32 {
        self.range
    }

    /// How the light falls off at its range.
    pub fn falloff(&self) -> Falloff {
        self.falloff
    }

    /// Whether the light fades towards its range, which is finite then.
    #[inline]
    pub fn fades(&self) -> bool {
        self.falloff == Falloff::Smooth && self.range < f32::INFINITY
    }

    /// The factor on the intensity at the distance `d` in metres, from 0 to 1; 0 for NaN.
    #[inline]
    pub fn window(&self, d: f32) -> f32 {
        if !(d <= self.range) {
            0.0
        } else if self.fades() {
            let square = (d / self.range) * (d / self.range);
            (1.0 - square) * (1.0 + square)
        } else {
            1.0
        }
    }

    /// [`PointEmitter::window`] for a distance that is known to be in range, even if rounding
    /// puts it beyond.
    pub fn window_inside(&self, d: f32) -> f32 {
        self.window(d.min(self.range))
    }

    /// Whether it shines alike in all directions and does not fade, so that every evaluator
    /// applies to it.
    pub fn is_plain(&self) -> bool {
        self.emission == Emission::Isotropic && !self.fades()
    }

    /// The intensity's distribution over directions.
    #[inline]
    pub fn emission(&self) -> &Emission {
        &self.emission
    }
}

impl DirectionalEmitter {
    /// Unit vector along which the light travels.
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// Irradiance on a plane that faces the light.
    pub fn irradiance(&self) -> Vec3 {
        self.irradiance
    }
}

/// The coarser levels of a cookie.
fn mip_levels(cookie: &Texture) -> Arc<[Texture]> {
    // At least as many lines as a ray can cross in the current level.
    let mut lines = f64::from(cookie.width()) + f64::from(cookie.height());
    let mut levels: Vec<Texture> = Vec::new();
    while lines > f64::from(MOST_COOKIE_LINES) {
        levels.push(levels.last().unwrap_or(cookie).halved());
        lines *= 0.5;
    }
    levels.into()
}

/// Smaller intensities and irradiances than this, except 0, are errors.
pub(crate) const LEAST_POWER: f32 = 1e-20;

fn check_power(what: &'static str, value: Vec3) -> Result<(), SceneError> {
    let sound = |channel: &f32| *channel == 0.0 || (LEAST_POWER..=1e20).contains(channel);
    if value.to_array().iter().all(sound) {
        return Ok(());
    }
    Err(SceneError::bad_value(
        "light",
        what,
        value,
        "0, or 1e-20 to 1e20, in each channel",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against f64, which differs by the rounding of directions: 1e-7 rad.
    #[test]
    fn narrow_cones_keep_their_profile() {
        for degrees in [0.05_f32, 0.1, 2.0, 30.0, 90.0] {
            let outer = degrees.to_radians();
            let inner = 0.3 * outer;
            let rotation = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(0.2);
            let emission = Emission::spot(rotation, Cone { inner, outer }, None).unwrap();
            let axis = rotation.as_dquat().normalize() * glam::DVec3::NEG_Z;
            let versine = |angle: f64| 2.0 * (0.5 * angle).sin().powi(2);
            let (full, dark) = (versine(inner.into()), versine(outer.into()));
            for i in 0..20 {
                let angle = outer * (i as f32 + 0.5) / 20.0;
                let direction = rotation * Quat::from_rotation_x(angle) * Vec3::NEG_Z;
                let off = axis.angle_between(direction.as_dvec3());
                let ramp = (dark - versine(off)) / (dark - full).max(LEAST_RIM);
                let expected = ramp.clamp(0.0, 1.0).powi(2);
                let found = f64::from(emission.factor(direction).x);
                let largest = (dark / (dark - full).max(LEAST_RIM)).min(1.0).powi(2);
                let allowed = 3e-7 / f64::from(outer) + 3e-7;
                assert!(
                    (found - expected).abs() <= 4.0 * allowed * largest,
                    "{degrees} {i}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn windows_fall_from_one_to_nothing() {
        let plain = Emitter::point(Vec3::ZERO, Vec3::ONE, 4.0, Emission::Isotropic).unwrap();
        for (falloff, values) in [
            (Falloff::Hard, [1.0, 1.0, 1.0, 0.0, 0.0]),
            (Falloff::Smooth, [1.0, 15.0 / 16.0, 0.0, 0.0, 0.0]),
        ] {
            let Emitter::Point(light) = plain.clone().with_falloff(falloff) else {
                panic!("a point was made");
            };
            let found = [0.0, 2.0, 4.0, 4.001, f32::NAN].map(|d| light.window(d));
            assert_eq!(found, values, "{falloff:?}");
            assert_eq!(light.is_plain(), falloff == Falloff::Hard);
        }
        let endless = Emitter::point(Vec3::ZERO, Vec3::ONE, f32::INFINITY, Emission::Isotropic);
        let Emitter::Point(light) = endless.unwrap().with_falloff(Falloff::Smooth) else {
            panic!("a point was made");
        };
        assert!(!light.fades() && light.window(1e30) == 1.0);
    }
}

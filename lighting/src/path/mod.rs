//! An eye ray as seen from a light.

#[cfg(any(test, feature = "shadow-map"))]
mod arc;
mod clip;
#[cfg(feature = "shadow-map")]
mod depths;
mod lanes;

use airlight::Segment;
use glam::Vec3;

#[cfg(any(test, feature = "shadow-map"))]
pub(crate) use arc::Arc;
#[cfg(feature = "shadow-map")]
pub(crate) use arc::Turns;
use clip::Clip;
pub(crate) use clip::axis_of;
#[cfg(feature = "shadow-map")]
pub use depths::depth_range;
pub(crate) use lanes::{Arcs, LANES, Lanes, PartOf, Parts, in_lanes};

use crate::scene::{
    Bounds, DirectionalEmitter, Emission, Emitter, Medium, PointEmitter, ScatteringAngle,
    SpotEmission,
};
use crate::{Interval, Ray};

/// An eye ray, a light and a medium: what a [`VisibilitySource`](crate::VisibilitySource) finds
/// the lit parts of, and what an [`AirlightEvaluator`](crate::AirlightEvaluator) integrates
/// over.
///
/// ```text
///                     P  light
///                   / |
///             d   /   | h
///               /     |
///   E ────────X───────F──────→ ray      s = x − x_F  (here s < 0)
///   eye       x       foot point
/// ```
///
/// For a point light, a position on the ray is given by its distance `x` from the eye, or by `s
/// = x − x_F`, its distance behind the foot point F of the light; `h` is the distance between
/// light and ray. Both are computed in f64 from the vectors, `h` by a cross product, so that no
/// digits are lost near the axis.
#[derive(Debug, Clone, Copy)]
pub struct LightPath<'a> {
    ray: Ray,
    index: u32,
    emitter: &'a Emitter,
    medium: &'a Medium,
    /// The part that can be lit: inside the medium, the range and the cone.
    span: Interval,
    /// The distance at which the ray enters the medium.
    entry: f32,
    foot: f32,
    h: f32,
    /// Unit vector from the light to the foot point.
    to_foot: Vec3,
    /// Positions of the integrand's kinks, in order; infinite where there are fewer.
    kinks: [f32; MOST_KINKS],
}

/// From this value on, which runs from 0 to 1 over the rim of a spotlight, the light counts as
/// full, because the ends of the part in the full cone are rounded. The light is the square of
/// the value, so its error is up to twice the difference to 1, a tenth of the error of the best
/// tables.
const FULL: f32 = 1.0 - 4e-6;

/// A spotlight has two kinks, the faces of a box three.
pub(crate) const MOST_KINKS: usize = 5;

impl<'a> LightPath<'a> {
    /// The part of `ray` that `emitter` can light inside `medium`; `None` if the ray misses the
    /// medium's box, the light's range or its cone.
    pub fn new(ray: &Ray, emitter: &'a Emitter, medium: &'a Medium) -> Option<Self> {
        let whole = Interval::new(0.0, ray.length());
        let inside = match medium.bounds() {
            Some(bounds) => bounds.clip(ray.origin(), ray.direction(), whole)?,
            None => whole,
        };
        let mut path = Self {
            ray: *ray,
            index: 0,
            emitter,
            medium,
            span: inside,
            entry: inside.start,
            foot: 0.0,
            h: 0.0,
            to_foot: Vec3::ZERO,
            kinks: [f32::INFINITY; MOST_KINKS],
        };
        match emitter {
            Emitter::Directional(sun) => {
                if let Some(bounds) = medium.bounds() {
                    path.kinks[..2].copy_from_slice(&clip::face_changes(bounds, ray, sun));
                }
            }
            Emitter::Point(point) => {
                let to_light = (point.position() - ray.origin()).as_dvec3();
                // The stored direction is of unit length to f32 precision only.
                let direction = ray.direction().as_dvec3().normalize();
                let foot = to_light.dot(direction);
                let h = to_light.cross(direction).length();
                let offset = direction * foot - to_light;
                path.foot = foot as f32;
                path.h = h as f32;
                path.to_foot = offset
                    .try_normalize()
                    .unwrap_or_else(|| direction.any_orthonormal_vector())
                    .as_vec3();
                let clip = Clip {
                    point,
                    from_light: -to_light,
                    direction,
                    foot,
                    h,
                };
                path.span = clip.span(inside)?;
                path.kinks = clip.kinks(medium, path.span);
            }
        }
        (path.span.start < path.span.end).then_some(path)
    }

    /// The same path, moved away from the light if it runs through it.
    ///
    /// Along a ray through a point light the airlight is infinite. Images contain the value at
    /// a distance of 1e-4 of the distance between eye and light instead: every ray that passes
    /// more closely counts as one at that distance, or at 1e-12 m if the eye is at the light
    /// itself.
    #[must_use]
    pub fn off_the_light(mut self) -> Self {
        if self.span.start <= self.foot && self.foot <= self.span.end {
            self.h = self.h.max(1e-4 * self.foot.hypot(self.h)).max(1e-12);
        }
        self
    }

    /// The same path with the index of its ray.
    #[must_use]
    pub fn with_index(self, index: u32) -> Self {
        Self { index, ..self }
    }

    /// The part of the span that is in the cone of directions from the light whose cosine to an
    /// axis is at least `cos`. If the path was [moved off the light](LightPath::off_the_light),
    /// this is so for the moved path.
    #[cfg(feature = "shadow-map")]
    pub(crate) fn in_cone(&self, axis: glam::DVec3, cos: f64) -> Option<Interval> {
        let foot = f64::from(self.h) * self.to_foot.as_dvec3();
        let direction = self.ray.direction().as_dvec3().normalize();
        let (start, end) = clip::clip_to_cone(foot, direction, axis, cos)?;
        let at = |s: f64| (s + f64::from(self.foot)) as f32;
        let part = Interval::new(self.span.start.max(at(start)), self.span.end.min(at(end)));
        (part.start < part.end).then_some(part)
    }

    /// The same path, of which only what lies in `part` can be lit; `None` if nothing does.
    #[cfg(feature = "shadow-map")]
    pub(crate) fn within(self, part: Interval) -> Option<Self> {
        let (start, end) = (self.span.start, self.span.end);
        let span = Interval::new(start.max(part.start), end.min(part.end));
        (span.start < span.end).then_some(Self { span, ..self })
    }

    /// The index of the ray in its frame, or 0 for a single ray. Data that was computed for
    /// each pixel before, such as bounds of a shadow, is looked up by it.
    pub fn index(&self) -> u32 {
        self.index
    }

    /// The eye ray.
    pub fn ray(&self) -> &Ray {
        &self.ray
    }

    /// The light.
    pub fn emitter(&self) -> &'a Emitter {
        self.emitter
    }

    /// The medium along the ray.
    pub fn medium(&self) -> &'a Medium {
        self.medium
    }

    /// The part of the ray that would be lit if nothing blocked the light. Its end is infinite
    /// for a ray to the sky in a medium without bounds.
    pub fn span(&self) -> Interval {
        self.span
    }

    /// Positions on the line of the ray, in order, where the light along it has a kink: at the
    /// inner cone of a spotlight, and where the path of the light starts to enter a bounded
    /// medium through another face. Quadrature should stop at each. A cookie has further kinks
    /// where the ray crosses the lines through the centres of its texels;
    /// [`Quadrature`](crate::airlight::Quadrature) stops at these, too.
    pub fn kinks(&self) -> impl Iterator<Item = f32> {
        self.kinks.into_iter().take_while(|x| x.is_finite())
    }

    /// The interval, divided at the kinks inside it, in order.
    pub fn without_kinks(&self, interval: Interval) -> impl Iterator<Item = Interval> {
        let mut inside = self.kinks;
        let mut count = 0;
        for kink in self.kinks() {
            if interval.start < kink && kink < interval.end {
                inside[count] = kink;
                count += 1;
            }
        }
        (0..=count).map(move |i| {
            let start = if i == 0 {
                interval.start
            } else {
                inside[i - 1]
            };
            let end = if i == count { interval.end } else { inside[i] };
            Interval::new(start, end)
        })
    }

    /// The distance `x` of a point light's foot point from the eye; may be negative.
    pub fn foot(&self) -> f32 {
        self.foot
    }

    /// Distance between a point light and the line of the ray.
    pub fn h(&self) -> f32 {
        self.h
    }

    /// Distance `x` at which the ray enters the medium.
    pub fn entry(&self) -> f32 {
        self.entry
    }

    /// The interval in the form that evaluators of the crate `airlight` take, if they apply:
    /// for a point light that shines alike in all directions, does not fade, and whose light
    /// travels inside the medium alone.
    pub fn segment(&self, interval: Interval) -> Option<Segment> {
        let Emitter::Point(point) = self.emitter else {
            return None;
        };
        let applies = self.is_immersed() && point.is_plain();
        applies.then(|| self.part(interval))
    }

    /// The [`full_cone`] of the emitter.
    pub(crate) fn full_cone(&self) -> Option<&'a SpotEmission> {
        match self.emitter {
            Emitter::Directional(_) => None,
            Emitter::Point(point) => full_cone(point, self.medium),
        }
    }

    /// Whether an interval lies in the full cone of a spotlight. As the cone is convex, testing
    /// both ends suffices.
    pub(crate) fn is_full(&self, spot: &SpotEmission, interval: Interval) -> bool {
        [interval.start, interval.end].into_iter().all(|x| {
            let direction = if x == f32::INFINITY {
                self.ray.direction()
            } else {
                self.from_light(x - self.foot).0
            };
            let versine = 0.5 * (spot.axis() - direction).length_squared();
            spot.outer_versine() - versine >= FULL * spot.rim()
        })
    }

    /// Whether the light is a point light inside the medium.
    pub(crate) fn is_immersed(&self) -> bool {
        match (self.emitter, self.medium.bounds()) {
            (Emitter::Directional(_), _) => false,
            (Emitter::Point(_), None) => true,
            (Emitter::Point(point), Some(bounds)) => bounds.contains(point.position()),
        }
    }

    /// The interval as seen from a point light, whatever its emission.
    pub(crate) fn part(&self, interval: Interval) -> Segment {
        Segment {
            x: interval.start - self.entry,
            s: interval.start - self.foot,
            h: self.h,
            length: interval.length(),
        }
    }

    /// Whether a point light lies on the interval.
    pub(crate) fn meets_light(&self, interval: Interval) -> bool {
        self.h == 0.0 && interval.start <= self.foot && self.foot <= interval.end
    }

    /// The unit vector from a point light to the position `s` behind the foot point, and the
    /// distance.
    pub fn from_light(&self, s: f32) -> (Vec3, f32) {
        let d = (s * s + self.h * self.h).sqrt();
        let along = self.ray.direction() * (s / d) + self.to_foot * (self.h / d);
        (along, d)
    }

    /// Radiant intensity of a point light in the unit direction `direction`.
    pub fn intensity(&self, point: &PointEmitter, direction: Vec3) -> Vec3 {
        match point.emission() {
            Emission::Isotropic => point.intensity(),
            emission => point.intensity() * emission.factor(direction),
        }
    }

    /// Light that is scattered towards the eye per metre of ray at distance `x`, times the
    /// squared distance to a point light: `σ_s p(cos θ) I exp(−σ_t (x + d))`, or `σ_s p E
    /// exp(−σ_t (x + l))` for a sun, with the window of a light that fades towards its range.
    ///
    /// This is the integrand of the airlight without the inverse square, which stays bounded in
    /// the equi-angular variable.
    pub fn source(&self, x: f32) -> Vec3 {
        let eye_leg = x - self.entry;
        match self.emitter {
            Emitter::Point(point) => {
                let s = x - self.foot;
                let (direction, d) = self.from_light(s);
                // The length is measured from the ray: from a light far away, f32 could not
                // tell the faces of the box apart.
                let light_leg = self.medium.length_inside(self.ray.at(x), -direction, d);
                let phase = self
                    .medium
                    .phase()
                    .value(ScatteringAngle::from_foot(s, self.h));
                let mut light = self.intensity(point, direction);
                if point.fades() {
                    light *= point.window_inside(d);
                }
                self.scattered(phase, light, eye_leg + light_leg)
            }
            Emitter::Directional(sun) => {
                let phase = self.medium.phase().value(self.sun_angle(sun));
                let light_leg = self.sun_leg(sun, x);
                self.scattered(phase, sun.irradiance(), eye_leg + light_leg)
            }
        }
    }

    /// The length that sunlight travels inside the medium to the point at `x`; 0 in a medium
    /// without bounds.
    pub fn sun_leg(&self, sun: &DirectionalEmitter, x: f32) -> f32 {
        match self.medium.bounds() {
            None => 0.0,
            Some(bounds) => {
                // Rounding may put a position on a face outside of the box.
                let point = self.ray.at(x).clamp(bounds.min(), bounds.max());
                self.medium
                    .length_inside(point, -sun.direction(), f32::INFINITY)
            }
        }
    }

    /// The angle between the direction of sunlight and the direction to the eye.
    pub fn sun_angle(&self, sun: &DirectionalEmitter) -> ScatteringAngle {
        ScatteringAngle::from_cos(-self.ray.direction().dot(sun.direction()))
    }

    fn scattered(&self, phase: f32, light: Vec3, optical_length: f32) -> Vec3 {
        let sigma_t = self.medium.sigma_t();
        // Grey media are common, and exponentials are most of the work.
        let transmittance = if sigma_t == Vec3::splat(sigma_t.x) {
            Vec3::splat((-sigma_t.x * optical_length).exp())
        } else {
            (-sigma_t * optical_length).exp()
        };
        self.medium.sigma_s() * (phase * light) * transmittance
    }
}

/// The emission of a spotlight that is a plain point light within its full cone: one inside the
/// medium, without a cookie, that does not fade.
pub(crate) fn full_cone<'a>(point: &'a PointEmitter, medium: &Medium) -> Option<&'a SpotEmission> {
    let is_outside = |bounds: Bounds| !bounds.contains(point.position());
    match point.emission() {
        Emission::Spot(spot) if spot.texture().is_none() && !point.fades() => {
            (!medium.bounds().is_some_and(is_outside)).then_some(spot)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;
    use reference::random::noise;

    use super::*;
    use crate::scene::{Cone, PhaseFunction};

    fn fog() -> Medium {
        Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic).unwrap()
    }

    #[test]
    fn the_cone_of_a_spotlight_clips_rays_wherever_they_run() {
        for outer in [0.1_f32, 0.7, 1.4, std::f32::consts::FRAC_PI_2] {
            let cone = Cone { inner: 0.0, outer };
            let rotation = Quat::from_rotation_x(0.3) * Quat::from_rotation_y(-1.0);
            let emission = Emission::spot(rotation, cone, None).unwrap();
            let position = Vec3::new(0.2, 1.0, -3.0);
            let light = Emitter::point(position, Vec3::ONE, 20.0, emission).unwrap();
            let axis = rotation * Vec3::NEG_Z;
            let medium = fog();
            for i in 0..500_u32 {
                let unit = |k: u32| noise(u64::from(i * 7 + k)) - 0.5;
                let origin = 12.0 * Vec3::new(unit(1), unit(2), unit(3));
                let direction = Vec3::new(unit(4), unit(5), unit(6));
                let ray = Ray::new(origin, direction, 30.0).unwrap();
                let span = LightPath::new(&ray, &light, &medium).map(|p| p.span());
                for k in 0..300 {
                    let x = 30.0 * (k as f32 + 0.5) / 300.0;
                    let offset = ray.at(x) - position;
                    let margin = axis.dot(offset.normalize()) - outer.cos();
                    let near_border = margin.abs() < 1e-4 || (offset.length() - 20.0).abs() < 1e-3;
                    let lit = margin > 0.0 && offset.length() < 20.0;
                    let claimed = span.is_some_and(|s| s.start <= x && x <= s.end);
                    assert!(near_border || lit == claimed, "{outer} {i} {x} {span:?}");
                }
            }
        }
    }

    #[test]
    fn positions_keep_their_digits_next_to_the_axis() {
        let light = Emitter::point(
            Vec3::new(0.0, 1e-4, -100.0),
            Vec3::ONE,
            f32::INFINITY,
            Emission::Isotropic,
        )
        .unwrap();
        let medium = fog();
        let ray = Ray::new(Vec3::ZERO, Vec3::NEG_Z, f32::INFINITY).unwrap();
        let path = LightPath::new(&ray, &light, &medium).unwrap();
        assert_eq!((path.foot(), path.h()), (100.0, 1e-4));
        assert!(path.off_the_light().h() > 0.99e-2);
        let away = Ray::new(Vec3::ZERO, Vec3::Z, f32::INFINITY).unwrap();
        let path = LightPath::new(&away, &light, &medium).unwrap();
        assert_eq!(path.off_the_light().h(), 1e-4, "not near the light");
    }

    #[test]
    fn light_is_attenuated_only_inside_a_box() {
        let bounds = Bounds::new(Vec3::splat(-1.0), Vec3::ONE).unwrap();
        let medium = fog().within(bounds);
        let ray = Ray::new(Vec3::new(0.0, 0.0, 5.0), Vec3::NEG_Z, 20.0).unwrap();
        let light = Emitter::point(
            Vec3::new(0.0, 10.0, 0.0),
            Vec3::ONE,
            f32::INFINITY,
            Emission::Isotropic,
        )
        .unwrap();
        let path = LightPath::new(&ray, &light, &medium).unwrap();
        assert_eq!(path.span(), Interval::new(4.0, 6.0));
        let expected = 0.1 / (4.0 * std::f32::consts::PI) * (-0.1_f32 * 2.0).exp();
        assert!((path.source(5.0).x / expected - 1.0).abs() < 1e-6);
        let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
        let path = LightPath::new(&ray, &sun, &medium).unwrap();
        assert!((path.source(5.0).x / expected - 1.0).abs() < 1e-6);
    }
}

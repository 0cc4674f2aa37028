//! Area lights by ray tracing: the baseline for other methods for area lights.
//!
//! Based on: Kulla and Fajardo, Importance Sampling Techniques for Path Tracing in
//! Participating Media, EGSR 2012, for the equi-angular distance; Villeneuve, Gruson,
//! Georgiev and Nowrouzezahrai, Practical Product Sampling for Single Scattering in
//! Media, EGSR 2021, for the cosine of the emitter in it; Cranley and Patterson,
//! Randomization of Number Theoretic Methods for Multiple Integration, SIAM Journal on
//! Numerical Analysis 1976, for the rotation.
//!
//! The light of an area A along a ray is
//!
//! ```text
//! L = ∫_A ∫ σ_s p e^{−σ_t (x + d)} L_e (n · ω) / d² V dx dA
//! ```
//!
//! where `d` is the distance between the point of the light and the point on the ray, and `ω`
//! the direction from the first to the second. [`TracedArea::by_points`] draws both points and
//! traces one shadow ray. [`TracedArea::by_runs`] draws only the point of the light and
//! integrates over the lit parts of the ray, which [`Exact`] visibility finds.
//!
//! # The distance along the ray
//!
//! Let `η` be the angle, seen from the point of the light, between the foot point of the ray
//! and a position on it, so that `x = x_F + h tan η` and `dx / d² = dη / h`. All directions to
//! the ray lie in a plane, so the cosine of the emission is that of the normal's projection
//! onto this plane:
//!
//! ```text
//! n · ω = C cos(η − η₀),    C e^{i η₀} = n · u + i n · v
//! ```
//!
//! where `v` is the direction of the ray and `u` that from the light to the foot
//! point. The density proportional to it on what of the ray lies in front of the
//! light, from η_a to η_b, has a sine as its distribution and is sampled exactly:
//!
//! ```text
//! η = η₀ + asin(lerp(sin(η_a − η₀), sin(η_b − η₀), t))
//! L ≈ σ_s p e^{−σ_t (x + d)} L_e A V · C (sin(η_b − η₀) − sin(η_a − η₀)) / h
//! ```
//!
//! What is left to vary is the phase function, the attenuation and the visibility. No
//! angle is ever formed: sines and cosines of η − η₀ come from the vectors.
//!
//! # The points
//!
//! Those of the additive recurrence of the plastic number's kind (Roberts, The
//! Unreasonable Effectiveness of Quasirandom Sequences, 2018) in three or two
//! dimensions, `fract(½ + i α)`; the first n of more than n are those of n. Each pixel
//! shifts them by a vector of its own, modulo 1, which is a hash of its number: the
//! error of a pixel is independent of its neighbours', its expectation is 0, and the
//! image is the same in every run and with any number of threads.
//!
//! # Limits
//!
//! The points are spread evenly over the light, whatever its texture. Both samplers
//! run on the CPU alone: they have no shader. Hair and smoke cast no shadow.

#[cfg(feature = "methods")]
mod method;
#[cfg(test)]
mod tests;

use std::borrow::Borrow;

use glam::{DVec2, DVec3, Vec3};

use crate::eye_panes::Behind;
use crate::scene::trace::Tracer;
use crate::scene::{AreaLight, AreaSurface, Emission, Emitter, Medium, SceneError};
use crate::visibility::{Exact, LitInterval, VisibilitySource};
use crate::{AirlightEvaluator, EyePanes, Interval, LightPath, Ray};
#[cfg(feature = "methods")]
pub(super) use method::methods;

/// An area light whose shadows are traced.
#[derive(Debug, Clone)]
pub struct TracedArea<'a, T> {
    surface: AreaSurface<'a>,
    tracer: T,
    medium: &'a Medium,
}

/// A ray of a picture.
#[derive(Debug, Clone, Copy)]
pub struct PixelRay<'a> {
    /// The ray.
    pub ray: &'a Ray,
    /// Its number, from which its rotation of the points comes and by which its panes
    /// are found.
    pub index: u32,
    /// What covers parts of the rays; `None` if nothing does.
    pub panes: Option<&'a EyePanes>,
}

impl<'a, T: Borrow<Tracer> + Sync> TracedArea<'a, T> {
    /// The light among the triangles of `tracer`, in `medium`.
    ///
    /// # Errors
    /// Those of [`AreaSurface::new`].
    pub fn new(light: &'a AreaLight, tracer: T, medium: &'a Medium) -> Result<Self, SceneError> {
        Ok(Self {
            surface: AreaSurface::new(light)?,
            tracer,
            medium,
        })
    }

    /// The radiance that the light sends along a ray into its origin, by `count`
    /// points of the light, each with one point on the ray and one shadow ray between
    /// the two. An unbiased estimate; 0 without points.
    ///
    /// A ray that passes a point closer than [`LightPath::off_the_light`] says counts
    /// as one at that distance.
    pub fn by_points(&self, pixel: PixelRay<'_>, count: u32) -> Vec3 {
        if self.medium.scatters_nothing() {
            return Vec3::ZERO;
        }
        let rotation = rotation(pixel.index);
        let mut sum = Vec3::ZERO;
        for i in 0..count {
            let [x, y, t] = point_3d(i, rotation);
            let (position, radiance) = self.surface.point(DVec2::new(x, y));
            if radiance == Vec3::ZERO {
                continue;
            }
            if let Some(light) = self.sample(pixel, position, t) {
                sum += radiance * light;
            }
        }
        self.surface.area() / count.max(1) as f32 * sum
    }

    /// What a point of the light adds, without its radiance and area; `None` if
    /// nothing.
    fn sample(&self, pixel: PixelRay<'_>, position: Vec3, t: f64) -> Option<Vec3> {
        let normal = self.surface.normal();
        // The cosine is in the density and must not be in the integrand.
        let emitter = lamp(position, Emission::Isotropic)?;
        let path = LightPath::new(pixel.ray, &emitter, self.medium)?.off_the_light();
        let front = Front::new(&path, position, normal)?;
        let (x, weight) = front.sample(t);
        let (direction, distance) = path.from_light(x - path.foot());
        let tracer = self.tracer.borrow();
        let visibility = tracer.transmittance(position, direction, 0.0, distance);
        if visibility == Vec3::ZERO {
            return None;
        }
        Some(weight * visibility * seen(pixel, x) * path.source(x))
    }

    /// The same radiance by `count` points of the light, each with the exactly lit
    /// parts of the ray, which `airlight` integrates. Unbiased but for the error of
    /// `airlight`; 0 without points.
    pub fn by_runs<A: AirlightEvaluator>(
        &self,
        pixel: PixelRay<'_>,
        count: u32,
        airlight: &A,
        parts: &mut Vec<LitInterval<Vec3>>,
    ) -> Vec3 {
        if self.medium.scatters_nothing() {
            return Vec3::ZERO;
        }
        let exact = Exact::new(self.tracer.borrow());
        let [x, y, _] = rotation(pixel.index);
        let mut sum = Vec3::ZERO;
        for i in 0..count {
            let (position, radiance) = self.surface.point(point_2d(i, [x, y]));
            let normal = self.surface.normal();
            let Some(emitter) = lamp(position, Emission::Cosine { normal }) else {
                continue;
            };
            let Some(path) = LightPath::new(pixel.ray, &emitter, self.medium) else {
                continue;
            };
            let path = path.off_the_light();
            if radiance == Vec3::ZERO {
                continue;
            }
            parts.clear();
            exact.lit_intervals(&path, parts);
            for part in &*parts {
                let mut rest = part.interval;
                for pane in panes(pixel) {
                    if pane.from > rest.start && pane.from < rest.end {
                        let before = Interval::new(rest.start, pane.from);
                        let light = seen(pixel, rest.start) * airlight.radiance(&path, before);
                        sum += radiance * part.visibility * light;
                        rest.start = pane.from;
                    }
                }
                let light = seen(pixel, rest.start) * airlight.radiance(&path, rest);
                sum += radiance * part.visibility * light;
            }
        }
        self.surface.area() / count.max(1) as f32 * sum
    }
}

/// A point of unit intensity; `None` for a place that no light may be at, which an
/// [`AreaSurface`] has none of.
fn lamp(position: Vec3, emission: Emission) -> Option<Emitter> {
    Emitter::point(position, Vec3::ONE, f32::INFINITY, emission).ok()
}

fn panes<'a>(pixel: PixelRay<'a>) -> &'a [Behind] {
    pixel.panes.map_or(&[][..], |panes| panes.of(pixel.index))
}

/// The share of the light at a position, or right behind it, that reaches the eye
/// through what covers it.
fn seen(pixel: PixelRay<'_>, x: f32) -> Vec3 {
    let panes = panes(pixel);
    let before = panes.partition_point(|pane| pane.from <= x);
    let last = before.checked_sub(1).map(|last| panes[last].share);
    last.unwrap_or(Vec3::ONE)
}

/// What of a ray lies in front of a point of a light, in the variable of the emission's
/// cosine.
struct Front {
    foot: f64,
    h: f64,
    span: [f32; 2],
    /// Sine of η − η₀ at both ends.
    sines: [f64; 2],
    /// Cosine and sine of η₀.
    middle: [f64; 2],
    /// C.
    strength: f64,
}

impl Front {
    /// `None` if nothing does.
    fn new(path: &LightPath<'_>, position: Vec3, normal: Vec3) -> Option<Self> {
        let ray = path.ray();
        let to_light = (position - ray.origin()).as_dvec3();
        let along = ray.direction().as_dvec3().normalize();
        let foot = to_light.dot(along);
        let offset = along * foot - to_light;
        let span = path.span();
        let [a, b] = [span.start, span.end].map(|x| f64::from(x) - foot);
        // On a ray right through the light all of η lies at ±π/2, where the closest
        // that f64 resolves is as good.
        let nearest = if a < 0.0 && b > 0.0 {
            0.0
        } else {
            a.abs().min(b.abs())
        };
        let h = f64::from(path.h()).max(1e-9 * nearest);
        let across: DVec3 = offset
            .try_normalize()
            .unwrap_or_else(|| along.any_orthonormal_vector());
        let normal = normal.as_dvec3();
        let [x, y] = [normal.dot(across), normal.dot(along)];
        let strength = x.hypot(y);
        if !(strength > 0.0 && h > 0.0) {
            return None;
        }
        let middle = [x / strength, y / strength];
        // (cos, sin) of η − η₀ at a position.
        let turned = |s: f64| {
            let (cos, sin) = match s.is_finite() {
                true => (h / s.hypot(h), s / s.hypot(h)),
                false => (0.0, s.signum()),
            };
            (
                middle[0] * cos + middle[1] * sin,
                middle[0] * sin - middle[1] * cos,
            )
        };
        // A half turn is more than the ray takes: if both ends are behind the light, so
        // is what is between them.
        let sines = match (turned(a), turned(b)) {
            ((cos_a, _), (cos_b, _)) if cos_a <= 0.0 && cos_b <= 0.0 => return None,
            ((cos_a, _), (_, sin_b)) if cos_a <= 0.0 => [-1.0, sin_b],
            ((_, sin_a), (cos_b, _)) if cos_b <= 0.0 => [sin_a, 1.0],
            ((_, sin_a), (_, sin_b)) => [sin_a, sin_b],
        };
        (sines[0] < sines[1]).then_some(Self {
            foot,
            h,
            span: [span.start, span.end],
            sines,
            middle,
            strength,
        })
    }

    /// The distance from the eye at which the share `t` of the emission's cosine lies
    /// before, and the weight of the sample.
    fn sample(&self, t: f64) -> (f32, f32) {
        let [from, to] = self.sines;
        let sine = (from + t * (to - from)).clamp(-1.0, 1.0);
        let cosine = ((1.0 - sine) * (1.0 + sine)).sqrt();
        let [c, s] = self.middle;
        // Back from η − η₀ to η.
        let (sin, cos) = (sine * c + cosine * s, cosine * c - sine * s);
        let x = self.foot + self.h * sin / cos.max(1e-18);
        let [start, end] = self.span;
        let x = (x as f32).clamp(start, end.min(f32::MAX));
        (x, (self.strength * (to - from) / self.h) as f32)
    }
}

/// The point i of the recurrence in three dimensions, 1/g, 1/g² and 1/g³ with
/// g⁴ = g + 1, shifted.
fn point_3d(i: u32, shift: [f64; 3]) -> [f64; 3] {
    const STEPS: [f64; 3] = [
        0.819_172_513_396_164_4,
        0.671_043_606_703_789_3,
        0.549_700_477_901_970_3,
    ];
    std::array::from_fn(|axis| (shift[axis] + 0.5 + f64::from(i) * STEPS[axis]).fract())
}

/// The same in two dimensions, 1/g and 1/g² with g³ = g + 1.
fn point_2d(i: u32, shift: [f64; 2]) -> DVec2 {
    const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    DVec2::from_array(std::array::from_fn(|axis| {
        (shift[axis] + 0.5 + f64::from(i) * STEPS[axis]).fract()
    }))
}

/// The vector by which the points of a pixel are shifted, without a pattern over
/// pixels: three rounds of a 32-bit hash (Wellons, Prospecting for Hash Functions,
/// 2018).
fn rotation(pixel: u32) -> [f64; 3] {
    let hash = |seed: u32| {
        let mut h = pixel.wrapping_mul(3).wrapping_add(seed);
        h = (h ^ (h >> 16)).wrapping_mul(0x7FEB_352D);
        h = (h ^ (h >> 15)).wrapping_mul(0x846C_A68B);
        f64::from(h ^ (h >> 16)) / 4_294_967_296.0
    };
    [hash(0), hash(1), hash(2)]
}

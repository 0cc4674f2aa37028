//! Textured spotlights: in each step the colour of the cookie is a constant factor of the
//! integral, which leaves the airlight of a bare point light.
//!
//! Based on: Wyman and Ramsey, Interactive Volumetric Shadows in Participating Media with
//! Single-Scattering, RT 2008, sections 3.2 to 3.4.
//!
//! A ray is clipped to the cone of the light ([the distances](crate::LightPath::span) to the
//! front and the back of its frustum), and the part inside is divided into short steps. With
//! the intensity I of the bare light,
//!
//! ```text
//! L = Σ_k V_k C_k A(x_k, x_{k+1}),    A(a, b) = ∫_a^b σ_s p(cos θ) I exp(−σ_t (x + d)) / d² dx
//! ```
//!
//! * V_k, 0 or 1: whether the step is lit ([`ShadowSpans`], or any other source of shadows);
//! * C_k: the colour of the cookie × the falloff at the rim of the cone × the window of a light
//!   that fades, at the middle of the step ([`Textured`]);
//! * A: the airlight of a point light that shines alike in all directions, which every
//!   evaluator can compute: the gather is given the [`bare`] light. So a table
//!   ([`Analytic`](crate::airlight::Analytic)) serves lights with cookies too, for which it
//!   would otherwise use its fallback.
//!
//! # Three spans
//!
//! A ray is lit in front of its first shadow volume and behind its last one
//! ([`ShadowVolumes`](super::hybrid::ShadowVolumes)), and the shadow map is not asked there.
//! Between the two it is asked at steps for shadows. Both kinds of steps have their own rate,
//! as in the paper; but a step for shadows costs only a lookup, since lit runs are divided for
//! their colours by the coarser steps. Where a lit step is next to a dark one, the interval
//! between their middles is halved three times. The method in the list has two steps for
//! shadows for each step for colours.
//!
//! # Where the steps are
//!
//! If each ray divides its own span, the surfaces on which samples lie bend at the border of
//! the frustum, where the span changes steeply, and the bends are visible. The paper therefore
//! chooses "our sampling distance based on the angle between the spotlight direction and the
//! ray direction"; the supplement that says how is lost. The following is derived anew. There
//! are two requirements: the positions x_k(ω) on the ray in the direction ω must not depend on
//! where the ray enters the frustum, and no ray may need more than about N steps. Both hold if
//! x_k is on the k-th of numbered surfaces that fill all of space, of which a ray takes those
//! in the frustum.
//!
//! **Lengths** ([`Placement::Length`]) are closest to the words of the paper. The longest
//! chord of a cone of the half angle α and the length R is R along its axis and 2 R sin α
//! across. In a metric that counts lengths across as 1 / (2 sin α) of themselves, the beam is
//! as wide as it is long, and no chord is longer than R by more than a sixth. An N-th of
//! that, on a ray at the angle θ to the axis, is
//!
//! ```text
//! Δx(θ) = R / N / √(cos² θ + sin² θ / (4 sin² α))
//! ```
//!
//! and the surfaces x = k Δx(θ) are similar ellipsoids around the eye with the proportions
//! of the beam, smooth for all θ. (Half-angle slices, after Kniss et al., 2003, to whom the
//! paper compares its own steps, are Δx ∝ 1 / cos(θ/2), or 1 / sin(θ/2) where the light comes
//! from the front. They take the shape of the beam into no account, and bend at a right
//! angle.) R must be the same for all rays: it is an argument. Steps are no shorter than a
//! 4 N-th of what is in the cone.
//!
//! **Angles** ([`Placement::Angle`]) are better, and what the method uses. Let ψ be the angle
//! at the light between the directions to the eye and to a point of the ray. With h the
//! distance between light and ray, s = x − x_F the distance behind the foot point and φ the
//! angle to it,
//!
//! ```text
//! tan φ = s / h,    ψ(x) = φ(x) − φ(0) = atan2(h x, h² − x_F s),    ψ(x_k) = k · 2α / N
//! ```
//!
//! The surfaces are cones around the line through eye and light with their apex at the
//! light: within each plane through that line, rays of light. In the cookie they are fixed
//! curves around the picture of the eye. So neighbouring rays look up neighbouring places,
//! no chord of a cone is seen under more than 2α from its apex, and a ray takes at most N
//! steps and the two that the border cuts. Shadows are bounded by rays of light, too, so
//! that surfaces run along them, as the paper asks for. Steps are short where the
//! light is strong: ∫ ds / d² is the same for each step of a ray. The step is rotated, not
//! computed from angles: cos and sin of φ_{k+1} follow from those of φ_k, and x_k = x_F + h
//! tan φ_k. A ray through the light, or within 1e-4 of its distance, is one step before it
//! and one behind it, each sampled in the middle of its length; in parallel light steps are
//! equal parts of the ray.
//!
//! Steps are cut at the ends of a span and at the rim, and a part of a step is sampled at its
//! own middle.
//!
//! # Mip levels
//!
//! The ends of a step are some texels apart in the cookie. With T texels, the colour is a blend
//! of the levels around log₂ T − 1 ([`MipCookie`]), which is one level finer than the step: a
//! level as coarse as the step would blur across the ray as much as along it. The [table of
//! errors](#error-and-cost) has both.
//!
//! # Options
//!
//! * [`blurred`]: section 3.3's blurred image of the light, in place of light that scatters
//!   more than once. It is off by default: method `textured-blurred`, whose Gaussian is a
//!   thirty-second of the cookie wide. It keeps the mean of all texels.
//! * [`Outside::Lit`]: light outside of the frustum, for a light whose shadow map covers a
//!   frustum only; as in figure 7 of the paper, without shadows.
//! * [`Daylight`](crate::airlight::Daylight): the airlight of Hoffman and Preetham that the
//!   paper takes for coloured lights (`textured x daylight-4`). No comparison shows it: it is
//!   another model, and its distance to single scattering says nothing about steps.
//!
//! # Further departures from the paper
//!
//! Shadow volumes are those of coarse stand-ins in the pictures of the light, see
//! [`hybrid`](super::hybrid). F′ is not rendered for each frame; one table serves a phase
//! function. Scattering at a low resolution is a method around any other, `methods::reduced`.
//!
//! # Error and cost
//!
//! The error of colours is of second order in the length of a step, until texels are shorter
//! than a step; then it is the blur of the mip level. Ends of shadows are of first order,
//! within 1/16 of a step for shadows. The table has the error relative to the mean, in
//! `textured-spot` at 320 × 180 (a cookie of 64² texels, a light in view, a map of 1024²),
//! against the exact integral over the cookie behind the exact runs of the map
//! (`lighting/examples/cookies.rs`):
//!
//! | steps | 8 | 16 | 32 | 64 | 128 |
//! |---|---|---|---|---|---|
//! | march x midpoint | 91 % | 52 % | 15 % | 3.2 % | 0.83 % |
//! | light-space x gauss-1 | 83 % | 36 % | 7.8 % | 2.2 % | 0.52 % |
//! | uniform in the span, one level finer | 50 % | 26 % | 13 % | 3.6 % | 0.82 % |
//! | lengths by the angle to the axis, one level finer | 101 % | 97 % | 92 % | 88 % | 83 % |
//! | angles at the light, no mip level | 107 % | 33 % | 12 % | 1.7 % | 0.59 % |
//! | angles at the light, mip = step | 59 % | 37 % | 16 % | 1.7 % | 0.59 % |
//! | angles at the light, one level finer | 44 % | 22 % | 12 % | 1.7 % | 0.59 % |
//!
//! Steps of equal length do not resolve the beam next to a light in view, whose rays have most
//! of this error. With few steps, the finer mip level halves the error.
//!
//! The gather uses a distance between light and ray of at least 1e-4 of that between eye and
//! light. Closer rays, which are at most about a pixel, are darker than with an evaluator that
//! knows the cone.

mod beam;
mod cookie;
#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
mod lattice;
#[cfg(feature = "methods")]
mod method;
mod spans;
#[cfg(test)]
mod tests;

#[cfg(feature = "methods")]
pub(super) use method::methods;

use std::borrow::Cow;
use std::sync::Arc;

use glam::{DVec2, Vec3};
use gpu_backend::{Host, Memory};

pub use cookie::{MipCookie, blurred};
pub use lattice::Placement;
pub use spans::ShadowSpans;

use beam::Beam;
use lattice::{Lattice, Steps};

use crate::airlight::far_end;
use crate::path::axis_of;
use crate::scene::{PointEmitter, SpotEmission};
use crate::visibility::Share;
use crate::{Emitter, Interval, LightPath, LitInterval, VisibilitySource};

/// The light outside of the cone of a spotlight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Outside {
    /// None: it is a spotlight.
    #[default]
    Dark,
    /// Light without shadows and without colour: the cone is the part of a light that has a
    /// shadow map and a cookie. The border of the cone is not dimmed then.
    Lit,
}

/// A textured spotlight. Step by step, the shares of its light are the colours of its cookie,
/// dimmed by the rim of the cone, where a source of shadows says that the ray is lit.
///
/// The light that is gathered must be the [`bare`] one, without cone and cookie. Lights other
/// than spotlights have no colours, but are divided into steps all the same.
#[derive(Debug)]
pub struct Textured<V, M: Memory> {
    shadows: V,
    light: Emitter,
    cookie: Option<Arc<MipCookie<M>>>,
    steps: Steps,
    finer: f32,
    outside: Outside,
}

impl<V, M: Memory> Textured<V, M> {
    /// A light with its cookie, if it has one, and a source of its shadows, which is asked
    /// about the part of a ray in the cone. Steps are so long that `steps` of them fit across
    /// the beam: 1 to 2²⁰; other numbers count as the nearest of these.
    ///
    /// The cookie may be another than that of the light, for example a [`blurred`] one; the
    /// cookie of the light is not used.
    pub fn new(
        shadows: V,
        light: &Emitter,
        cookie: Option<Arc<MipCookie<M>>>,
        steps: u32,
        placement: Placement,
    ) -> Self {
        Self {
            shadows,
            light: light.clone(),
            cookie,
            steps: Steps::new(light, steps, placement),
            finer: 1.0,
            outside: Outside::Dark,
        }
    }

    /// The same light with a mip level that is `finer` levels finer than a step is long in the
    /// cookie. The default is 1; 0 is as coarse as the step; 32 looks up the cookie itself.
    /// Numbers outside of 0 to 32 count as the nearer end, and NaN as 1.
    #[must_use]
    pub fn with_finer_levels(self, finer: f32) -> Self {
        let finer = match finer.is_nan() {
            true => 1.0,
            false => finer.clamp(0.0, 32.0),
        };
        Self { finer, ..self }
    }

    /// The same light with something else outside of the cone.
    #[must_use]
    pub fn with_outside(self, outside: Outside) -> Self {
        Self { outside, ..self }
    }

    /// The source of the shadows.
    pub fn shadows(&self) -> &V {
        &self.shadows
    }
}

/// The light to be gathered: for a spotlight, a point light without cone and cookie that is
/// undiminished up to its range; any other light unchanged.
pub fn bare(light: &Emitter) -> Cow<'_, Emitter> {
    match light.spot() {
        Some(_) => Cow::Owned(light.bare()),
        None => Cow::Borrowed(light),
    }
}

/// The part of a path that is not cut off: up to ten mean free paths to the sky.
fn within_reach(path: &LightPath<'_>) -> Interval {
    let Interval { start, end } = path.span();
    Interval::new(start, end.min(start + far_end(path.medium())))
}

impl<V: VisibilitySource> Textured<V, Host> {
    /// `None` for a light without a cone.
    fn spot(&self) -> Option<(&PointEmitter, &SpotEmission)> {
        match (&self.light, self.light.spot()) {
            (Emitter::Point(point), Some(spot)) => Some((point, spot)),
            _ => None,
        }
    }

    /// The mean share over a step of the light that comes through the cone.
    fn colour(&self, beam: &Beam<'_>, [start, middle, end]: [f64; 3]) -> Vec3 {
        let rim = match self.outside {
            Outside::Dark => beam.rim(middle),
            Outside::Lit => 1.0,
        };
        let share = Vec3::splat((rim * beam.window(middle)) as f32);
        let Some(cookie) = &self.cookie else {
            return share;
        };
        let size = cookie.size().map(f64::from);
        let across = (beam.uv(end) - beam.uv(start)) * DVec2::from(size);
        let texels = across.length() * (-f64::from(self.finer)).exp2();
        share * cookie.sample(beam.uv(middle), texels)
    }

    /// The same for a path that was moved off the light.
    fn rim_of_moved(&self, path: &LightPath<'_>, spot: &SpotEmission) -> [f32; 2] {
        let full = f64::from(spot.outer_versine()) - f64::from(spot.rim());
        match self.outside == Outside::Dark && full > 0.0 {
            true => path.in_cone(axis_of(spot), 1.0 - full),
            false => None,
        }
        .map_or([f32::INFINITY; 2], |full| [full.start, full.end])
    }

    /// The positions along a ray at which the rim of the cone begins and ends.
    fn rim(&self, path: &LightPath<'_>, cone: &LightPath<'_>) -> [f32; 2] {
        let mut rim = [f32::INFINITY; 2];
        if self.outside == Outside::Dark {
            // All other kinks are the medium's.
            let kinks = cone
                .kinks()
                .filter(|x| path.kinks().all(|other| other != *x));
            for (rim, kink) in rim.iter_mut().zip(kinks) {
                *rim = kink;
            }
        }
        rim
    }
}

/// Divides a lit run into steps, and additionally at two positions.
fn divide<S: Share>(
    (lattice, foot): (&Lattice, f32),
    run: &LitInterval<S>,
    kinks: [f32; 2],
    colour: impl Fn([f64; 3]) -> Vec3,
    lit: &mut Vec<LitInterval<Vec3>>,
) {
    let Interval { mut start, end } = run.interval;
    let mut marks = lattice.behind(start);
    let mut mark = start;
    while start < end {
        while !(mark > start) {
            mark = marks.advance();
        }
        let kinks = kinks.into_iter().filter(|kink| *kink > start);
        let to = kinks.fold(mark.min(end), f32::min);
        let step = [start, lattice.middle(start, to), to];
        let visibility = run.visibility * colour(step.map(|x| f64::from(x) - f64::from(foot)));
        if !visibility.is_dark() {
            lit.push(LitInterval {
                interval: Interval::new(start, to),
                visibility,
            });
        }
        start = to;
    }
}

impl<V: VisibilitySource> VisibilitySource for Textured<V, Host> {
    type Share = Vec3;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<Vec3>>) {
        let whole = within_reach(path);
        let none = [f32::INFINITY; 2];
        let foot = path.foot();
        let mut runs = Vec::new();
        let Some((point, spot)) = self.spot() else {
            let lattice = self.steps.of_path(path, whole);
            self.shadows.lit_intervals(path, &mut runs);
            for run in &runs {
                divide((&lattice, foot), run, none, |_| Vec3::ONE, lit);
            }
            return;
        };
        let beam = Beam::new(path, point, spot);
        let lattice = self.steps.of_path(path, whole);
        let outside = |start: f32, end: f32, lit: &mut _| {
            let run = LitInterval::<f32>::unshadowed(start, end);
            if self.outside == Outside::Lit {
                let colour = |[_, middle, _]: [f64; 3]| Vec3::splat(beam.window(middle) as f32);
                divide((&lattice, foot), &run, none, colour, lit);
            }
        };
        let cone = LightPath::new(path.ray(), &self.light, path.medium());
        let inside = cone.and_then(|cone| {
            let mut inside = path.within(cone.span())?.within(whole)?;
            if lattice.is_through_the_light() {
                // After a path is moved off the light, its part in the cone no longer begins at
                // the light.
                inside = inside.within(
                    inside.in_cone(axis_of(spot), 1.0 - f64::from(spot.outer_versine()))?,
                )?;
            }
            Some((cone, inside))
        });
        let Some((cone, inside)) = inside else {
            outside(whole.start, whole.end, lit);
            return;
        };
        let Interval { start, end } = inside.span();
        outside(whole.start, start, lit);
        self.shadows.lit_intervals(&inside, &mut runs);
        let lattice = self.steps.of_path(path, inside.span());
        let rim = match lattice.is_through_the_light() {
            true => self.rim_of_moved(&inside, spot),
            false => self.rim(path, &cone),
        };
        for run in &runs {
            divide(
                (&lattice, foot),
                run,
                rim,
                |step| self.colour(&beam, step),
                lit,
            );
        }
        outside(end, whole.end, lit);
    }
}

//! Airlight in double precision, the truth for everything else.
//!
//! Based on: Sun, Ramamoorthi, Narasimhan and Nayar, A practical analytic
//! single scattering model for real time rendering, SIGGRAPH 2005, as used by
//! Wyman and Ramsey, Interactive volumetric shadows in participating media
//! with single-scattering, Interactive Ray Tracing 2008. Their closed form
//! has the special function F(u, v), multiplied by a factor that grows like
//! `e^τ`, and loses all digits in dense media, next to the light and for short
//! parts. Here the variable is `t = s + d`, in which
//!
//! ```text
//! A = 2 e^{−σ_t (x_a + d_a)} ∫ p(cos θ) e^{−σ_t (t − t_a)} / (h² + t²) dt,    tan(θ/2) = t/h,
//! ```
//!
//! has no trigonometric function and no large factor. For isotropic
//! scattering it is the difference of two scaled exponential integrals
//! ([`tail`]); where the difference would lose more than one bit, and for
//! other phase functions, it is integrated numerically.
//!
//! A piece of that has 32 nodes, four vectors of AVX-512, and takes about 150 cycles:
//! an exponential of 14 terms, two divisions and a root for each vector bind. Most
//! segments have two to five pieces.

mod adaptive;
#[cfg(test)]
mod references;
mod tail;
#[cfg(test)]
mod tests;

pub use adaptive::Estimate;
pub use tail::tail;

use std::sync::LazyLock;

use pulp::{Simd, WithSimd};

use crate::gauss::Rule;
use crate::scaled::{Extent, Scaled};
use crate::side::{Kind, SHARPEST, Side};
use crate::{
    Emission, Error, Evaluator, Phase, PhaseFunction, ScatteringAngle, Segment, Segment64, simd,
};
use adaptive::{Adaptive, Integrand, NODES};

/// Depth `σ_t d` below which absorption behind the foot point changes the
/// result by less than rounding does.
const THIN: f64 = 1e-20;

/// Optical depth that leaves nothing, even of the smallest f64.
const OPAQUE: f64 = 750.0;

/// Computes airlight as exactly as double precision can.
///
/// The relative error is below 1e-12 for optical depths `σ_t (x + d)` of the
/// start up to 700, wherever the light is, for every length: parts of 1e-9
/// of the ray and rays to infinity. Smaller results than f64 can hold are 0.
/// A user's phase function must be smooth for that; what was reached in each
/// case is returned by [`Exact::estimate`].
///
/// The light on the segment gives +∞; a length of 0 gives 0, and so do
/// numbers that are no lengths or no extinction: NaN, an infinite `x`, `s` or
/// `h`, and a negative `h`, `length` or extinction.
///
/// It takes as long as 1000 to 1600 steps of a march with vector instructions (the groups `easy`
/// and `stiff` of the bench `evaluators`).
#[derive(Debug, Clone, PartialEq)]
pub struct Exact<P = PhaseFunction> {
    phase: P,
}

impl<P: Phase> Exact<P> {
    /// For this phase function.
    ///
    /// # Errors
    /// [`Error::BadValue`] if its parameter is out of range.
    pub fn new(phase: P) -> Result<Self, Error> {
        phase.check()?;
        Ok(Self { phase })
    }

    /// The phase function.
    pub fn phase(&self) -> &P {
        &self.phase
    }

    /// `A` in 1/(m sr), see [the crate](crate).
    pub fn airlight(&self, sigma_t: f64, segment: &Segment64) -> f64 {
        self.estimate(sigma_t, segment).value
    }

    /// `A` with a bound on its error.
    pub fn estimate(&self, sigma_t: f64, segment: &Segment64) -> Estimate {
        estimate(&self.phase, sigma_t, segment)
    }

    /// [`Exact::estimate`] of a light that is not equally bright in all
    /// directions, whose `emission` is for the same segment.
    pub fn estimate_of(&self, sigma_t: f64, segment: &Segment64, emission: &Emission) -> Estimate {
        let mut total = Estimate::default();
        for part in emission.parts(segment) {
            total += match Scaled::of_part(sigma_t, &part) {
                Extent::Empty => Estimate::default(),
                Extent::MeetsLight => MEETS_LIGHT,
                Extent::Ordinary(scaled) => {
                    let range = emission.fading_range() / scaled.unit;
                    let weight = OfLight {
                        phase: &self.phase,
                        emission,
                        unit: scaled.unit,
                    };
                    let numeric = Numeric {
                        segment: &scaled,
                        peaks: self.phase.peaks(),
                        range,
                        weight,
                    };
                    numeric.estimate()
                }
            };
        }
        total
    }
}

impl<P: Phase> Evaluator for Exact<P> {
    /// Rounded from double precision: within half a unit of the last digit,
    /// but for the 1e-12 of [`Exact::airlight`].
    fn airlight(&self, sigma_t: f32, segment: &Segment) -> f32 {
        self.estimate(sigma_t.into(), &Segment64::from(*segment))
            .value as f32
    }
}

/// [`Exact::estimate`] for a phase function that has been checked.
pub(crate) fn estimate<P: Phase>(phase: &P, sigma_t: f64, segment: &Segment64) -> Estimate {
    match Scaled::of(sigma_t, segment) {
        Extent::Empty => Estimate::default(),
        Extent::MeetsLight => MEETS_LIGHT,
        Extent::Ordinary(scaled) => match phase.constant() {
            Some(constant) => isotropic(&scaled, constant),
            None => {
                let numeric = Numeric {
                    segment: &scaled,
                    peaks: phase.peaks(),
                    range: f64::INFINITY,
                    weight: OfPhase(phase),
                };
                numeric.estimate()
            }
        },
    }
}

/// Any part of a ray that contains a light.
const MEETS_LIGHT: Estimate = Estimate {
    value: f64::INFINITY,
    bound: 0.0,
};

/// The airlight whose integral in units of the distance of the start is this.
fn finish(segment: &Scaled, integral: Estimate) -> Estimate {
    let scale = (-segment.depth).exp() / segment.unit;
    let value = scale * integral.value;
    if !value.is_finite() {
        // Lengths near the limits of f64 make the scale infinite, which gives NaN times an
        // integral of 0.
        let value = if integral.value > 0.0 { value } else { 0.0 };
        let bound = f64::INFINITY;
        return Estimate { value, bound };
    }
    // Some 20 operations, and the rounding of the exponent, which counts as
    // much as the exponent is large.
    let rounding = f64::EPSILON * (64.0 + 2.0 * segment.depth) * value;
    // The exponential and its quotient may have lost digits at the bottom of
    // the range.
    let underflow = SMALLEST * (1.0 + integral.value * (1.0 + 1.0 / segment.unit));
    Estimate {
        value,
        bound: scale * integral.bound + rounding + underflow,
    }
}

/// The spacing of the smallest numbers.
const SMALLEST: f64 = f64::MIN_POSITIVE * f64::EPSILON;

/// The airlight for a phase function of the value `constant`.
fn isotropic(segment: &Scaled, constant: f64) -> Estimate {
    let integral = if segment.sigma < THIN {
        angle_per_h(segment)
    } else {
        tail_difference(segment).unwrap_or_else(|| smooth(segment))
    };
    let value = constant * integral;
    finish(segment, Estimate { value, bound: 0.0 })
}

/// `∫ dx / d²`, the angle that the segment covers at the light over `h`.
fn angle_per_h(segment: &Scaled) -> f64 {
    let Scaled {
        s, end, h, length, ..
    } = *segment;
    let (across, along, per_h) = if length == f64::INFINITY {
        (h, s, 1.0 / s)
    } else {
        let along = h * h + s * end;
        (h * length, along, length / along)
    };
    let ratio = across / along;
    if along > 0.0 && ratio < 1e-4 {
        // The arctangent divided by h, where h may be 0.
        let r2 = ratio * ratio;
        per_h * (1.0 - r2 * (1.0 / 3.0 - r2 * (0.2 - r2 / 7.0)))
    } else {
        across.atan2(along) / h
    }
}

/// `2σ (R_a − e^{−Δy} R_b)`, unless that loses more than one bit.
fn tail_difference(segment: &Scaled) -> Option<f64> {
    let Scaled {
        sigma,
        s,
        end,
        h,
        length,
        end_distance,
        ..
    } = *segment;
    // s + d without cancellation.
    let along = |s: f64, d: f64| {
        if s < 0.0 { h * (h / (d - s)) } else { s + d }
    };
    let first = along(s, 1.0);
    if length == f64::INFINITY {
        return Some(2.0 * sigma * tail(sigma * first, sigma * h));
    }
    let last = along(end, end_distance);
    let growth = length * ((first + last) / (1.0 + end_distance));
    // R falls no faster than 1/y², and the exponential is that of the growth. If neither
    // changes much, more than half is left behind the end: there is no need to compute it.
    if sigma * growth < 0.1 && growth <= 0.1 * first {
        return None;
    }
    let whole = tail(sigma * first, sigma * h);
    let rest = (-sigma * growth).exp() * tail(sigma * last, sigma * h);
    (rest <= 0.5 * whole).then_some(2.0 * sigma * (whole - rest))
}

/// The integral over a part that ends before half of the light of an endless
/// ray has come together. Over such a part the exponential falls to no less
/// than a half, and on either side of the foot point the rest of the integrand
/// is as smooth as `1/(1 + b²)` between 0 and 1: the error of the rule is
/// below 1e-16.
fn smooth(segment: &Scaled) -> f64 {
    static RULE: LazyLock<Rule> = LazyLock::new(|| Rule::of(16));
    Side::both(segment, [1.0, 1.0], THIN)
        .map(|side| {
            let sum: f64 = RULE
                .iter()
                .map(|(t, weight)| weight * without_phase(&side, side.extent * t))
                .sum();
            side.extent * sum
        })
        .sum()
}

/// Everything of the integrand but the phase function.
fn without_phase(side: &Side, offset: f64) -> f64 {
    let (a, b) = (side.a, side.b(offset));
    let exponential = (-(side.depth + side.rate * offset)).exp();
    2.0 * side.scale * exponential / (a * a + b * b)
}

/// The same over [`NODES`] offsets, and
/// the angles of scattering.
#[inline(always)]
fn at(side: &Side, offsets: &[f64; NODES]) -> ([ScatteringAngle<f64>; NODES], [f64; NODES]) {
    let mut angles = [ScatteringAngle::from_half_tangent(1.0, 1.0); NODES];
    let mut rest = [0.0; NODES];
    let is_thin = side.kind == Kind::Thin;
    for i in 0..NODES {
        let (a, b) = (side.a, side.b(offsets[i]));
        let (numerator, denominator) = if is_thin { (a, b) } else { (b, a) };
        angles[i] = ScatteringAngle::from_half_tangent(numerator, denominator);
        let exponential = simd::exp(-(side.depth + side.rate * offsets[i]));
        rest[i] = 2.0 * side.scale * exponential / (a * a + b * b);
    }
    (angles, rest)
}

/// The share of the range of a light up to which fading does not matter: it
/// changes the light by its fourth power.
const UNFADED: f64 = 1e-4;

/// The most that `b` may grow, and the exponent, over a piece: with these the rules
/// agree to about 1e-15.
const GROWTH: f64 = 2.5;
const FADE: f64 = 12.0;

/// The share of the light in front that may be behind the last piece.
const CUT_OFF: f64 = 1e-18;

/// The weight of light along a ray: a phase function, or a function in place of it.
trait Weight {
    /// Its values at offsets of a side. Must be `#[inline(always)]`, as
    /// [`Integrand::values`].
    fn values(
        &self,
        side: &Side,
        offsets: &[f64; NODES],
        angles: &[ScatteringAngle<f64>; NODES],
    ) -> [f64; NODES];
}

/// A phase function alone.
struct OfPhase<'a, P>(&'a P);

impl<P: Phase> Weight for OfPhase<'_, P> {
    #[inline(always)]
    fn values(
        &self,
        _: &Side,
        _: &[f64; NODES],
        angles: &[ScatteringAngle<f64>; NODES],
    ) -> [f64; NODES] {
        let mut values = [0.0; NODES];
        self.0.values_f64(angles, &mut values);
        values
    }
}

/// With the emission of a light, in units of a segment.
struct OfLight<'a, P> {
    phase: &'a P,
    emission: &'a Emission,
    unit: f64,
}

impl<P: Phase> Weight for OfLight<'_, P> {
    #[inline(always)]
    fn values(
        &self,
        side: &Side,
        offsets: &[f64; NODES],
        angles: &[ScatteringAngle<f64>; NODES],
    ) -> [f64; NODES] {
        std::array::from_fn(|i| {
            let d = side.distance(offsets[i]) * self.unit;
            self.phase.value_f64(angles[i]) * self.emission.factor(angles[i], d)
        })
    }
}

/// The airlight for any weight in place of the phase function. If that fades, it is
/// towards a range, in units of the segment.
struct Numeric<'a, W> {
    segment: &'a Scaled,
    peaks: [f64; 2],
    range: f64,
    weight: W,
}

/// Its sides.
struct Sides<W> {
    sides: [Option<Side>; 2],
    weight: W,
}

impl<W: Weight> Integrand for Sides<W> {
    #[inline(always)]
    fn values(&self, side: usize, offsets: &[f64; NODES]) -> [f64; NODES] {
        let Some(side) = &self.sides[side] else {
            return [0.0; NODES];
        };
        let (angles, rest) = at(side, offsets);
        let mut values = self.weight.values(side, offsets, &angles);
        for (value, rest) in values.iter_mut().zip(rest) {
            *value *= rest;
        }
        values
    }
}

impl<W: Weight> WithSimd for Numeric<'_, W> {
    type Output = Estimate;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Estimate {
        let Self {
            segment,
            peaks,
            range,
            weight,
        } = self;
        let mut sides = [None; 2];
        for (slot, side) in
            sides
                .iter_mut()
                .zip(Side::both(segment, peaks, THIN * peaks[1].min(1.0)))
        {
            *slot = Some(side.fading(range, UNFADED));
        }
        let integrand = Sides { sides, weight };
        // How much brighter the backward peak may be than what is in front of it.
        let peak = peaks[1].clamp(SHARPEST, 1.0).powi(-3);
        let mut pieces = Adaptive::default();
        let mut sum = 0.0;
        for (index, side) in sides.iter().enumerate() {
            let Some(side) = side else { continue };
            let mut start = 0.0;
            while side.reaches(start, OPAQUE) && !(side.left(start) * peak < CUT_OFF * sum) {
                let end = side.next(start, GROWTH, FADE);
                sum += pieces.add(index, start, end, &integrand);
                start = end;
            }
        }
        finish(segment, pieces.refine(&integrand))
    }
}

impl<W: Weight> Numeric<'_, W> {
    fn estimate(self) -> Estimate {
        simd::arch().dispatch(self)
    }
}

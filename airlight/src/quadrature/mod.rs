//! Airlight by quadrature in single precision, for any phase function.
//!
//! The equi-angular variable of Kulla and Fajardo, Importance sampling
//! techniques for path tracing in participating media, 2012, removes the
//! inverse square, but leaves the exponential, which has a layer next to the
//! far end: a fixed number of nodes stalls at half a percent beside a lamp.
//! Here the variable is the half-angle tangent `b = (s + d)/h` (or its
//! reciprocal), in which the integrand is a product of a rational function and
//! one exponential. Its singularities are at imaginary `b`, at any scale: it
//! is cut into pieces over which `b` changes by no more than a factor and
//! the exponent by no more than an amount, and on each a few Gauss–Legendre
//! nodes converge at a rate that no input can spoil.

mod batch;
#[cfg(feature = "wgsl")]
mod gpu;
mod nodes;
mod piece;
pub mod profile;
#[cfg(test)]
mod tests;

use crate::scaled::{Extent, Scaled};
use crate::{
    Emission, Error, Evaluator, Phase, PhaseFunction, ScatteringAngle, Segment, Segment64, gauss,
    simd,
};
use batch::{Batch, Cuts};
pub use piece::Node;
use piece::{Rule, Span};

/// Integrates over segments with a few nodes each, in single precision.
///
/// A segment is cut into pieces, most into one to three; each gets
/// Gauss–Legendre nodes. With [`Quadrature::with_tolerance`] their number is
/// chosen from how much changes over the piece: a short step of a march gets
/// one or two. It holds for every segment whose result is a normal `f32`, next
/// to the light and through any optical depth.
///
/// | nodes per piece | largest relative error, no peak | sharp peaks |
/// |---:|---:|---:|
/// | 2 | 8e-2 | 4e-1 |
/// | 3 | 8e-3 | 7e-2 |
/// | 4 | 8e-4 | 2e-2 |
/// | 5 | 7e-5 | 3e-3 |
/// | 6 | 6e-6 | 9e-4 |
/// | 7 | 1e-6 | 1.2e-4 |
/// | 8 | 1e-6 | 4e-5 |
/// | 10 | 1e-6 | 4e-6 |
///
/// measured over rays at all angles from 0 to π, distances from 1e-6 m to
/// 1e6 m, optical depths up to the end of the range and parts of 1e-9 of the
/// distance to infinity; sharp peaks are those of |g| and |k| up to 0.99, and
/// the largest errors are those of Schlick's function.
/// The last two lines of the table are the rounding of `f32`.
///
/// Batches are vectors for tolerances from 1e-5 up and for up to 5 nodes, and take a
/// tenth of the time then. They keep the tolerance, but a segment may get more nodes
/// for the sake of those beside it: within the tolerance its value depends on the slice
/// that it is in. Finer ones go through single segments.
///
/// The light on the segment gives +∞; a length of 0, and numbers that are no
/// lengths or no extinction, give 0, as with [`Exact`](crate::Exact).
#[derive(Debug, Clone, PartialEq)]
pub struct Quadrature<P = PhaseFunction> {
    phase: P,
    peaks: [f64; 2],
    /// The rules that a piece may get, by growing number of nodes, and the
    /// most that a piece may span for each; the last one serves all.
    rules: Vec<(Rule, Span)>,
    /// How many of them a piece may get if no more nodes are asked for.
    plain: usize,
    /// Optical depth after which nothing that counts is left.
    opacity: f64,
    /// Growth of the distance from the light after which nothing is left.
    far: f64,
    tolerance: f32,
    /// How batches are cut.
    cuts: Cuts,
}

/// Absorption below which it is ignored behind the foot point, times the width
/// of the backward peak, which is lit from as much farther away: its effect,
/// 2e-8, is below half a unit of the last digit.
const THIN: f64 = 1e-9;

/// The most that `b`, and the exponent, may change over a piece. Twice the
/// logarithm needs twice the nodes, so that the cost hardly depends on it.
const GROWTH: f64 = 8.0;
const FADE: f64 = 4.0;

/// Rules beyond the one that the longest piece needs, for pieces in deep fog that
/// are longer.
const ROOM: usize = 2;

/// m per m: an `f32` can square this and twice as much of it.
const FARTHEST: f64 = (1_u64 << 60) as f64;

/// The rounding error of single precision, measured with more nodes than are needed.
const ROUNDING: f64 = 5e-7;

/// The share of what is cut off, where the number of nodes is given.
const CUT_OFF: f64 = 1e-7;

impl<P: Phase> Quadrature<P> {
    /// With the same number of nodes on every piece.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless there are 1 to 4096 nodes and the parameter
    /// of the phase function is in range.
    pub fn fixed(phase: P, nodes: u32) -> Result<Self, Error> {
        gauss::check(nodes)?;
        let cuts = Cuts::fixed(Rule::of(nodes));
        Self::new(
            phase,
            vec![(Rule::of(nodes), Span::default())],
            CUT_OFF,
            cuts,
        )
    }

    /// With as few nodes as keep the relative error below `tolerance`, for a
    /// phase function as smooth as its [`peaks`](Phase::peaks) and its
    /// [`steepness`](Phase::steepness) say: those of this crate up to |g| = 0.9999
    /// and |k| = 0.9999. Two batches that share a segment may differ there by as much
    /// as the tolerance allows.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless the tolerance is between 1e-6 and 0.1 and
    /// the parameter of the phase function is in range.
    pub fn with_tolerance(phase: P, tolerance: f32) -> Result<Self, Error> {
        if !(1e-6..=0.1).contains(&tolerance) {
            return Err(Error::bad_value(
                "the tolerance of a quadrature",
                tolerance,
                "1e-6 to 0.1",
            ));
        }
        // The constants of the rules were fitted to some cases. The rest of the tolerance is
        // for other cases, for what is cut off, and for the errors of pieces, which add up.
        let error = 0.25 * (f64::from(tolerance) - ROUNDING);
        let steepness = phase.steepness();
        let mut rules = Vec::new();
        let most = Span::largest(GROWTH, FADE);
        loop {
            let nodes = rules.len() as u32 + 1;
            let span = Span::of_rule(nodes, error, steepness);
            rules.push((Rule::of(nodes), span));
            let enough = rules.len().checked_sub(1 + ROOM).map(|i| &rules[i].1);
            if enough.is_some_and(|span| most.within(span)) {
                break;
            }
        }
        let plain = rules.len();
        for nodes in (plain as u32 + 1..).take(profile::MOST) {
            rules.push((Rule::of(nodes), Span::of_rule(nodes, error, steepness)));
        }
        let cuts = Cuts::of(error, steepness);
        let quadrature = Self::new(phase, rules, 0.1 * error, cuts)?;
        Ok(Self {
            plain,
            tolerance,
            ..quadrature
        })
    }

    fn new(phase: P, rules: Vec<(Rule, Span)>, error: f64, cuts: Cuts) -> Result<Self, Error> {
        phase.check()?;
        let peaks = phase.peaks();
        // How much brighter the backward peak, behind everything that is to be
        // cut off, may be than what is in front of it.
        let peak = peaks[1].clamp(1e-4, 1.0).powi(-3);
        Ok(Self {
            phase,
            peaks,
            plain: rules.len(),
            rules,
            opacity: (peak / error).ln(),
            far: (peak / error).min(FARTHEST),
            tolerance: 0.0,
            cuts,
        })
    }

    /// The tolerance it was made for; 0 for a given number of nodes.
    pub fn tolerance(&self) -> f32 {
        self.tolerance
    }

    /// The Gauss–Legendre rule of `nodes` nodes for a piece of the caller's own,
    /// positions from 0 to 1 and weights that sum to 1: the one with the nearest
    /// number if there is none, which is the only one of
    /// [`Quadrature::fixed`]. Made for a tolerance it has those of 1 to at least 6.
    pub fn rule(&self, nodes: usize) -> &[(f32, f32)] {
        let last = self.rules.len() - 1;
        self.rules[nodes.saturating_sub(1).min(last)].0.nodes()
    }

    /// The phase function.
    pub fn phase(&self) -> &P {
        &self.phase
    }

    /// [`Evaluator::airlight`] of a light that is not equally bright in all
    /// directions, whose `emission` is for the same segment.
    pub fn airlight_of(&self, sigma_t: f32, segment: &Segment, emission: &Emission) -> f32 {
        let mut total = 0.0;
        for part in emission.parts(&Segment64::from(*segment)) {
            let scaled = match Scaled::of_part(sigma_t.into(), &part) {
                Extent::Empty => continue,
                Extent::MeetsLight => return f32::INFINITY,
                Extent::Ordinary(scaled) => scaled,
            };
            let (scaled, brighter) = scaled.in_singles();
            let sum: f64 = self
                .places(scaled, *emission, part, 0)
                .map(|(node, depth)| {
                    let phase = self.phase.value_f32(node.angle) * (-depth).exp();
                    f64::from(node.weight) * f64::from(phase)
                })
                .sum();
            let value = (-scaled.depth).exp() * brighter * sum;
            // Lengths near the limits of the range give infinity times 0.
            total += if value.is_nan() { 0.0 } else { value };
        }
        total as f32
    }

    fn integrate(
        &self,
        sigma_t: f32,
        segment: &Segment64,
        weight: impl Fn(ScatteringAngle<f32>) -> f32,
    ) -> f64 {
        let scaled = match Scaled::of(sigma_t.into(), segment) {
            Extent::Empty => return 0.0,
            Extent::MeetsLight => return f64::INFINITY,
            Extent::Ordinary(scaled) => scaled,
        };
        let (scaled, brighter) = scaled.in_singles();
        let mut total = 0.0;
        for (piece, rule) in self.pieces(scaled, 0) {
            let mut sum = 0.0;
            for &(t, share) in rule.nodes() {
                let (node, depth) = piece.at(t);
                sum += share * node.weight * weight(node.angle) * (-depth).exp();
            }
            total += f64::from(sum);
        }
        let value = (-scaled.depth).exp() * brighter / scaled.unit * total;
        // Lengths near the limits of the range give infinity times 0.
        if value.is_nan() { 0.0 } else { value }
    }

    /// Whether the tolerance is so coarse that the rounding of vectors does not count.
    fn is_coarse(&self) -> bool {
        const FINEST: f32 = 1e-5;
        const MOST_NODES: usize = 5;
        if self.tolerance > 0.0 {
            self.tolerance >= FINEST
        } else {
            self.rules[0].0.nodes().len() <= MOST_NODES
        }
    }

    fn thin(&self) -> f64 {
        THIN * self.peaks[1].min(1.0)
    }
}

impl<P: Phase> Evaluator for Quadrature<P> {
    fn airlight(&self, sigma_t: f32, segment: &Segment) -> f32 {
        let segment = Segment64::from(*segment);
        self.integrate(sigma_t, &segment, |angle| self.phase.value_f32(angle)) as f32
    }

    fn airlight_batch(&self, sigma_t: f32, segments: &[Segment], airlight: &mut [f32]) {
        assert_eq!(segments.len(), airlight.len(), "one result per segment");
        if !(0.0..f32::INFINITY).contains(&sigma_t) {
            airlight.fill(0.0);
            return;
        }
        if !self.is_coarse() {
            for (segment, airlight) in segments.iter().zip(airlight) {
                *airlight = self.airlight(sigma_t, segment);
            }
            return;
        }
        let batch = Batch {
            quadrature: self,
            sigma_t: sigma_t.into(),
        };
        simd::batch(&batch, segments, airlight);
    }
}

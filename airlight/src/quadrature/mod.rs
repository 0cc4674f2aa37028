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

#[cfg(feature = "wgpu")]
mod gpu;
mod piece;
pub mod profile;
#[cfg(test)]
mod tests;

use crate::emission::Part;
use crate::side::{Extent, Kind, Scaled, Side};
use crate::{
    Emission, Error, Evaluator, Phase, PhaseFunction, ScatteringAngle, Segment, Segment64, gauss,
};
use piece::{Piece, Place, Rule, Span};
use profile::Pattern;

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
/// distance to infinity; sharp peaks are those
/// of |g| and |k| up to 0.99, the largest errors those of Schlick's function.
/// The last two lines of the table are the rounding of `f32`.
///
/// The light on the segment gives +∞; a length of 0, and numbers that are no
/// lengths or no extinction, give 0.
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
}

/// Where to evaluate an integrand along a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Distance along the ray from the start of the segment, m.
    pub distance: f32,
    /// `Σ weight f ≈ ∫ f / d² dx`, 1/m.
    pub weight: f32,
    /// The angle by which light is scattered there.
    pub angle: ScatteringAngle<f32>,
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

/// What single precision rounds, measured with more nodes than are needed.
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
        Self::new(phase, vec![(Rule::of(nodes), Span::default())], CUT_OFF)
    }

    /// With as few nodes as keep the relative error below `tolerance`, for a
    /// phase function as smooth as its [`peaks`](Phase::peaks) and its
    /// [`steepness`](Phase::steepness) say: those of this crate up to |g| = 0.99
    /// and |k| = 0.99. Beyond, the rounding of single precision next to the peak
    /// misses a tolerance of 1e-6.
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
        // The constants of the rules were fitted to cases: the rest is for what
        // is cut off, where pieces add up, and for other cases.
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
        let quadrature = Self::new(phase, rules, 0.1 * error)?;
        Ok(Self {
            plain,
            ..quadrature
        })
    }

    fn new(phase: P, rules: Vec<(Rule, Span)>, error: f64) -> Result<Self, Error> {
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
        })
    }

    /// The phase function.
    pub fn phase(&self) -> &P {
        &self.phase
    }

    /// Nodes for an integrand of the caller's own:
    ///
    /// ```text
    /// ∫ f(x) / d² dx ≈ Σ weight f(x_a + distance)
    /// ```
    ///
    /// for an `f` that is smooth over the segment and of the kind `p exp(−σ_t
    /// (x + d))` times what varies slowly. If several extinctions are
    /// integrated over the same nodes, `sigma_t` is the least: beyond its depth
    /// nothing is looked at. What `f` varies otherwise takes `extra` nodes more
    /// on each piece, 2 for a light outside of the medium; lights with a pattern
    /// have [`Quadrature::nodes_of`]. No piece gets more nodes than the largest
    /// rule has, which is the only one of [`Quadrature::fixed`]. The nodes are in
    /// no particular order. No node if the segment is empty or meets the light.
    pub fn nodes(
        &self,
        sigma_t: f32,
        segment: &Segment,
        extra: usize,
    ) -> impl Iterator<Item = Node> {
        // How much light is left at its start is the caller's business.
        let scaled = match Scaled::of_lengths(sigma_t.into(), &Segment64::from(*segment)) {
            Extent::Ordinary(scaled) => Some(scaled),
            Extent::Empty | Extent::MeetsLight => None,
        };
        let length = segment.length;
        scaled.into_iter().flat_map(move |scaled| {
            let per_metre = (1.0 / scaled.unit) as f32;
            self.pieces(scaled, extra).flat_map(move |(piece, rule)| {
                rule.nodes().iter().map(move |&(t, weight)| {
                    let mut node = piece.at(t).0;
                    node.weight *= weight * per_metre;
                    // Rounding may have taken it past the end.
                    node.distance = node.distance.clamp(0.0, length);
                    node
                })
            })
        })
    }

    /// [`Quadrature::nodes`] of a light that is not equally bright in all
    /// directions, whose `emission` is for the same segment and a factor of the
    /// weights:
    ///
    /// ```text
    /// ∫ e(x) f(x) / d² dx ≈ Σ weight f(x_a + distance)
    /// ```
    ///
    /// The segment is divided where the emission is not smooth, and each piece has
    /// as many nodes more as the emission asks for, see [`profile`], besides the
    /// `extra` nodes for what else `f` varies. The tolerance is kept relative to
    /// this light's own airlight, for cones of 0.1° to 180°, lights of limited
    /// range and rays that graze either. With [`Quadrature::fixed`] all pieces
    /// have the same number of nodes.
    pub fn nodes_of(
        &self,
        sigma_t: f32,
        segment: &Segment64,
        emission: &Emission,
        extra: usize,
    ) -> impl Iterator<Item = Node> {
        let Segment64 { s, length, .. } = *segment;
        let emission = *emission;
        emission.parts(segment).flat_map(move |part| {
            let scaled = match Scaled::of_lengths(sigma_t.into(), &part.segment) {
                Extent::Ordinary(scaled) => Some(scaled),
                Extent::Empty | Extent::MeetsLight => None,
            };
            let before = part.segment.s - s;
            let nodes = scaled.map(|scaled| self.places(scaled, emission, part, extra));
            nodes.into_iter().flatten().map(move |(node, _)| Node {
                // Rounding may have taken it past the end.
                distance: (before + f64::from(node.distance)).clamp(0.0, length) as f32,
                ..node
            })
        })
    }

    /// [`Evaluator::airlight`] of a light that is not equally bright in all
    /// directions, whose `emission` is for the same segment.
    pub fn airlight_of(&self, sigma_t: f32, segment: &Segment, emission: &Emission) -> f32 {
        let mut total = 0.0;
        for part in emission.parts(&Segment64::from(*segment)) {
            let scaled = match Scaled::of(sigma_t.into(), &part.segment) {
                Extent::Empty => continue,
                Extent::MeetsLight => return f32::INFINITY,
                Extent::Ordinary(scaled) => scaled,
            };
            let sum: f64 = self
                .places(scaled, *emission, part, 0)
                .map(|(node, depth)| {
                    let light = node.weight * self.phase.value_f32(node.angle);
                    f64::from(light * (-depth).exp())
                })
                .sum();
            let value = (-scaled.depth).exp() * sum;
            // Lengths near the limits of the range: infinity times nothing.
            total += if value.is_nan() { 0.0 } else { value };
        }
        total as f32
    }

    /// The nodes of a part with the emission in their weights, 1/m, their
    /// distances from the start of the part, m, and the optical depth since
    /// there.
    fn places(
        &self,
        scaled: Scaled,
        emission: Emission,
        part: Part,
        extra: usize,
    ) -> impl Iterator<Item = (Node, f32)> {
        let pattern = Pattern::new(&emission, &part);
        let plain = pattern.extra == 0;
        let deeper = if plain { 0.0 } else { profile::DEEPER };
        let range = emission.fading_range() / scaled.unit;
        let extra = pattern.extra.saturating_add(extra);
        let per_metre = 1.0 / scaled.unit;
        let sides = self.sides(scaled, deeper);
        let pieces = sides.flat_map(move |side| {
            let side = side.fading(range, profile::UNFADED);
            self.cut(side, scaled.unit, extra)
                .map(move |(piece, rule, [start, end])| {
                    (piece, rule, pattern.on(&side, start, end))
                })
        });
        pieces.flat_map(move |(piece, rule, profile)| {
            rule.nodes().iter().map(move |&(t, weight)| {
                let Place {
                    mut node,
                    depth,
                    share,
                    squares,
                } = piece.place(t);
                let emitted = profile.at(share, squares, node.distance);
                node.weight = (f64::from(node.weight * weight * emitted) * per_metre) as f32;
                (node, depth)
            })
        })
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
        let mut total = 0.0;
        for (piece, rule) in self.pieces(scaled, 0) {
            let mut sum = 0.0;
            for &(t, share) in rule.nodes() {
                let (node, depth) = piece.at(t);
                sum += share * node.weight * weight(node.angle) * (-depth).exp();
            }
            total += f64::from(sum);
        }
        let value = (-scaled.depth).exp() / scaled.unit * total;
        // Lengths near the limits of the range: infinity times nothing.
        if value.is_nan() { 0.0 } else { value }
    }

    fn thin(&self) -> f64 {
        THIN * self.peaks[1].min(1.0)
    }

    /// The pieces of a segment and a rule for each, with `extra` nodes.
    fn pieces(&self, segment: Scaled, extra: usize) -> impl Iterator<Item = (Piece, &Rule)> {
        self.sides(segment, 0.0).flat_map(move |side| {
            self.cut(side, segment.unit, extra)
                .map(|(piece, rule, _)| (piece, rule))
        })
    }

    /// The sides of a segment up to where nothing that counts is left, looked at
    /// this much deeper than a plain light needs.
    fn sides(&self, segment: Scaled, deeper: f64) -> impl Iterator<Item = Side> + use<P> {
        let opacity = self.opacity + deeper;
        let far = (self.far * deeper.exp()).min(FARTHEST);
        Side::both(&segment, self.peaks, self.thin()).map(move |mut side| {
            if side.rate > 0.0 {
                side.extent = side.extent.min((opacity - side.depth) / side.rate);
            }
            if side.kind == Kind::Behind {
                side.extent = side.extent.min(far);
            }
            side
        })
    }

    /// The pieces of a side, with `extra` nodes, and between which offsets they
    /// are.
    fn cut(
        &self,
        side: Side,
        unit: f64,
        extra: usize,
    ) -> impl Iterator<Item = (Piece, &Rule, [f64; 2])> {
        let mut start = 0.0;
        std::iter::from_fn(move || {
            (start < side.extent).then(|| {
                let end = side.next(start, GROWTH, FADE);
                let (piece, span) = Piece::new(&side, start, end, unit);
                let ends = [start, end];
                start = end;
                (piece, self.rule(span, extra), ends)
            })
        })
    }

    fn rule(&self, span: Span, extra: usize) -> &Rule {
        let plain = self.plain - 1;
        let found = self.rules[..plain]
            .iter()
            .position(|(_, most)| span.within(most));
        let last = self.rules.len() - 1;
        &self.rules[found.unwrap_or(plain).saturating_add(extra).min(last)].0
    }
}

impl<P: Phase> Evaluator for Quadrature<P> {
    fn airlight(&self, sigma_t: f32, segment: &Segment) -> f32 {
        let segment = Segment64::from(*segment);
        self.integrate(sigma_t, &segment, |angle| self.phase.value_f32(angle)) as f32
    }
}

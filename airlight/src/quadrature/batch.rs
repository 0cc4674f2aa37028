//! Quadrature over blocks of segments.
//!
//! The sides of a segment are found in double precision, as for a segment by
//! itself; what follows are sums of positive numbers, for which single precision is
//! enough. A group of segments goes through its pieces together: each piece of
//! the group gets the rule that its hardest segment needs, and segments that have
//! come to their end wait for the others. That makes pieces expensive and nodes cheap,
//! so that pieces are longer here and have more nodes.
//!
//! With AVX-512 an ordinary segment takes about 30 cycles for isotropic scattering and
//! 40 for Henyey and Greenstein's function. Arithmetic binds: a dozen divisions and
//! roots in double precision to find the sides, and a division and an exponential for
//! each node, a root and a division more for most phase functions.

#![allow(
    clippy::needless_range_loop,
    reason = "steps over a dozen arrays at once, which zipped would be unreadable"
)]

use super::piece::{Rule, Span};
use super::{Quadrature, ROOM};
use crate::scaled::{NEAREST_OF_SINGLES, SHORTEST_OF_SINGLES, Scaled};
use crate::side::{Kind, Side};
use crate::simd::{Kernel, LANES, Lanes, exp, exp2};
use crate::table::{known, settle};
use crate::{Phase, ScatteringAngle, Segment, Segment64};
use std::f64::consts::LOG2_E;

/// Segments that go through their pieces together.
const GROUP: usize = 32;

/// The most that `b`, and the exponent, may change over a piece.
const GROWTH: f64 = 64.0;
const FADE: f64 = 16.0;

/// The largest `finest` in units of b, which stands for the infinite one on the axis.
const WIDEST: f64 = 1e30;

/// How the pieces of batches are cut, and their rules.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cuts {
    growth: f32,
    fade: f32,
    /// By growing number of nodes; the last one is for pieces that no other is good enough for.
    rules: Vec<CutRule>,
}

#[derive(Debug, Clone, PartialEq)]
struct CutRule {
    rule: Rule,
    /// The least `alpha` of pieces in front of the foot point, and behind it.
    least: [f32; 2],
    /// The most that the exponent may change, over ln 2.
    depth: f32,
}

impl Cuts {
    /// Cuts with this rule alone.
    pub(super) fn fixed(rule: Rule) -> Self {
        Self {
            growth: super::GROWTH as f32,
            fade: super::FADE as f32,
            rules: vec![CutRule {
                rule,
                least: [0.0; 2],
                depth: 0.0,
            }],
        }
    }

    /// Cuts with as many rules as this relative error needs.
    pub(super) fn of(error: f64, steepness: f64) -> Self {
        let most = Span::largest(GROWTH, FADE);
        let mut rules = Vec::new();
        let mut room = 0;
        for nodes in 1.. {
            let span = Span::of_rule(nodes, error, steepness);
            rules.push(CutRule {
                rule: Rule::of(nodes),
                least: span.least_alphas().map(|alpha| alpha as f32),
                depth: (span.depth() * LOG2_E) as f32,
            });
            room += usize::from(most.within(&span));
            if room > ROOM {
                break;
            }
        }
        Self {
            growth: GROWTH as f32,
            fade: FADE as f32,
            rules,
        }
    }

    fn rule(&self, least: [u32; 2], deepest: u32) -> &Rule {
        let [front, behind] = least.map(f32::from_bits);
        let deepest = f32::from_bits(deepest);
        let is_enough = |rule: &&CutRule| {
            front >= rule.least[0] && behind >= rule.least[1] && deepest <= rule.depth
        };
        let last = &self.rules[self.rules.len() - 1];
        &self.rules.iter().find(is_enough).unwrap_or(last).rule
    }
}

/// One side of each segment of a block, see [`Side`].
#[derive(Debug, Default)]
struct SideLanes {
    a: Lanes<f32>,
    unit: Lanes<f32>,
    base: Lanes<f32>,
    /// Divided by `unit`.
    finest: Lanes<f32>,
    scale: Lanes<f32>,
    /// Divided by ln 2, and so is `rate`.
    depth: Lanes<f32>,
    rate: Lanes<f32>,
    /// The offset over which the exponent grows by as much as a piece may have.
    fade: Lanes<f32>,
    extent: Lanes<f32>,
    is_thin: Lanes<u32>,
    /// In front of the foot point, where nothing is thin.
    is_front: bool,
}

impl SideLanes {
    #[inline(always)]
    fn set(&mut self, i: usize, side: &Side, fade: f64) {
        let finest = side.finest / side.unit;
        let finest = if finest < WIDEST { finest } else { WIDEST };
        self.a.0[i] = side.a as f32;
        self.unit.0[i] = side.unit as f32;
        self.base.0[i] = side.base as f32;
        self.finest.0[i] = finest as f32;
        self.scale.0[i] = (2.0 * side.scale) as f32;
        self.depth.0[i] = (side.depth * LOG2_E) as f32;
        self.rate.0[i] = (side.rate * LOG2_E) as f32;
        self.fade.0[i] = (fade / side.rate) as f32;
        self.extent.0[i] = side.extent as f32;
        self.is_thin.0[i] = u32::from(side.kind == Kind::Thin);
    }
}

/// A piece of each segment of a group, see [`super::piece::Piece`].
#[derive(Debug)]
struct Pieces {
    alpha: [f32; GROUP],
    a: [f32; GROUP],
    b: [f32; GROUP],
    b_change: [f32; GROUP],
    depth: [f32; GROUP],
    depth_change: [f32; GROUP],
    scale: [f32; GROUP],
    is_thin: [u32; GROUP],
}

/// Whether [`Scaled::in_singles`] may change a segment: for each that it does change.
#[inline(always)]
fn may_be_extreme(segment: &Segment) -> bool {
    let [s, h] = [segment.s, segment.h].map(|x| f64::from(x.abs()));
    let is_short = f64::from(segment.length) < 2.0 * SHORTEST_OF_SINGLES * (s + h);
    (h < 2.0 * NEAREST_OF_SINGLES * s) | is_short
}

/// Values that pass between the loops of a block.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    sides: [SideLanes; 2],
    /// What is left of the light at the start of the segment, over the unit.
    factor: Lanes<f64>,
    sum: Lanes<f32>,
}

/// A quadrature and an extinction.
pub(super) struct Batch<'a, P> {
    pub(super) quadrature: &'a Quadrature<P>,
    pub(super) sigma_t: f64,
}

impl<P: Phase> Batch<'_, P> {
    /// `EXTREME` if one of the segments may come so close to the light, or be so short, that
    /// single precision needs another in its place.
    #[inline(always)]
    fn find_sides<const EXTREME: bool>(&self, scratch: &mut Scratch, segments: &[Segment; LANES]) {
        let quadrature = self.quadrature;
        let thin = quadrature.thin();
        let (opacity, far) = (quadrature.opacity, quadrature.far);
        let fade = f64::from(quadrature.cuts.fade);
        for i in 0..LANES {
            let scaled = Scaled::of_singles(self.sigma_t, &Segment64::from(segments[i]));
            let (scaled, brighter) = if EXTREME {
                scaled.in_singles()
            } else {
                (scaled, 1.0)
            };
            scratch.factor.0[i] = exp(-scaled.depth) * (brighter / scaled.unit);
            let mut front = Side::front(&scaled, quadrature.peaks);
            let mut behind = Side::behind(&scaled, quadrature.peaks, thin);
            front.reach(opacity, far);
            behind.reach(opacity, far);
            scratch.sides[0].set(i, &front, fade);
            scratch.sides[1].set(i, &behind, fade);
        }
    }

    /// The next piece of each segment of a group, and the rule for all of them. Pieces begin
    /// at the offsets `from`, which become those of their ends. None if all segments have come
    /// to their end.
    #[inline(always)]
    fn next(
        &self,
        side: &SideLanes,
        first: usize,
        from: &mut [f32; GROUP],
    ) -> Option<(Pieces, &Rule)> {
        let mut pieces = Pieces {
            alpha: [0.0; GROUP],
            a: [0.0; GROUP],
            b: [0.0; GROUP],
            b_change: [0.0; GROUP],
            depth: [0.0; GROUP],
            depth_change: [0.0; GROUP],
            scale: [0.0; GROUP],
            is_thin: [0; GROUP],
        };
        let growth = self.quadrature.cuts.growth - 1.0;
        let one = 1.0_f32.to_bits();
        let (mut least_front, mut least_behind, mut deepest, mut left) = (one, one, 0, 0);
        let is_front = side.is_front;
        for i in 0..GROUP {
            let k = first + i;
            let start = from[i];
            let (extent, rate) = (side.extent.0[k], side.rate.0[k]);
            left += u32::from(start < extent);
            let rest = if start < extent { extent - start } else { 0.0 };
            let at = side.base.0[k] + start;
            let wide = growth * (at + side.finest.0[k]);
            let fade = side.fade.0[k];
            let faded = if start > fade { start } else { fade };
            let width = if wide < faded { wide } else { faded };
            // The negations make NaN the last piece of a segment, too.
            let is_last = !(rest > 1.1 * width) | !(width > 0.0);
            let width = if is_last { rest } else { width };
            from[i] = if is_last { extent } else { start + width };
            let blurred = at + side.finest.0[k];
            let alpha = (blurred / (blurred + width)).sqrt();
            // The numbers of a side without extent mean nothing and must not choose the rule.
            let change = if rest > 0.0 { rate * width } else { 0.0 };
            pieces.alpha[i] = alpha;
            pieces.a[i] = side.a.0[k];
            pieces.b[i] = side.unit.0[k] * at;
            pieces.b_change[i] = side.unit.0[k] * width;
            pieces.depth[i] = side.depth.0[k] + rate * start;
            pieces.depth_change[i] = change;
            pieces.scale[i] = side.scale.0[k] * width;
            pieces.is_thin[i] = side.is_thin.0[k];
            let is_behind = (side.is_thin.0[k] == 0) & !is_front;
            let bits = alpha.to_bits();
            let (in_front, behind) = if is_behind { (one, bits) } else { (bits, one) };
            least_front = least_front.min(in_front);
            least_behind = least_behind.min(behind);
            deepest = deepest.max(change.to_bits());
        }
        let rule = self
            .quadrature
            .cuts
            .rule([least_front, least_behind], deepest);
        (left > 0).then_some((pieces, rule))
    }

    /// The sum of a piece over the nodes of its rule.
    #[inline(always)]
    fn integrate(&self, pieces: &Pieces, rule: &Rule) -> [f32; GROUP] {
        let mut sum = [0.0; GROUP];
        if let Some(constant) = self.quadrature.phase.constant() {
            for &(t, weight) in rule.nodes() {
                for i in 0..GROUP {
                    sum[i] += pieces.node(i, t).weight * weight;
                }
            }
            return sum.map(|sum| sum * constant as f32);
        }
        let mut angles = [ScatteringAngle::from_half_tangent(1.0, 1.0); GROUP];
        let mut values = [0.0; GROUP];
        let mut weights = [0.0; GROUP];
        for &(t, weight) in rule.nodes() {
            for i in 0..GROUP {
                let node = pieces.node(i, t);
                weights[i] = node.weight * weight;
                angles[i] = node.angle;
            }
            self.quadrature.phase.values_f32(&angles, &mut values);
            for i in 0..GROUP {
                sum[i] += weights[i] * values[i];
            }
        }
        sum
    }
}

/// A node of a piece.
struct Node {
    /// With all factors but the phase function and the weight of the rule.
    weight: f32,
    angle: ScatteringAngle<f32>,
}

impl Pieces {
    /// At `t` of a piece, see [`super::piece::Piece::place`].
    #[inline(always)]
    fn node(&self, i: usize, t: f32) -> Node {
        let alpha = self.alpha[i];
        let share = alpha * t;
        let denominator = 1.0 - (t - share);
        let a = self.a[i] * denominator;
        let b = self.b[i] * denominator + self.b_change[i] * share;
        let (a2, b2) = (a * a, b * b);
        let squares = a2 + b2;
        // One division serves the place in the piece and the inverse square.
        let inverse = 1.0 / (denominator * squares);
        let place = share * squares * inverse;
        let per_squares = denominator * inverse;
        let depth = self.depth[i] + self.depth_change[i] * place;
        let is_thin = self.is_thin[i] != 0;
        let (a2, b2) = (if is_thin { b2 } else { a2 }, if is_thin { a2 } else { b2 });
        Node {
            weight: alpha * per_squares * exp2(-depth),
            angle: ScatteringAngle::from_squares(b2, a2, per_squares),
        }
    }
}

impl<P: Phase> Kernel for Batch<'_, P> {
    type Scratch = Scratch;

    #[inline(always)]
    fn block(
        &self,
        scratch: &mut Scratch,
        segments: &[Segment; LANES],
        airlight: &mut [f32; LANES],
    ) {
        if segments.iter().any(may_be_extreme) {
            self.find_sides::<true>(scratch, segments);
        } else {
            self.find_sides::<false>(scratch, segments);
        }
        scratch.sides[0].is_front = true;
        scratch.sum = Lanes::default();
        for side in &scratch.sides {
            for first in (0..LANES).step_by(GROUP) {
                let mut from = [0.0; GROUP];
                while let Some((pieces, rule)) = self.next(side, first, &mut from) {
                    let sum = self.integrate(&pieces, rule);
                    for i in 0..GROUP {
                        let part = pieces.scale[i] * sum[i];
                        scratch.sum.0[first + i] += if part > 0.0 { part } else { 0.0 };
                    }
                }
            }
        }
        for (i, (airlight, segment)) in airlight.iter_mut().zip(segments).enumerate() {
            let value = f64::from(scratch.sum.0[i]) * scratch.factor.0[i];
            *airlight = settle(known(segment), value as f32);
        }
    }
}

//! Parts that hold little of the light of the ray behind their start, or that
//! change so much along it that a difference would: quadrature.
//!
//! In `w = s + d` the airlight is an integral of
//! `2 p e^{−σ_t (w − w_a)} / (h² + w²)`. A Möbius map of `w_a … w_b` onto
//! `0 … 1` whose slopes at the ends make up for the change of `r² = h² + w²`,
//!
//! ```text
//! w = (w_a κ (1 − t) + w_b t) / (κ (1 − t) + t),    κ = r_b / r_a
//! dw / (h² + w²) = G dt / (1 − 2 (1 − cos φ) t (1 − t)),    G = (w_b − w_a) / (r_a r_b)
//! ```
//!
//! leaves next to nothing of it, φ being the difference of `arctan(w/h)`. In
//! front of the foot point `w = h² / (d − s)`; in the lengths `q = |s| + d`
//! G and cos φ have no difference that loses digits, nor a division by h.

use super::Table;
use super::cells;
use super::long::{Extinction, Lookup, distances, half_depth};
use crate::simd::exp2;
use crate::{Real, Segment};

/// A short part, as a lookup needs it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Short<T = f32> {
    /// Half the optical depth from the light by the start to the eye, over ln 2.
    pub(super) depth: T,
    /// How much more optical depth the way by the end has, over ln 2.
    pub(super) growth: T,
    /// κ.
    pub(super) kappa: T,
    /// `2 (1 − cos φ)`.
    pub(super) bend: T,
    /// `G = (w_b − w_a) / (r_a r_b)`, 1/m.
    pub(super) angle: T,
    /// `w_a` and `w_b`, m.
    pub(super) ends: [T; 2],
    pub(super) h: T,
}

/// A node of the quadrature.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// Weight, with all factors but the exponential and the phase function.
    weight: f32,
    /// Optical depth behind the start, over ln 2.
    growth: f32,
}

impl<T: Real> Short<T> {
    /// For an extinction over ln 2 and the four lengths of a segment.
    #[inline(always)]
    pub(super) fn new(octaves: T, [x, s, h, length]: [T; 4]) -> Self {
        let [length, end, d_a, d_b] = distances(s, h, length);
        let (zero, half, one) = (T::from(0.0), T::from(0.5), T::from(1.0));
        let (front_a, front_b) = (s < zero, end < zero);
        let (q_a, q_b) = (s.absolute() + d_a, end.absolute() + d_b);
        let (root_a, root_b) = ((q_a * d_a).square_root(), (q_b * d_b).square_root());
        let (sum, product) = (q_a + q_b, h * h + q_a * q_b);
        let across = front_a != front_b;
        // Every case is computed and one is selected, so that a loop over segments has no
        // branches.
        let over = if front_a { q_a } else { one };
        let under_front = if front_b { q_b } else { h };
        let under = if front_a { under_front } else { one };
        // Two divisions serve κ, the angle and its cosine: where the part crosses the foot
        // point `under` is h. A single division by the product of all three lengths would
        // leave the range next to the light.
        let (inverse, per_under) = (one / (root_a * root_b), one / under);
        let (steep, h_sum) = (product * per_under, h * sum);
        let rise = if across { steep } else { sum };
        let along = if across { h_sum } else { product };
        let share = length / (d_a + d_b);
        let (w_a, w_b) = (h * (h / q_a), h * (h / q_b));
        Self {
            depth: half_depth(octaves, x, d_a),
            growth: octaves * (share * ((d_a + s) + (d_b + end))),
            kappa: root_b * root_b * inverse * (over * per_under),
            bend: T::from(2.0) * (one - half * inverse * along),
            angle: half * inverse * rise * share,
            ends: [
                if front_a { w_a } else { q_a },
                if front_b { w_b } else { q_b },
            ],
            h,
        }
    }
}

impl Short<f64> {
    /// The term of a node at `t`, with the phase function as a function of w and
    /// h.
    pub(super) fn term(&self, t: f64, weight: f64, phase: impl Fn(f64, f64) -> f64) -> f64 {
        let near = self.kappa * (1.0 - t);
        let along = near + t;
        let bent = 1.0 - self.bend * (t * (1.0 - t));
        let w = self.ends[0] * near + self.ends[1] * t;
        let growth = self.growth * (t / along);
        weight / bent * (-growth).exp2() * phase(w, self.h * along)
    }
}

impl Short {
    /// Of a segment in single precision.
    #[inline(always)]
    pub(super) fn of(extinction: Extinction, segment: &Segment) -> Self {
        let Segment { x, s, h, length } = *segment;
        Self::new(extinction.octaves, [x, s, h, length])
    }

    /// A node at `t` with a weight of the rule.
    #[inline(always)]
    pub(super) fn node(&self, t: f32, weight: f32) -> Node {
        let along = self.kappa * (1.0 - t) + t;
        let bent = 1.0 - self.bend * (t * (1.0 - t));
        let over = 1.0 / (along * bent);
        Node {
            weight: weight * along * over,
            growth: self.growth * (t * bent * over),
        }
    }

    /// The airlight, from the sum of [`Node::term`]s.
    #[inline(always)]
    pub(super) fn airlight(&self, sum: f32) -> f32 {
        let root = exp2(-self.depth);
        root * (root * (2.0 * self.angle * sum))
    }
}

impl Node {
    /// The term of a node where the logarithm of the phase function for base 2
    /// is `phase`.
    #[inline(always)]
    pub(super) fn term(&self, phase: f32) -> f32 {
        self.weight * exp2(phase - self.growth)
    }
}

impl Lookup {
    /// The row of the phase function at the node at `t`.
    #[inline(always)]
    pub(super) fn phase_row(&self, short: &Short, t: f32) -> (u32, f32) {
        let near = short.kappa * (1.0 - t);
        let w = short.ends[0] * near + short.ends[1] * t;
        let across = short.h * (near + t);
        let behind = w > across;
        let (less, more) = if behind { (across, w) } else { (w, across) };
        // On the axis in front of the light both are 0, and so is b.
        let row = self.axes.row(less, more + f32::MIN_POSITIVE, behind);
        self.phase_index(row)
    }
}

impl Table {
    /// The airlight of a short part.
    pub(super) fn short(&self, lookup: &Lookup, segment: &Segment) -> f32 {
        let short = Short::of(lookup.extinction, segment);
        let sum = self.rule.iter().fold(0.0, |sum, &[t, weight]| {
            let phase = match self.constant {
                Some(constant) => constant,
                None => {
                    let (row, beta) = lookup.phase_row(&short, t);
                    cells::phase_value(self.phase[row as usize], beta)
                }
            };
            sum + short.node(t, weight).term(phase)
        });
        short.airlight(sum)
    }
}

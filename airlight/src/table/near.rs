//! Parts that are short beside their distance from the light, and thin: a few
//! Gauss–Legendre nodes in the distance along the ray.
//!
//! The integrand `p e^{−σ_t (x + d)} / d²` changes by no more than a third over
//! such a part, and its poles at `s = ± i h` are many lengths away. A node takes a
//! root, a division and an exponential, one division more if the phase function
//! varies.

use super::Table;
use super::axes::Row;
use super::cells;
use super::long::{Lookup, half_depth};
use crate::simd::{ROUND, exp2};
use crate::{Real, Segment};

/// A part is near if its length over the distance of its start from the light is less than
/// this, and twice its optical depth over ln 2 less than [`THIN`].
pub(super) const NEAR: f32 = 0.125;

/// See [`NEAR`].
pub(super) const THIN: f32 = 0.5;

/// A node of the quadrature.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node<T = f32> {
    s: T,
    h: T,
    d: T,
    /// Half the optical depth from the light to the eye, over ln 2.
    depth: T,
    /// The length of the part over `d²`, 1/m.
    weight: T,
}

impl<T: Real> Node<T> {
    /// At `t` of a part, from 0 to 1; the four lengths are those of a segment.
    #[inline(always)]
    pub(super) fn new(octaves: T, [x, s, h, length]: [T; 4], t: T) -> Self {
        let way = t * length;
        let s = s + way;
        let square = s * s + h * h;
        let d = square.square_root();
        Self {
            s,
            h,
            d,
            depth: half_depth(octaves, x + way, d),
            weight: length / square,
        }
    }
}

impl Node<f64> {
    /// The airlight of a weight of the rule, where the phase function has this
    /// value as a function of w and h.
    pub(super) fn term(&self, weight: f64, phase: impl Fn(f64, f64) -> f64) -> f64 {
        let q = self.s.abs() + self.d;
        let p = if self.s < 0.0 {
            phase(self.h, q)
        } else {
            phase(q, self.h)
        };
        weight * self.weight * p * (-2.0 * self.depth).exp2()
    }
}

impl Node {
    /// The same where half the logarithm of the phase function for base 2 is
    /// `phase`. The square of a root is in range where the result is.
    #[inline(always)]
    pub(super) fn root_term(&self, weight: f32, phase: f32) -> f32 {
        let root = exp2(phase - self.depth);
        root * (root * (weight * self.weight))
    }
}

impl Lookup {
    /// Whether a part is near.
    #[inline(always)]
    pub(super) fn is_near(&self, segment: &Segment) -> bool {
        let Segment { s, h, length, .. } = *segment;
        // The way by the end is at most two lengths longer.
        (length * length < (NEAR * NEAR) * (s * s + h * h))
            & (2.0 * self.extinction.octaves * length < THIN)
    }

    #[inline(always)]
    pub(super) fn node(&self, [x, s, h, length]: [f32; 4], t: f32) -> Node {
        Node::new(self.extinction.octaves, [x, s, h.abs(), length], t)
    }

    /// The row of the phase function at a node.
    #[inline(always)]
    pub(super) fn node_row(&self, node: &Node) -> (u32, f32) {
        let q = node.s.abs() + node.d;
        self.phase_index(self.axes.row(node.h, q, node.s >= 0.0))
    }

    /// A row as an index, which is that of some row even for NaN.
    #[inline(always)]
    pub(super) fn phase_index(&self, row: Row) -> (u32, f32) {
        let index = (row.index + ROUND).to_bits();
        let index = index.wrapping_sub(ROUND.to_bits());
        (index.min(self.axes.all_rows() - 1), row.beta)
    }
}

impl Table {
    /// The airlight of a part that is near.
    pub(super) fn near(&self, lookup: &Lookup, segment: &Segment) -> f32 {
        let Segment { x, s, h, length } = *segment;
        self.near_rule.iter().fold(0.0, |sum, &[t, weight]| {
            let node = lookup.node([x, s, h, length], t);
            let phase = match self.constant {
                Some(constant) => constant,
                None => {
                    let (row, beta) = lookup.node_row(&node);
                    cells::phase_value(self.phase[row as usize], beta)
                }
            };
            sum + node.root_term(weight, 0.5 * phase)
        })
    }
}

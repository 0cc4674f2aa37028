//! Quadrature that knows its error.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::LazyLock;

use crate::gauss::Rule;

/// A value and how far it may be off.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// It is believed to be within this of the truth, rounding included.
    /// Infinite if the integrand was not finite everywhere.
    pub bound: f64,
}

impl std::ops::AddAssign for Estimate {
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        self.bound += other.bound;
    }
}

/// An integrand.
pub(super) trait Integrand {
    /// Its values at offsets of a side. Must be `#[inline(always)]`, or it is not
    /// compiled for the instructions of the loops around it.
    fn values(&self, side: usize, offsets: &[f64; NODES]) -> [f64; NODES];
}

/// The pieces of an integral.
#[derive(Debug, Default)]
pub(super) struct Adaptive {
    pieces: Vec<Piece>,
}

#[derive(Debug, Clone, Copy)]
struct Piece {
    side: usize,
    start: f64,
    end: f64,
    value: f64,
    error: f64,
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error
            .total_cmp(&other.error)
            .then(other.start.total_cmp(&self.start))
            .then(other.side.cmp(&self.side))
    }
}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Piece {}

/// Nodes of both rules together: a few vectors of any processor.
pub(super) const NODES: usize = 32;

/// Nodes of two rules whose difference estimates the error. The finer one, which gives the
/// value, comes first.
const RULES: [u32; 2] = [18, 14];

/// The nodes of both, and their weights in either.
#[derive(Debug)]
struct Rules {
    nodes: [f64; NODES],
    weights: [[f64; NODES]; 2],
}

static BOTH: LazyLock<Rules> = LazyLock::new(|| {
    let mut both = Rules {
        nodes: [0.5; NODES],
        weights: [[0.0; NODES]; 2],
    };
    let mut first = 0;
    for (count, weights) in RULES.into_iter().zip(&mut both.weights) {
        for (i, (node, weight)) in (first..).zip(Rule::of(count).iter()) {
            both.nodes[i] = node;
            weights[i] = weight;
        }
        first += count as usize;
    }
    both
});

/// The sum of products, in the same order with all instructions.
#[inline(always)]
fn product(a: &[f64; NODES], b: &[f64; NODES]) -> f64 {
    let mut sums = [0.0; 8];
    for (a, b) in a.as_chunks::<8>().0.iter().zip(b.as_chunks::<8>().0) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// Relative error at which refinement ends.
const GOAL: f64 = 1e-14;

/// The share of the error of a piece that each of its halves has at least: at a step
/// the rules may agree by chance.
const LEAST_SHARE: f64 = 1.0 / 16.0;

/// Pieces beyond which a function counts as too rough.
const MOST_PIECES: usize = 10_000;

impl Adaptive {
    /// Adds the integral over a side from `start` to `end`, and returns it.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        side: usize,
        start: f64,
        end: f64,
        integrand: &impl Integrand,
    ) -> f64 {
        let piece = Piece::new(side, start, end, integrand);
        self.pieces.push(piece);
        piece.value
    }

    /// Divides the worst piece until all is well.
    #[inline(always)]
    pub(super) fn refine(self, integrand: &impl Integrand) -> Estimate {
        let mut total = total(&self.pieces);
        if is_enough(&total) {
            return total;
        }
        let mut pieces = BinaryHeap::from(self.pieces);
        let mut countdown = 0;
        while !is_enough(&total) {
            if pieces.len() >= MOST_PIECES {
                break;
            }
            let Some(worst) = pieces.pop() else {
                break;
            };
            let middle = 0.5 * (worst.start + worst.end);
            if !(worst.start < middle && middle < worst.end) {
                pieces.push(worst);
                break;
            }
            for [start, end] in [[worst.start, middle], [middle, worst.end]] {
                let mut half = Piece::new(worst.side, start, end, integrand);
                half.error = half.error.max(LEAST_SHARE * worst.error);
                pieces.push(half);
            }
            // The sum is made anew now and then. If it were updated by differences, the
            // rounding errors of sums that were larger by orders of magnitude would stay.
            if countdown == 0 {
                total = self::total(&pieces);
                countdown = pieces.len() / 8;
            } else {
                countdown -= 1;
            }
        }
        self::total(&pieces)
    }
}

fn is_enough(total: &Estimate) -> bool {
    !(total.bound > GOAL * total.value && total.bound.is_finite())
}

fn total<'a>(pieces: impl IntoIterator<Item = &'a Piece>) -> Estimate {
    let mut total = Estimate::default();
    for piece in pieces {
        total += Estimate {
            value: piece.value,
            bound: piece.error,
        };
    }
    total
}

impl Piece {
    #[inline(always)]
    fn new(side: usize, start: f64, end: f64, integrand: &impl Integrand) -> Self {
        let width = end - start;
        let both = &*BOTH;
        let mut offsets = both.nodes;
        for offset in &mut offsets {
            *offset = start + width * *offset;
        }
        let values = integrand.values(side, &offsets);
        let [fine, coarse] = &both.weights;
        // The nodes of the coarse rule have the weight 0 in the fine one, but make its sum NaN
        // if a value is not finite.
        let value = width * product(fine, &values);
        let coarse = width * product(coarse, &values);
        let (value, error) = if value.is_finite() {
            // For a smooth function this is far too much, because the finer rule is better by
            // orders of magnitude. At a step the two may agree by chance, see `LEAST_SHARE`.
            (value, 4.0 * (value - coarse).abs())
        } else {
            (0.0, f64::INFINITY)
        };
        // An infinite error ends the refinement.
        let error = if error.is_nan() { f64::INFINITY } else { error };
        Self {
            side,
            start,
            end,
            value,
            error,
        }
    }
}

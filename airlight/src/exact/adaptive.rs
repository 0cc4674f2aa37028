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

/// The pieces of an integral.
#[derive(Debug, Default)]
pub(super) struct Adaptive {
    pieces: BinaryHeap<Piece>,
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

/// Two rules that judge each other; the finer one counts.
static RULES: LazyLock<[Rule; 2]> = LazyLock::new(|| [Rule::of(15), Rule::of(10)]);

/// Relative error at which refinement ends.
const GOAL: f64 = 1e-14;

/// Pieces beyond which a function counts as too rough.
const MOST_PIECES: usize = 10_000;

impl Adaptive {
    /// Adds the integral of `f(side, ·)` from `start` to `end`.
    pub(super) fn add(
        &mut self,
        side: usize,
        start: f64,
        end: f64,
        f: &impl Fn(usize, f64) -> f64,
    ) {
        let width = end - start;
        let [fine, coarse] = &*RULES;
        let integral = |rule: &Rule| {
            let sum: f64 = rule
                .iter()
                .map(|(t, weight)| weight * f(side, start + width * t))
                .sum();
            width * sum
        };
        let value = integral(fine);
        let (value, error) = if value.is_finite() {
            // Of a smooth function far too much, as the finer rule is the better
            // one by orders of magnitude; at a step it may be by chance that
            // they agree.
            (value, 4.0 * (value - integral(coarse)).abs())
        } else {
            (0.0, f64::INFINITY)
        };
        // Not to be divided any more.
        let error = if error.is_nan() { f64::INFINITY } else { error };
        self.pieces.push(Piece {
            side,
            start,
            end,
            value,
            error,
        });
    }

    /// Divides the worst piece until all is well.
    pub(super) fn refine(mut self, f: &impl Fn(usize, f64) -> f64) -> Estimate {
        let mut total = self.total();
        let mut countdown = 0;
        while total.bound > GOAL * total.value && total.bound.is_finite() {
            if self.pieces.len() >= MOST_PIECES {
                break;
            }
            let Some(worst) = self.pieces.pop() else {
                break;
            };
            let middle = 0.5 * (worst.start + worst.end);
            if !(worst.start < middle && middle < worst.end) {
                self.pieces.push(worst);
                break;
            }
            self.add(worst.side, worst.start, middle, f);
            self.add(worst.side, middle, worst.end, f);
            // Summed afresh now and then: a running difference of sums that
            // shrink by orders of magnitude would be left with their rounding.
            if countdown == 0 {
                total = self.total();
                countdown = self.pieces.len() / 8;
            } else {
                countdown -= 1;
            }
        }
        self.total()
    }

    fn total(&self) -> Estimate {
        let mut total = Estimate::default();
        for piece in &self.pieces {
            total += Estimate {
                value: piece.value,
                bound: piece.error,
            };
        }
        total
    }
}

//! Moments of optical depth along the ray.
//!
//! Based on: C. Münstermann, S. Krumpen, R. Klein, C. Peters, "Moment-Based
//! Order-Independent Transparency", ACM SIGGRAPH Symposium on Interactive 3D
//! Graphics and Games 2018. Departures: segments are integrated analytically,
//! where the paper has surfaces only; and the polynomial's roots come from a
//! bracketing solver that works for every number of moments.
//!
//! Of all distributions of optical depth that have the stored moments, the
//! least and the most that any of them puts in front of a depth `z` belong to
//! the one that has an atom at `z`. With `B` the Hankel matrix of the moments
//! and `ẑ = (1, z, z², …)`, that atom has weight `1 / ẑᵀB⁻¹ẑ`, the others are
//! at the roots of `ẑᵀB⁻¹x̂`, with weights of the same form.

use super::{OPAQUE_ENOUGH, Range};
use crate::numeric::exp_neg;
use crate::{Accumulate, BlockerSegment, Error, Evaluate};

/// Most rows of the Hankel matrix: 8 moments make 5.
const ROWS: usize = 5;

/// Share of the interval between the bounds that counts; what the paper uses.
const OVERESTIMATION: f64 = 0.25;

/// The moments of a fixed distribution, a little of which is mixed in so that
/// the matrix can be inverted, and how much of it: the paper's values for
/// moments in single precision.
fn bias(moments: usize) -> (f64, [f64; 9]) {
    match moments {
        4 => (5e-7, [1.0, 0.0, 0.375, 0.0, 0.375, 0.0, 0.0, 0.0, 0.0]),
        6 => (5e-6, [1.0, 0.0, 0.48, 0.0, 0.451, 0.0, 0.45, 0.0, 0.0]),
        _ => (
            5e-5,
            [1.0, 0.0, 0.75, 0.0, 0.676_666_7, 0.0, 0.63, 0.0, 0.600_303],
        ),
    }
}

/// Sums moments in f64, so that the number of blockers does not matter, for a
/// [`MomentCurve`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    range: Range,
    count: usize,
    sums: [f64; 9],
}

impl Moments {
    /// A clear ray, for 4, 6 or 8 moments beside the total.
    ///
    /// # Errors
    /// [`Error::BadValue`] for any other number.
    pub fn new(count: usize, range: Range) -> Result<Self, Error> {
        if ![4, 6, 8].contains(&count) {
            return Err(Error::BadValue {
                what: "the number of moments",
                value: count as f64,
                expected: "4, 6 or 8",
            });
        }
        Ok(Self {
            range,
            count,
            sums: [0.0; 9],
        })
    }
}

impl Accumulate for Moments {
    type Curve = MomentCurve;

    fn insert(&mut self, segment: &BlockerSegment) {
        let [entry, exit] = self.range.shares(segment).map(|share| 2.0 * share - 1.0);
        let tau = f64::from(segment.optical_depth()[0].min(OPAQUE_ENOUGH));
        // The mean of zᵏ over the segment is the mean of all products of k
        // powers of its ends; the sums grow by one factor at a time.
        let (mut products, mut power) = (1.0, 1.0);
        self.sums[0] += tau;
        for k in 1..=self.count {
            power *= exit;
            products = products * entry + power;
            self.sums[k] += tau * products / (k + 1) as f64;
        }
    }

    fn finish(self) -> MomentCurve {
        MomentCurve {
            range: self.range,
            count: self.count as u32,
            moments: self.sums.map(|sum| sum as f32),
        }
    }
}

/// Optical depth and 4, 6 or 8 of its moments over a range of depths.
///
/// The optical depth up to a depth is known to lie in an interval
/// ([`MomentCurve::interval`]); a quarter of the way through it is used, as
/// published. Smooth and independent of the order, but few features fit into so
/// few numbers. Blockers count with an optical depth of at most 8.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MomentCurve {
    range: Range,
    count: u32,
    moments: [f32; 9],
}

impl MomentCurve {
    /// Share of the light that gets as far as `depth`.
    #[must_use]
    pub fn transmittance(&self, depth: f32) -> f32 {
        let [least, most] = self.interval(depth);
        exp_neg((least + OVERESTIMATION * (most - least)) as f32)
    }

    /// Between which bounds the optical depth up to `depth` lies, if the
    /// blockers were as the moments have them: each of at most 8, inside of the
    /// range. The mixed-in distribution and the rounding of the moments to f32
    /// are allowed for by as much as the former: `5e-7` of the total for 4
    /// moments, `5e-6` for 6, `5e-5` for 8.
    #[must_use]
    pub fn interval(&self, depth: f32) -> [f64; 2] {
        let total = f64::from(self.moments[0]);
        if !(depth > self.range.near) || total == 0.0 {
            return [0.0; 2];
        }
        if depth > self.range.far {
            return [total; 2];
        }
        let count = self.count as usize;
        let (share, fixed) = bias(count);
        let mut moments = [0.0; 9];
        for k in 0..=count {
            let own = f64::from(self.moments[k]) / total;
            moments[k] = own + (fixed[k] - own) * share;
        }
        let z = 2.0 * self.range.share(depth) - 1.0;
        let [least, most] = cumulated(&moments, count / 2 + 1, z);
        [
            (total * (least - share)).max(0.0),
            (total * (most + share)).min(total),
        ]
    }
}

impl Evaluate for MomentCurve {
    fn evaluate(&self, depth: f32) -> [f32; 1] {
        [self.transmittance(depth)]
    }
}

/// The least and the most that a distribution with these moments can have up
/// to `z`.
fn cumulated(moments: &[f64; 9], rows: usize, z: f64) -> [f64; 2] {
    let factor = Cholesky::new(moments, rows);
    let polynomial = factor.solve(powers(z));
    // ẑᵀB⁻¹x̂ as a polynomial in x: what the roots of are the other atoms.
    let mut least = 0.0;
    let (roots, found) = roots(&polynomial, rows - 1);
    for &root in &roots[..found] {
        if root < z {
            least += factor.weight(root);
        }
    }
    let least = least.clamp(0.0, 1.0);
    [least, (least + factor.weight(z)).min(1.0)]
}

/// `1, z, z², …`
fn powers(z: f64) -> [f64; ROWS] {
    let mut powers = [1.0; ROWS];
    for k in 1..ROWS {
        powers[k] = powers[k - 1] * z;
    }
    powers
}

/// `B = L D Lᵀ` of a Hankel matrix.
struct Cholesky {
    rows: usize,
    lower: [[f64; ROWS]; ROWS],
    diagonal: [f64; ROWS],
}

impl Cholesky {
    fn new(moments: &[f64; 9], rows: usize) -> Self {
        let mut lower = [[0.0; ROWS]; ROWS];
        let mut diagonal = [1.0; ROWS];
        for i in 0..rows {
            for j in 0..=i {
                let known: f64 = (0..j)
                    .map(|k| lower[i][k] * lower[j][k] * diagonal[k])
                    .sum();
                let rest = moments[i + j] - known;
                if i == j {
                    // The mixed-in distribution keeps this above 0 but for
                    // rounding.
                    diagonal[i] = rest.max(1e-14);
                    lower[i][i] = 1.0;
                } else {
                    lower[i][j] = rest / diagonal[j];
                }
            }
        }
        Self {
            rows,
            lower,
            diagonal,
        }
    }

    /// `L⁻¹ x`.
    fn forward(&self, x: [f64; ROWS]) -> [f64; ROWS] {
        let mut y = x;
        for i in 0..self.rows {
            for k in 0..i {
                y[i] -= self.lower[i][k] * y[k];
            }
        }
        y
    }

    /// `B⁻¹ x`.
    fn solve(&self, x: [f64; ROWS]) -> [f64; ROWS] {
        let mut y = self.forward(x);
        for i in (0..self.rows).rev() {
            y[i] /= self.diagonal[i];
            for k in i + 1..self.rows {
                y[i] -= self.lower[k][i] * y[k];
            }
        }
        y
    }

    /// The largest weight that an atom at `z` can have: `1 / ẑᵀB⁻¹ẑ`.
    fn weight(&self, z: f64) -> f64 {
        let y = self.forward(powers(z));
        let sum: f64 = (0..self.rows).map(|i| y[i] * y[i] / self.diagonal[i]).sum();
        sum.recip()
    }
}

/// The real roots of a polynomial of the given degree, in order, where all are
/// real and lie apart; and how many were found.
///
/// Between two roots of a polynomial lies one of its derivative, so that those
/// of the derivative bracket them.
fn roots(polynomial: &[f64; ROWS], degree: usize) -> ([f64; ROWS], usize) {
    let mut roots = [0.0; ROWS];
    let mut found = 0;
    // Where blockers are symmetric about z, an atom has gone to infinity.
    let Some(degree) = (1..=degree).rev().find(|&k| polynomial[k] != 0.0) else {
        return (roots, found);
    };
    let leading = polynomial[degree];
    // Cauchy's bound. Atoms far outside of [−1, 1] weigh next to nothing.
    let largest = polynomial[..degree]
        .iter()
        .fold(0.0_f64, |m, c| m.max((c / leading).abs()));
    let bound = (1.0 + largest).min(1e6);
    let mut derivative = [0.0; ROWS];
    for k in 1..=degree {
        derivative[k - 1] = k as f64 * polynomial[k];
    }
    let (turns, count) = self::roots(&derivative, degree - 1);
    let mut left = -bound;
    for turn in turns[..count].iter().copied().chain([bound]) {
        let (low, high) = (
            horner(polynomial, degree, left),
            horner(polynomial, degree, turn),
        );
        if (low <= 0.0) != (high <= 0.0) {
            roots[found] = root_between(polynomial, &derivative, degree, [left, turn]);
            found += 1;
        }
        left = turn;
    }
    (roots, found)
}

/// The value of a polynomial of the given degree.
fn horner(polynomial: &[f64; ROWS], degree: usize, x: f64) -> f64 {
    let terms = polynomial[..=degree].iter().rev();
    terms.fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// The root in a bracket at whose ends the signs differ: Newton's steps, and
/// halves of the bracket where those leave it or do not get on.
fn root_between(
    polynomial: &[f64; ROWS],
    derivative: &[f64; ROWS],
    degree: usize,
    bracket: [f64; 2],
) -> f64 {
    let [mut low, mut high] = bracket;
    let rising = horner(polynomial, degree, low) <= 0.0;
    let mut x = 0.5 * (low + high);
    let mut last = high - low;
    // Halving alone takes 75 steps from 2e6 to an ULP of 1; every other step
    // halves at least something.
    for _ in 0..150 {
        let value = horner(polynomial, degree, x);
        if (value <= 0.0) == rising {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / horner(derivative, degree - 1, x);
        let next = if low < newton && newton < high && (newton - x).abs() < 0.5 * last {
            newton
        } else {
            0.5 * (low + high)
        };
        last = (next - x).abs();
        x = next;
        if last <= f64::EPSILON * x.abs().max(f64::EPSILON) {
            break;
        }
    }
    x
}

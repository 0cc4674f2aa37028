//! Bounds on the share of depths in front of a point, from moments of the depths.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Rows of the Hankel matrix of 6 moments.
const ROWS: usize = 4;

/// A real number of some precision.
pub(super) trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    fn of(value: f64) -> Self;
    fn sqrt(self) -> Self;

    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
}

impl Real for f32 {
    fn of(value: f64) -> Self {
        value as Self
    }

    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

impl Real for f64 {
    fn of(value: f64) -> Self {
        value
    }

    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

/// One-sided Chebyshev inequality (Cantelli): the largest share of a distribution with these
/// two moments that is not in front of `z`.
pub(super) fn not_before<R: Real>(mean: R, square: R, least_variance: R, z: R) -> R {
    let behind = z - mean;
    if !(behind > R::of(0.0)) {
        return R::of(1.0);
    }
    let variance = (square - mean * mean).max(least_variance);
    variance / (variance + behind * behind)
}

/// The smallest share of a distribution on −1 to 1 that lies in front of `z`, from 4 or 6 of
/// its moments.
///
/// Among all distributions with these moments, the one with an atom at `z` has the smallest
/// share in front of it. With `B` the Hankel matrix of the moments and `ẑ = (1, z, z², …)`, its
/// other atoms are at the roots of `ẑᵀB⁻¹x̂`, and an atom at `x` has the weight `1 / x̂ᵀB⁻¹x̂`.
/// `bias` is the share of the uniform distribution that is mixed in, so that rounding leaves
/// `B` positive definite.
pub(super) fn least_before<R: Real>(moments: &[R], bias: R, z: R) -> R {
    let zero = R::of(0.0);
    let one = R::of(1.0);
    let rows = moments.len() / 2 + 1;
    let mut all = [zero; 2 * ROWS - 1];
    all[0] = one;
    for (k, moment) in moments.iter().enumerate() {
        let uniform = match k % 2 {
            0 => zero,
            _ => R::of(1.0 / (k + 2) as f64),
        };
        all[k + 1] = *moment + bias * (uniform - *moment);
    }
    let factor = Factor::new(&all, rows);
    let (roots, count) = roots(factor.solve(powers(z)), rows - 1);
    let mut sum = zero;
    for root in &roots[..count] {
        if *root < z {
            sum = sum + factor.weight(*root);
        }
    }
    sum.min(one)
}

/// `1, x, x², …`
fn powers<R: Real>(x: R) -> [R; ROWS] {
    let mut powers = [R::of(1.0); ROWS];
    for k in 1..ROWS {
        powers[k] = powers[k - 1] * x;
    }
    powers
}

/// `B = L D Lᵀ` of a Hankel matrix.
struct Factor<R> {
    rows: usize,
    lower: [[R; ROWS]; ROWS],
    /// The reciprocals of D.
    inverse: [R; ROWS],
}

impl<R: Real> Factor<R> {
    fn new(moments: &[R; 2 * ROWS - 1], rows: usize) -> Self {
        let mut lower = [[R::of(0.0); ROWS]; ROWS];
        let mut diagonal = [R::of(1.0); ROWS];
        let mut inverse = [R::of(1.0); ROWS];
        for i in 0..rows {
            for j in 0..=i {
                let mut rest = moments[i + j];
                for k in 0..j {
                    rest = rest - lower[i][k] * lower[j][k] * diagonal[k];
                }
                if i == j {
                    // This is 0 if there are too few different depths, but rounding may make it
                    // negative.
                    diagonal[i] = rest.max(R::of(1e-12));
                    inverse[i] = R::of(1.0) / diagonal[i];
                } else {
                    lower[i][j] = rest * inverse[j];
                }
            }
        }
        Self {
            rows,
            lower,
            inverse,
        }
    }

    /// `L⁻¹ x`.
    fn forward(&self, x: [R; ROWS]) -> [R; ROWS] {
        let mut y = x;
        for i in 0..self.rows {
            for k in 0..i {
                y[i] = y[i] - self.lower[i][k] * y[k];
            }
        }
        y
    }

    /// `B⁻¹ x`.
    fn solve(&self, x: [R; ROWS]) -> [R; ROWS] {
        let mut y = self.forward(x);
        for i in (0..self.rows).rev() {
            y[i] = y[i] * self.inverse[i];
            for k in i + 1..self.rows {
                y[i] = y[i] - self.lower[k][i] * y[k];
            }
        }
        y
    }

    fn weight(&self, x: R) -> R {
        let y = self.forward(powers(x));
        let mut sum = R::of(0.0);
        for (y, inverse) in y.into_iter().zip(self.inverse).take(self.rows) {
            sum = sum + y * y * inverse;
        }
        R::of(1.0) / sum
    }
}

/// Atoms farther away than this have next to no weight.
const FAR: f64 = 1e3;

/// The real roots of a polynomial of degree 1 to 3 whose roots are all real, within ±[`FAR`].
///
/// Newton's steps start at the root of a parabola through the nearest extremum. This root is
/// beyond the outer roots of a cubic and in front of the inner one, so the steps do not
/// overshoot, even where two roots are close.
fn roots<R: Real>(polynomial: [R; ROWS], degree: usize) -> ([R; ROWS], usize) {
    let (zero, far) = (R::of(0.0), R::of(FAR));
    let mut roots = [zero; ROWS];
    let [c, b, a, lead] = polynomial;
    if degree < 3 {
        return quadratic(a, b, c);
    }
    let (mut turns, count) = quadratic(R::of(3.0) * lead, R::of(2.0) * a, b);
    turns[count..].fill(far);
    let value = |x: R| ((lead * x + a) * x + b) * x + c;
    let slope = |x: R| (R::of(3.0) * lead * x + R::of(2.0) * a) * x + b;
    let away = |turn: R| {
        let curvature = R::of(6.0) * lead * turn + R::of(2.0) * a;
        let square = R::of(-2.0) * value(turn);
        match square * curvature > zero {
            true => (square / curvature).sqrt(),
            false => zero,
        }
    };
    let [first, last] = [turns[0], turns[1]];
    let size = |x: R| value(x).max(-value(x));
    let inner = match size(first) < size(last) {
        true => first + away(first),
        false => last - away(last),
    };
    let mut found = 0;
    for [left, right, start] in [
        [-far, first, first - away(first)],
        [first, last, inner],
        [last, far, last + away(last)],
    ] {
        let is_rising = value(left) <= zero;
        if is_rising != (value(right) <= zero) {
            roots[found] = between(&value, &slope, [left, right, start], is_rising);
            found += 1;
        }
    }
    (roots, found)
}

/// Newton's steps from a starting point, within a bracket; where a step leaves the bracket, the
/// bracket is halved instead.
fn between<R: Real>(
    value: &impl Fn(R) -> R,
    slope: &impl Fn(R) -> R,
    [mut low, mut high, start]: [R; 3],
    is_rising: bool,
) -> R {
    let mut x = match start >= low && start <= high {
        true => start,
        false => R::of(0.5) * (low + high),
    };
    for _ in 0..STEPS {
        let y = value(x);
        if (y <= R::of(0.0)) == is_rising {
            low = x;
        } else {
            high = x;
        }
        let newton = x - y / slope(x);
        let middle = R::of(0.5) * (low + high);
        // At a root the position stays, whichever end of the bracket it has become.
        let is_inside = newton >= low && newton <= high;
        x = if is_inside { newton } else { middle };
    }
    x
}

/// Number of steps in [`between`]: from these starting points five or six of Newton's steps
/// suffice in single precision, and the others are for brackets that have to be halved.
const STEPS: usize = 9;

/// The real roots of `a x² + b x + c` in order, within ±[`FAR`].
fn quadratic<R: Real>(a: R, b: R, c: R) -> ([R; ROWS], usize) {
    let (zero, far) = (R::of(0.0), R::of(FAR));
    let mut roots = [zero; ROWS];
    let root = (b * b - R::of(4.0) * a * c).max(zero).sqrt();
    let q = R::of(-0.5) * if b < zero { b - root } else { b + root };
    // Products are compared instead of quotients, either of which may be infinite.
    let mut found = 0;
    for (over, under) in [(q, a), (c, q)] {
        let size = under.max(-under);
        if over.max(-over) < far * size {
            roots[found] = over / under;
            found += 1;
        }
    }
    if found == 2 && roots[1] < roots[0] {
        roots.swap(0, 1);
    }
    (roots, found)
}

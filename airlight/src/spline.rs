//! Cubic splines through evenly spaced values, in any number of dimensions.
//!
//! A spline is kept as the coefficients of cubic B-splines: one more at each
//! end than there are values. Interpolation then needs four neighbours per
//! axis, is twice continuously differentiable, and its error falls with the
//! fourth power of the spacing, at the ends too ("not a knot").

use crate::within::within;

/// Replaces evenly spaced values by the coefficients of the cubic spline
/// through them, along the middle axis of an array of `outer × len × inner`
/// values; the result has `outer × (len + 2) × inner`.
///
/// # Panics
/// With fewer than four values along the axis.
pub(crate) fn coefficients(values: &[f64], len: usize, inner: usize) -> Vec<f64> {
    assert!(len >= 4, "{len} values; a cubic needs four");
    let outer = values.len() / (len * inner);
    let mut result = vec![0.0; outer * (len + 2) * inner];
    let mut line = vec![0.0; len];
    for o in 0..outer {
        for i in 0..inner {
            for (k, value) in line.iter_mut().enumerate() {
                *value = values[(o * len + k) * inner + i];
            }
            for (k, coefficient) in coefficients_of_line(&line).into_iter().enumerate() {
                result[(o * (len + 2) + k) * inner + i] = coefficient;
            }
        }
    }
    result
}

fn coefficients_of_line(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let bend = |i: usize| values[i - 1] - 2.0 * values[i] + values[i + 1];
    // Second derivatives m at the nodes: m[i-1] + 4 m[i] + m[i+1] = 6 bend(i).
    // Third derivatives do not jump at the second node from either end, so that
    // m[0] = 2 m[1] - m[2], and the outermost equations give m[1] at once.
    let mut m = vec![0.0; n];
    m[1] = bend(1);
    m[n - 2] = bend(n - 2);
    let mut factors = vec![0.0; n];
    for i in 2..n - 2 {
        let pivot = 1.0 / (4.0 - factors[i - 1]);
        factors[i] = pivot;
        m[i] = (6.0 * bend(i) - m[i - 1]) * pivot;
    }
    for i in (2..n - 2).rev() {
        m[i] -= factors[i] * m[i + 1];
    }
    m[0] = 2.0 * m[1] - m[2];
    m[n - 1] = 2.0 * m[n - 2] - m[n - 3];

    let inner = |i: usize| values[i] - m[i] / 6.0;
    let mut result = Vec::with_capacity(n + 2);
    result.push(m[0] + 2.0 * inner(0) - inner(1));
    result.extend((0..n).map(inner));
    result.push(m[n - 1] + 2.0 * inner(n - 1) - inner(n - 2));
    result
}

/// Where a coordinate lies among `len` nodes from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Position {
    /// The first of four coefficients.
    pub(crate) first: usize,
    /// The weight of each.
    pub(crate) weights: [f32; 4],
}

impl Position {
    /// Coordinates outside [0, 1] count as the nearer end, NaN as 0.
    pub(crate) fn new(coordinate: f32, len: usize) -> Self {
        let x = within(coordinate, 0.0, 1.0) * (len - 1) as f32;
        let first = (x as usize).min(len - 2);
        let f = x - first as f32;
        let g = 1.0 - f;
        Self {
            first,
            weights: [
                g * g * g / 6.0,
                2.0 / 3.0 - f * f * (1.0 - 0.5 * f),
                2.0 / 3.0 - g * g * (1.0 - 0.5 * g),
                f * f * f / 6.0,
            ],
        }
    }
}

/// The spline over two axes, the second of which has `stride` coefficients.
pub(crate) fn at(coefficients: &[f32], stride: usize, outer: Position, inner: Position) -> f32 {
    let mut sum = 0.0;
    for (row, weight) in outer.weights.iter().enumerate() {
        let start = (outer.first + row) * stride + inner.first;
        let c = &coefficients[start..start + 4];
        let w = &inner.weights;
        sum += weight * ((c[0] * w[0] + c[1] * w[1]) + (c[2] * w[2] + c[3] * w[3]));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evaluate(coefficients: &[f64], len: usize, x: f32) -> f64 {
        let at = Position::new(x, len);
        (0..4)
            .map(|i| f64::from(at.weights[i]) * coefficients[at.first + i])
            .sum()
    }

    #[test]
    fn cubics_come_back_exactly_even_at_the_ends() {
        for len in [4, 5, 6, 20] {
            let cubic = |x: f64| 1.0 - 2.0 * x + 5.0 * x * x - 3.0 * x * x * x;
            let values: Vec<f64> = (0..len)
                .map(|i| cubic(i as f64 / (len - 1) as f64))
                .collect();
            let c = coefficients(&values, len, 1);
            for i in 0..=1000 {
                let x = i as f32 / 1000.0;
                let error = (evaluate(&c, len, x) - cubic(f64::from(x))).abs();
                assert!(error < 1e-5, "{len} values, x {x}: {error}");
            }
        }
    }

    #[test]
    fn values_at_nodes_come_back() {
        let values: Vec<f64> = (0..12).map(|i| f64::from(i * i * 7 % 11)).collect();
        let c = coefficients(&values, 12, 1);
        for (i, value) in values.iter().enumerate() {
            assert!((evaluate(&c, 12, i as f32 / 11.0) - value).abs() < 1e-4);
        }
    }

    #[test]
    fn axes_are_independent() {
        let (a, b) = (5, 7);
        let f = |i: usize, j: usize| (i as f64).sin() * (1.0 + j as f64).ln();
        let values: Vec<f64> = (0..a * b).map(|k| f(k / b, k % b)).collect();
        let c = coefficients(&coefficients(&values, b, 1), a, b + 2);
        let c: Vec<f32> = c.iter().map(|&c| c as f32).collect();
        for i in 0..a {
            for j in 0..b {
                let outer = Position::new(i as f32 / (a - 1) as f32, a);
                let inner = Position::new(j as f32 / (b - 1) as f32, b);
                let value = at(&c, b + 2, outer, inner);
                assert!((f64::from(value) - f(i, j)).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn coordinates_outside_count_as_the_ends() {
        assert_eq!(Position::new(-1.0, 9), Position::new(0.0, 9));
        assert_eq!(Position::new(f32::NAN, 9), Position::new(0.0, 9));
        assert_eq!(Position::new(f32::INFINITY, 9), Position::new(1.0, 9));
    }
}

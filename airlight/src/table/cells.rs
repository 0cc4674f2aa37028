//! Cells: polynomials that are fitted once and looked up many times.
//!
//! A cell is four words. Three are coefficients as `f32`, the fourth holds the
//! three of second order as integers of 11, 10 and 11 bits, in units that the
//! whole table shares:
//!
//! ```text
//! c₀ + c₁ α + c₂ β + c₃ α² + c₄ α β + c₅ β²
//! ```

use super::axes::Axes;
use super::integral::Tail;
use crate::Phase;

/// Largest values of the integers of a cell.
const MOST: [f64; 3] = [1023.0, 511.0, 1023.0];

/// The extrema of T₃ and, between them, its zeros: the polynomial through the
/// values at the zeros is off by about T₃, most at the extrema.
pub(super) const ZEROS: [f64; 3] = [-0.433_012_701_892_219_3, 0.0, 0.433_012_701_892_219_3];

/// Coefficients of `1, T₁(2x), T₂(2x)` of the parabola through values at
/// [`ZEROS`].
fn chebyshev(f: [f64; 3]) -> [f64; 3] {
    [
        (f[0] + f[1] + f[2]) / 3.0,
        (f[2] - f[0]) / 3.0_f64.sqrt(),
        (f[0] - 2.0 * f[1] + f[2]) / 3.0,
    ]
}

/// The parabola through values at [`ZEROS`], at x.
pub(super) fn parabola(f: [f64; 3], x: f64) -> f64 {
    let [c0, c1, c2] = chebyshev(f);
    c0 + c1 * 2.0 * x + c2 * (8.0 * x * x - 1.0)
}

/// Tabulated values may be this small and no smaller, because a phase function
/// may be 0 where its logarithm is not.
pub(super) const LEAST: f64 = 1e-30;

/// The number that is stored for a value of the integral: the logarithm to base 4 of twice the
/// value. Lookups take two to this power, which is the square root of twice the value, so that a
/// product of two factors can be in range although one of them is not.
pub(super) fn stored(value: f64) -> f64 {
    0.5 * (2.0 * value).max(LEAST).log2()
}

/// Cells of [`stored`] values of the integral, and their units.
pub(super) fn fit<P: Phase>(axes: &Axes, tail: &Tail<'_, P>) -> (Vec<[f32; 4]>, [f32; 3]) {
    let series: Vec<_> = (0..axes.all_rows())
        .flat_map(|row| (0..axes.radial).map(move |column| (row, column)))
        .map(|(row, column)| {
            let along_v = ZEROS.map(|beta| {
                let (b, behind) = axes.b(row, beta);
                chebyshev(ZEROS.map(|alpha| stored(tail.value(axes.v(column, alpha), b, behind))))
            });
            // Coefficients of T_i(2α) T_j(2β) as [i][j].
            [0, 1, 2].map(|i| chebyshev(along_v.map(|c| c[i])))
        })
        .collect();
    let second = |c: &[[f64; 3]; 3]| [8.0 * c[2][0], 4.0 * c[1][1], 8.0 * c[0][2]];
    let units = [0, 1, 2].map(|i| {
        let largest = series
            .iter()
            .map(|c| second(c)[i].abs())
            .fold(0.0, f64::max);
        (largest.max(1e-30) / MOST[i]) as f32
    });
    let cells = series.iter().map(|c| cell(c, second(c), units)).collect();
    (cells, units)
}

fn cell(c: &[[f64; 3]; 3], second: [f64; 3], units: [f32; 3]) -> [f32; 4] {
    let mut integers = [0_i32; 3];
    for i in 0..3 {
        integers[i] = (second[i] / f64::from(units[i]))
            .round()
            .clamp(-MOST[i], MOST[i]) as i32;
    }
    let [aa, ab, bb] = integers;
    let rounded = |i: usize| f64::from(integers[i]) * f64::from(units[i]);
    // T₂(2x) = 8x² − 1. With the constant taken from the rounded squares, their rounding
    // error multiplies T₂, which is half as much at most as 8x² is.
    let constant = c[0][0] - (rounded(0) + rounded(2)) / 8.0;
    let packed = (aa << 21) | ((ab & 0x3ff) << 11) | (bb & 0x7ff);
    [
        constant as f32,
        (2.0 * c[1][0]) as f32,
        (2.0 * c[0][1]) as f32,
        f32::from_bits(packed as u32),
    ]
}

/// The polynomial of a cell.
#[inline(always)]
pub(super) fn value(cell: [f32; 4], units: [f32; 3], alpha: f32, beta: f32) -> f32 {
    let packed = cell[3].to_bits() as i32;
    let aa = (packed >> 21) as f32 * units[0];
    let ab = ((packed << 11) >> 22) as f32 * units[1];
    let bb = ((packed << 21) >> 21) as f32 * units[2];
    let second = alpha * (cell[1] + (alpha * aa + beta * ab));
    cell[0] + (second + beta * (cell[2] + beta * bb))
}

/// The zeros of T₄(2x).
const ZEROS4: [f64; 4] = [
    -0.461_939_766_255_643_4,
    -0.191_341_716_182_544_9,
    0.191_341_716_182_544_9,
    0.461_939_766_255_643_4,
];

/// For each row of the table the logarithm of the phase function for base 2,
/// as a polynomial of third order in β.
pub(super) fn fit_phase<P: Phase>(axes: &Axes, tail: &Tail<'_, P>) -> Vec<[f32; 4]> {
    (0..axes.all_rows())
        .map(|row| {
            let f = ZEROS4.map(|beta| {
                let (b, behind) = axes.b(row, beta);
                tail.phase(b, behind).max(LEAST).log2()
            });
            let mut c = [0.0; 4];
            for (k, c) in c.iter_mut().enumerate() {
                let t = |x: f64| (k as f64 * (2.0 * x).acos()).cos();
                let sum: f64 = ZEROS4.iter().zip(f).map(|(&x, f)| f * t(x)).sum();
                *c = if k == 0 { 0.25 } else { 0.5 } * sum;
            }
            // T₃(2x) = 32x³ - 6x
            [
                (c[0] - c[2]) as f32,
                (2.0 * c[1] - 6.0 * c[3]) as f32,
                (8.0 * c[2]) as f32,
                (32.0 * c[3]) as f32,
            ]
        })
        .collect()
}

/// The polynomial of a row.
#[inline(always)]
pub(super) fn phase_value(row: [f32; 4], beta: f32) -> f32 {
    row[0] + beta * (row[1] + beta * (row[2] + beta * row[3]))
}

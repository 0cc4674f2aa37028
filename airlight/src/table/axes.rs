//! Where a lookup lands in a table.
//!
//! A table covers `v = σ_t max(s + d, h)`, a distance in mean free paths, and
//! the direction of the light, `b = h / (|s| + d)`, once in front of the foot
//! point (where `b = tan(θ/2)`) and once behind it (`b = cot(θ/2)`). On each
//! side the tabulated function is analytic in b. In v it behaves like `v ln v`
//! near 0 and like a series in 1/v far away: cells of equal width in the
//! logarithm of `v + v₀` follow both, and the bits of a float are a number of
//! such a cell.

use crate::simd::ROUND;

/// log2 of the end of the axis along v: airlight from there is below `e^-256`.
const END: i32 = 8;

/// How the plane of (v, b) is divided into cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axes {
    /// v₀: below it cells are equally wide.
    pub(super) offset: f32,
    /// There are `2^steps` cells per doubling of `v + v₀`.
    pub(super) steps: u32,
    /// Number of cells along v.
    pub(super) radial: u32,
    /// Rows of cells along b in front of the foot point and behind it.
    pub(super) rows: [u32; 2],
    /// Row number plus one half is `slope[1] b / (1 + slope[0] b)`.
    pub(super) slope: [[f32; 2]; 2],
}

/// A row of cells and the position in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// Index of the row, as an integer-valued number.
    pub(super) index: f32,
    /// Position along b from -1/2 to 1/2.
    pub(super) beta: f32,
}

/// A cell and the position in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) cell: u32,
    /// Position along v from -1/2 to 1/2.
    pub(super) alpha: f32,
    /// Position along b from -1/2 to 1/2.
    pub(super) beta: f32,
}

impl Axes {
    /// With `v₀ = 2^low` and rows that crowd near b = 0, on each side of the
    /// foot point, by factors `1 / (1 - crowding)`.
    pub(super) fn new(low: i32, steps: u32, rows: [u32; 2], crowding: [f32; 2]) -> Self {
        let slope = [0, 1].map(|side| {
            // b = 1 must fall into the last row in spite of rounding.
            let rows = rows[side] as f32 * (1.0 - 4e-6);
            [
                crowding[side] / (1.0 - crowding[side]),
                rows / (1.0 - crowding[side]),
            ]
        });
        Self {
            offset: (low as f32).exp2(),
            steps,
            radial: Self::radial(low, steps),
            rows,
            slope,
        }
    }

    /// Number of cells along v.
    pub(super) fn radial(low: i32, steps: u32) -> u32 {
        ((END - low) as u32) << steps
    }

    /// Number of all rows.
    pub(super) fn all_rows(&self) -> u32 {
        self.rows[0] + self.rows[1]
    }

    /// Number of cells.
    pub(super) fn cells(&self) -> u32 {
        self.radial * self.all_rows()
    }

    /// The row of `b = h / q`.
    #[inline(always)]
    pub(super) fn row(&self, h: f32, q: f32, behind: bool) -> Row {
        self.row_at(h / self.along(h, q, behind), behind)
    }

    /// What h is divided by on the way to its row: q, and more by what rows crowd.
    #[inline(always)]
    pub(super) fn along(&self, h: f32, q: f32, behind: bool) -> f32 {
        let [front, back] = self.slope;
        q + if behind { back[0] } else { front[0] } * h
    }

    /// The row of a quotient of h.
    #[inline(always)]
    pub(super) fn row_at(&self, quotient: f32, behind: bool) -> Row {
        let [front, back] = self.slope;
        let first = if behind { self.rows[0] as f32 } else { 0.0 };
        let position = quotient * if behind { back[1] } else { front[1] } - 0.5;
        let index = (position + ROUND) - ROUND;
        Row {
            index: index + first,
            beta: position - index,
        }
    }

    /// v, but no more than the axis has.
    #[inline(always)]
    pub(super) fn within(&self, v: f32) -> f32 {
        let end = (END as f32).exp2() * (1.0 - 1e-6) - self.offset;
        if v < end { v } else { end }
    }

    /// The cell of v, which is [within](Axes::within) the axis, in a row. Rows
    /// outside of the axes, and NaN, give some cell of the table.
    #[inline(always)]
    pub(super) fn place(&self, v: f32, row: Row) -> Place {
        let bits = (v + self.offset).to_bits();
        let column = (bits - self.offset.to_bits()) >> (23 - self.steps);
        let fraction = f32::from_bits(((bits << self.steps) & 0x7f_ffff) | 0x3f80_0000);
        let start = (row.index * self.radial as f32 + ROUND).to_bits();
        let cell = start.wrapping_sub(ROUND.to_bits()).wrapping_add(column);
        Place {
            cell: cell.min(self.cells() - 1),
            alpha: fraction - 1.5,
            beta: row.beta,
        }
    }

    /// v at a place of a column of cells: the inverse of [`Axes::place`].
    pub(super) fn v(&self, column: u32, alpha: f64) -> f64 {
        let per_octave = 1_u32 << self.steps;
        let octave = f64::from(column / per_octave);
        let step = f64::from(column % per_octave) + 0.5 + alpha;
        f64::from(self.offset) * (octave.exp2() * (1.0 + step / f64::from(per_octave)) - 1.0)
    }

    /// b at a place of a row and whether it is behind the foot point: the
    /// inverse of [`Axes::row`].
    pub(super) fn b(&self, row: u32, beta: f64) -> (f64, bool) {
        let behind = row >= self.rows[0];
        let first = if behind { self.rows[0] } else { 0 };
        let position = f64::from(row - first) + 0.5 + beta;
        let [across, along] = self.slope[usize::from(behind)].map(f64::from);
        ((position / (along - position * across)).min(1.0), behind)
    }
}

//! The texels that a ray crosses in one picture, and its lit parts there.

use glam::DVec3;

use super::line::Line;

/// The part of a ray in one picture, by the coordinate in which it is longer.
///
/// Cells are numbered along that coordinate, a column of texels or a row; a ray
/// crosses few texels of each. All positions are computed from the numbers of
/// cells and texels alone, not from the step before, so that whoever asks about a
/// part of the walk gets the bits of the whole.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk {
    line: Line,
    /// Homogeneous coordinates at the position 0 and their slope: along the cells,
    /// across, and w.
    at: DVec3,
    slope: DVec3,
    /// Where the part starts and ends.
    a: f64,
    b: f64,
    /// Texels per side.
    side: i64,
    /// Cells at the start and at the end.
    first: i64,
    last: i64,
    is_row_major: bool,
}

/// A lit part of a ray.
pub(super) type Part = [f64; 2];

/// Appends a lit part, or extends the last one.
pub(super) fn push(runs: &mut Vec<Part>, [start, end]: Part) {
    if !(start < end) {
        return;
    }
    match runs.last_mut() {
        Some(last) if start <= last[1] => last[1] = last[1].max(end),
        _ => runs.push([start, end]),
    }
}

impl Walk {
    /// The part `a` to `b` of a line whose pictures of position 0 and direction are
    /// `at` and `slope`.
    pub(super) fn new(line: &Line, [at, slope]: [DVec3; 2], [a, b]: Part, resolution: u32) -> Self {
        // The line's normal in the picture; the ray runs across it.
        let normal = at.cross(slope);
        let is_row_major = normal.x.abs() > normal.y.abs();
        let turn = |v: DVec3| {
            if is_row_major {
                DVec3::new(v.y, v.x, v.z)
            } else {
                v
            }
        };
        let mut walk = Self {
            line: *line,
            at: turn(at),
            slope: turn(slope),
            a,
            b,
            side: i64::from(resolution),
            first: 0,
            last: 0,
            is_row_major,
        };
        walk.first = walk.cell(walk.coordinate(0, a));
        walk.last = walk.cell(walk.coordinate(0, b));
        walk
    }

    pub(super) fn is_row_major(&self) -> bool {
        self.is_row_major
    }

    /// The coordinate along the cells somewhere inside of the part.
    pub(super) fn middle(&self) -> f64 {
        let [a, b] = [self.a, self.b];
        self.coordinate(
            0,
            if b < f64::INFINITY {
                0.5 * (a + b)
            } else {
                a + a.abs().max(1.0)
            },
        )
    }

    /// Cells at the start and at the end.
    pub(super) fn cells(&self) -> [i64; 2] {
        [self.first, self.last]
    }

    /// A coordinate at the position `s`: 0 along the cells, 1 across.
    #[inline]
    fn coordinate(&self, axis: usize, s: f64) -> f64 {
        if s < f64::INFINITY {
            (self.at[axis] + s * self.slope[axis]) / (self.at.z + s * self.slope.z)
        } else if self.slope.z != 0.0 {
            self.slope[axis] / self.slope.z
        } else if self.slope[axis] != 0.0 {
            f64::INFINITY.copysign(self.slope[axis])
        } else {
            self.at[axis] / self.at.z
        }
    }

    /// The cell, or texel across, at a coordinate.
    #[inline]
    fn cell(&self, coordinate: f64) -> i64 {
        let cell = (0.5 * (1.0 + coordinate) * self.side as f64).floor() as i64;
        cell.clamp(0, self.side - 1)
    }

    /// Where the ray crosses the border before the cell, or texel across.
    #[inline]
    fn border(&self, axis: usize, cell: i64) -> f64 {
        let border = (2 * cell - self.side) as f64 / self.side as f64;
        let s = (border * self.at.z - self.at[axis]) / (self.slope[axis] - border * self.slope.z);
        // Not a number where the ray runs along the border.
        if s < self.b { s.max(self.a) } else { self.b }
    }

    /// Where the ray enters a cell.
    #[inline]
    pub(super) fn entry(&self, cell: i64) -> f64 {
        if cell == self.first {
            self.a
        } else {
            self.border(0, cell + i64::from(self.last < self.first))
        }
    }

    /// Where the ray leaves a cell.
    #[inline]
    pub(super) fn exit(&self, cell: i64) -> f64 {
        if cell == self.last {
            self.b
        } else {
            self.border(0, cell + i64::from(self.first < self.last))
        }
    }

    /// Appends the lit parts of one cell, and tells the number of its texels that
    /// the ray crosses. `texels` are those of the picture, row by row.
    #[inline]
    pub(super) fn add_cell(&self, texels: &[f32], cell: i64, runs: &mut Vec<Part>) -> u32 {
        let (start, end) = (self.entry(cell), self.exit(cell));
        let from = self.cell(self.coordinate(1, start));
        let to = self.cell(self.coordinate(1, end));
        let step = if to < from { -1 } else { 1 };
        let mut s = start;
        let mut across = from;
        loop {
            let next = if across == to {
                end
            } else {
                let border = self.border(1, across + i64::from(step > 0));
                border.clamp(start, end.max(start))
            };
            let (row, column) = match self.is_row_major {
                true => (cell, across),
                false => (across, cell),
            };
            // Cells and texels are within the picture.
            let depth = texels[(row * self.side + column) as usize];
            push(runs, self.line.up_to(depth, s, next));
            if across == to {
                return from.abs_diff(to) as u32 + 1;
            }
            s = next;
            across += step;
        }
    }

    /// Appends the lit parts of all cells, texel by texel, and tells the number of
    /// texels that the ray crosses.
    pub(super) fn add_all(&self, texels: &[f32], runs: &mut Vec<Part>) -> u32 {
        let step = if self.last < self.first { -1 } else { 1 };
        let mut crossed = 0;
        let mut cell = self.first;
        loop {
            crossed += self.add_cell(texels, cell, runs);
            if cell == self.last {
                return crossed;
            }
            cell += step;
        }
    }
}

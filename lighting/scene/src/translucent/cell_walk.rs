//! The cells of a grid on a line.

use glam::DVec3;

use super::DensityGrid;

/// The part of a line in one cell of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellSpan {
    /// Index of the cell along x, y and z.
    pub cell: [u32; 3],
    /// Where the line enters it, in units of the line's direction.
    pub from: f64,
    /// Where it leaves it, above `from`.
    pub to: f64,
    /// The point of the cell at which the line enters; each coordinate is from 0 to 1 across
    /// the cell.
    pub entry: DVec3,
    /// The point of the cell at which the line leaves.
    pub exit: DVec3,
}

impl CellSpan {
    /// The part of it between `from` and `to`, both within it.
    #[must_use]
    pub fn part(&self, from: f64, to: f64) -> Self {
        if (from, to) == (self.from, self.to) {
            return *self;
        }
        let at = |t: f64| self.place((t - self.from) / (self.to - self.from));
        Self {
            cell: self.cell,
            from,
            to,
            entry: at(from),
            exit: at(to),
        }
    }

    /// The point of the cell at a share of the span.
    pub(crate) fn place(&self, share: f64) -> DVec3 {
        self.entry * (1.0 - share) + self.exit * share
    }
}

/// The cells of a grid on a line, from front to back; see
/// [`DensityGrid::cells_along`](crate::DensityGrid::cells_along).
///
/// Spans follow each other without gaps and none is empty. There are at most as
/// many as the grid has cells along its three axes together.
#[derive(Debug, Clone)]
pub struct CellWalk {
    /// The line in units of cells.
    start: DVec3,
    direction: DVec3,
    cells: [u32; 3],
    cell: [u32; 3],
    /// Position at which the line leaves the cell, for the faces of each axis.
    leaving: [f64; 3],
    from: f64,
    end: f64,
}

impl CellWalk {
    pub(super) fn new(start: DVec3, direction: DVec3, cells: [u32; 3], from: f64, to: f64) -> Self {
        let mut walk = Self {
            start,
            direction,
            cells,
            cell: [0; 3],
            leaving: [f64::INFINITY; 3],
            from,
            end: to,
        };
        for axis in 0..3 {
            let (at, step, size) = (start[axis], direction[axis], f64::from(cells[axis]));
            if step == 0.0 {
                if !(at >= 0.0 && at <= size) {
                    walk.end = f64::NEG_INFINITY;
                }
                continue;
            }
            let (a, b) = (-at / step, (size - at) / step);
            walk.from = walk.from.max(a.min(b));
            walk.end = walk.end.min(a.max(b));
        }
        if walk.from < walk.end {
            walk.cell = [0, 1, 2].map(|axis| {
                let place = start[axis] + walk.from * direction[axis];
                (place.max(0.0) as u32).min(cells[axis] - 1)
            });
            walk.leaving = [0, 1, 2].map(|axis| walk.leaves(axis));
        }
        walk
    }

    fn leaves(&self, axis: usize) -> f64 {
        let step = self.direction[axis];
        let face = f64::from(self.cell[axis]) + f64::from(u8::from(step > 0.0));
        if step == 0.0 {
            f64::INFINITY
        } else {
            (face - self.start[axis]) / step
        }
    }

    fn place(&self, t: f64) -> DVec3 {
        let place = self.start + t * self.direction - DVec3::from_array(self.cell.map(f64::from));
        place.clamp(DVec3::ZERO, DVec3::ONE)
    }

    /// The next span in a cell that is wanted.
    fn next_where(&mut self, is_wanted: impl Fn([u32; 3]) -> bool) -> Option<CellSpan> {
        // A cell is left through one of three faces, and never entered again.
        while self.from < self.end {
            let leaving = self.leaving;
            let axis = (0..3).fold(0, |a, b| if leaving[b] < leaving[a] { b } else { a });
            let to = leaving[axis].min(self.end);
            let span = (to > self.from && is_wanted(self.cell)).then(|| CellSpan {
                cell: self.cell,
                from: self.from,
                to,
                entry: self.place(self.from),
                exit: self.place(to),
            });
            let next = if self.direction[axis] > 0.0 {
                (self.cell[axis] + 1 < self.cells[axis]).then_some(self.cell[axis] + 1)
            } else {
                self.cell[axis].checked_sub(1)
            };
            match next {
                Some(next) if leaving[axis] < self.end => {
                    self.cell[axis] = next;
                    self.leaving[axis] = self.leaves(axis);
                    self.from = self.from.max(to);
                }
                _ => self.from = self.end,
            }
            if span.is_some() {
                return span;
            }
        }
        None
    }
}

impl Iterator for CellWalk {
    type Item = CellSpan;

    fn next(&mut self) -> Option<CellSpan> {
        self.next_where(|_| true)
    }
}

/// The cells of a grid on a line in which there is anything, from front to back; see
/// [`DensityGrid::occupied_cells_along`].
///
/// Where there is nothing between spans there is a gap.
#[derive(Debug, Clone)]
pub struct OccupiedCells<'a> {
    pub(super) grid: &'a DensityGrid,
    pub(super) walk: CellWalk,
}

impl Iterator for OccupiedCells<'_> {
    type Item = CellSpan;

    fn next(&mut self) -> Option<CellSpan> {
        let grid = self.grid;
        self.walk.next_where(|cell| grid.is_occupied(cell))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_walk_goes_through_the_box_without_gaps() {
        for (start, direction) in [
            (DVec3::new(-5.0, 0.3, 0.7), DVec3::new(1.0, 0.5, 0.25)),
            (DVec3::new(9.0, 9.0, 9.0), DVec3::new(-1.0, -1.0, -1.0)),
            (DVec3::new(1.0, 1.0, -2.0), DVec3::new(0.0, 0.0, 0.3)),
            (DVec3::new(0.5, 2.5, 4.5), DVec3::new(1e-9, -2.0, -1e-7)),
            (DVec3::new(4.0, 0.0, 3.0), DVec3::new(0.0, 1.0, -1.0)),
        ] {
            let all = [f64::NEG_INFINITY, f64::INFINITY];
            let parts: Vec<_> =
                CellWalk::new(start, direction, [4, 5, 6], all[0], all[1]).collect();
            assert!(!parts.is_empty() && parts.len() <= 15, "{start}");
            for pair in parts.windows(2) {
                assert_eq!(pair[0].to, pair[1].from);
            }
            for part in parts {
                let middle = start + 0.5 * (part.from + part.to) * direction;
                let place = middle - DVec3::from_array(part.cell.map(f64::from));
                assert!(place.cmpge(DVec3::splat(-1e-9)).all(), "{place}");
                assert!(place.cmple(DVec3::splat(1.0 + 1e-9)).all(), "{place}");
                assert!(place.abs_diff_eq(0.5 * (part.entry + part.exit), 1e-9));
            }
        }
        let past = CellWalk::new(DVec3::new(-1.0, 0.0, 0.0), DVec3::Y, [1; 3], 0.0, 9.0);
        assert_eq!(past.count(), 0);
    }
}

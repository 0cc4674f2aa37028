//! The texels that a ray crosses in one picture, and its lit parts there.

use glam::DVec3;

use crate::shadow_map::line::{Line, Part, Runs, middle};

/// The part of a ray in one picture, along the coordinate in which it is longer.
///
/// Cells, which are columns or rows of texels, are numbered along that coordinate; a ray
/// crosses few texels of each. Borders are computed from the indices of cells and texels alone,
/// not from the step before, so that a part of the walk has the same bits as the whole.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk {
    line: Line,
    /// Homogeneous coordinates at position 0, and their slope: along the cells, across, and w.
    at: DVec3,
    slope: DVec3,
    /// The positions of the start and the end.
    a: f64,
    b: f64,
    /// Texels per side.
    side: i64,
    /// The cells at the start and at the end.
    first: i64,
    last: i64,
    is_row_major: bool,
}

/// Homogeneous coordinates of a picture, reordered so that the one along the cells comes first.
pub(super) fn turned(is_row_major: bool, v: DVec3) -> DVec3 {
    match is_row_major {
        true => DVec3::new(v.y, v.x, v.z),
        false => v,
    }
}

impl Walk {
    /// The part from `a` to `b` of a line; `at` and `slope` are the images of position 0 and of
    /// the direction.
    pub(super) fn new(line: &Line, [at, slope]: [DVec3; 2], [a, b]: Part, resolution: u32) -> Self {
        // The normal of the ray's image, which tells the coordinate in which it is longer.
        let normal = at.cross(slope);
        let is_row_major = normal.x.abs() > normal.y.abs();
        let mut walk = Self {
            line: *line,
            at: turned(is_row_major, at),
            slope: turned(is_row_major, slope),
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

    /// The coordinate along the cells at a position inside of the part.
    pub(super) fn middle(&self) -> f64 {
        self.coordinate(0, middle([self.a, self.b]))
    }

    /// Where the part starts.
    pub(super) fn start(&self) -> f64 {
        self.a
    }

    /// Cells at the start and at the end.
    pub(super) fn cells(&self) -> [i64; 2] {
        [self.first, self.last]
    }

    /// A coordinate at the position `s`: 0 along the cells, 1 across.
    #[inline]
    fn coordinate(&self, axis: usize, s: f64) -> f64 {
        let [at, w] = [axis, 2].map(|i| self.at[i] + s * self.slope[i]);
        // At the light itself the image is undefined; the direction of the ray takes its place.
        if s < f64::INFINITY && (at != 0.0 || w != 0.0) {
            at / w
        } else if self.slope.z != 0.0 {
            self.slope[axis] / self.slope.z
        } else if self.slope[axis] != 0.0 {
            f64::INFINITY.copysign(self.slope[axis])
        } else {
            self.at[axis] / self.at.z
        }
    }

    /// The cell, or the texel across, at a coordinate.
    #[inline]
    fn cell(&self, coordinate: f64) -> i64 {
        let cell = (0.5 * (1.0 + coordinate) * self.side as f64).floor() as i64;
        cell.clamp(0, self.side - 1)
    }

    /// The position at which the ray crosses the border in front of a cell, or of a texel
    /// across.
    #[inline]
    fn border(&self, axis: usize, cell: i64) -> f64 {
        let border = (2 * cell - self.side) as f64 / self.side as f64;
        let towards = self.slope[axis] - border * self.slope.z;
        // A ray that approaches the border for ever meets it at infinity.
        let s = match towards {
            0.0 => self.b,
            _ => (border * self.at.z - self.at[axis]) / towards,
        };
        s.max(self.a).min(self.b)
    }

    /// The position at which the ray leaves a cell, which is where it enters the next.
    #[inline]
    pub(super) fn exit(&self, cell: i64) -> f64 {
        if cell == self.last {
            self.b
        } else {
            self.border(0, cell + i64::from(self.first < self.last))
        }
    }

    /// Adds the lit parts of the cells `from` to `to`, starting at the position `start` where
    /// the ray enters the first one. Returns the number of texels that it crosses there.
    /// `texels` are those of the picture, row by row.
    #[inline]
    pub(super) fn add_cells<F: FnMut(Part)>(
        &self,
        texels: &[f32],
        [from, to]: [i64; 2],
        start: f64,
        runs: &mut Runs<F>,
    ) -> u32 {
        let step = if to < from { -1 } else { 1 };
        let mut crossed = 0;
        let mut cell = from;
        let mut s = start;
        let mut across = self.cell(self.coordinate(1, s));
        loop {
            let exit = self.exit(cell).max(s);
            let last = self.cell(self.coordinate(1, exit));
            let (base, stride) = match self.is_row_major {
                true => (cell * self.side, 1),
                false => (cell, self.side),
            };
            crossed += across.abs_diff(last) as u32 + 1;
            loop {
                let next = match last - across {
                    0 => exit,
                    more => self.border(1, across + i64::from(more > 0)).clamp(s, exit),
                };
                // Cells and texels are within the picture.
                let depth = texels[(base + across * stride) as usize];
                runs.push(self.line.up_to(depth, s, next));
                s = next;
                if across == last {
                    break;
                }
                across += (last - across).signum();
            }
            if cell == to {
                return crossed;
            }
            cell += step;
        }
    }

    /// The same of all cells.
    pub(super) fn add_all<F: FnMut(Part)>(&self, texels: &[f32], runs: &mut Runs<F>) -> u32 {
        self.add_cells(texels, [self.first, self.last], self.a, runs)
    }
}

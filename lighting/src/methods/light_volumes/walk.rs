//! The way of a ray through the mesh of a light volume.

use glam::DVec3;

use super::mesh::{Kind, Mesh, Patch, Plane};
use crate::shadow_map::EMPTY;
use crate::shadow_map::line::{Line, Part, Runs};

/// Positions on a ray end here.
pub(super) const FARTHEST: f64 = 1e18;

/// The part of a ray in one picture, measured in cells: a vertex is at the whole number
/// after its texel's.
///
/// All borders are computed from the numbers of cells alone, so that parts on their two
/// sides touch exactly.
#[derive(Debug, Clone, Copy)]
pub(super) struct Track {
    /// Homogeneous coordinates at the position 0 and their slope: along, across, w.
    at: DVec3,
    slope: DVec3,
    /// Height times w at the position 0, and its slope.
    height: [f64; 2],
    a: f64,
    b: f64,
    /// Number of the last cell along a side.
    side: i64,
    /// Cells at the start and at the end.
    first: [i64; 2],
    last: [i64; 2],
}

impl Track {
    /// The part `a` to `b` of a line whose pictures of position 0 and direction are given.
    pub(super) fn new(line: &Line, pictures: [DVec3; 2], [a, b]: Part, resolution: u32) -> Self {
        let n = f64::from(resolution);
        let [at, slope] = pictures.map(|v| {
            let cell = |x: f64| 0.5 * (n * (v.z + x) + v.z);
            DVec3::new(cell(v.x), cell(v.y), v.z)
        });
        let mut track = Self {
            at,
            slope,
            height: line.parallel_depth().unwrap_or([-1.0, 0.0]),
            a,
            b,
            side: i64::from(resolution),
            first: [0; 2],
            last: [0; 2],
        };
        track.first = [0, 1].map(|axis| track.cell(axis, a));
        track.last = [0, 1].map(|axis| track.cell(axis, b));
        track
    }

    #[inline]
    fn w(&self, s: f64) -> f64 {
        self.at.z + s * self.slope.z
    }

    /// The cell at the position `s`, along an axis.
    #[inline]
    fn cell(&self, axis: usize, s: f64) -> i64 {
        let (x, w) = (self.at[axis] + s * self.slope[axis], self.w(s));
        let coordinate = if w > 0.0 {
            x / w
        } else if x == 0.0 {
            // At the light itself the ray is where it goes.
            self.slope[axis] / self.slope.z
        } else {
            f64::INFINITY.copysign(x)
        };
        (coordinate.floor() as i64).clamp(0, self.side)
    }

    /// Where a x + b y + c is 0, x and y in cells.
    #[inline]
    fn crossing(&self, line: [f64; 3]) -> f64 {
        let line = DVec3::from(line);
        -line.dot(self.at) / line.dot(self.slope)
    }

    /// Where the ray crosses the border before a cell.
    #[inline]
    fn border(&self, axis: usize, cell: i64) -> f64 {
        let cell = cell as f64;
        let towards = self.slope[axis] - cell * self.slope.z;
        match towards {
            // It runs along the border.
            0.0 => self.b,
            _ => ((cell * self.at.z - self.at[axis]) / towards)
                .max(self.a)
                .min(self.b),
        }
    }

    /// Where the ray leaves a square of cells, along an axis.
    #[inline]
    fn exit(&self, axis: usize, from: i64, size: i64) -> f64 {
        let last = self.last[axis];
        if (from..from + size).contains(&last) {
            self.b
        } else if last < from {
            self.border(axis, from)
        } else {
            self.border(axis, from + size)
        }
    }

    /// Adds the lit parts of the ray in a picture.
    pub(super) fn add_lit<F: FnMut(Part)>(&self, mesh: &Mesh<'_>, face: usize, runs: &mut Runs<F>) {
        let mut cell = self.first;
        let mut s = self.a;
        // The smallest node with all of the way, or the patch that it is a part of.
        let differ = (self.first[0] ^ self.last[0]) | (self.first[1] ^ self.last[1]);
        let mut level = (i64::BITS - differ.leading_zeros()).max(1);
        let is_patch = |level: u32, [x, y]: [i64; 2]| {
            let [first, second] = mesh.node(face, level, x >> level, y >> level);
            first >= second
        };
        while level < mesh.layout.levels() && is_patch(level + 1, cell) {
            level += 1;
        }
        loop {
            let size = 1_i64 << level;
            let from = cell.map(|at| at & !(size - 1));
            let exits = [0, 1].map(|axis| self.exit(axis, from[axis], size));
            let exit = exits[0].min(exits[1]).max(s);
            let mut is_leaf = level == 0;
            if level > 0 {
                let node = mesh.node(face, level, cell[0] >> level, cell[1] >> level);
                is_leaf = node[0] >= node[1];
                if !is_leaf {
                    if self.is_before(node[0], [s, exit]) {
                        runs.push([s, exit]);
                    } else if !self.is_behind(node[1], [s, exit]) {
                        level -= 1;
                        continue;
                    }
                }
            }
            if is_leaf {
                self.add_patch(&mesh.patch(face, level, from), s, exit, runs);
            }
            if exits == [self.b; 2] {
                return;
            }
            let step = usize::from(exits[1] < exits[0]);
            let other = 1 - step;
            let (old, new) = match self.last[step] < from[step] {
                true => (from[step], from[step] - 1),
                false => (from[step] + size - 1, from[step] + size),
            };
            // The largest node that begins here is part of one that is known to be mixed.
            level = (old ^ new).ilog2();
            cell[step] = new;
            // Onwards, no farther than the square or the end.
            let (now, last) = (cell[other], self.last[other]);
            let across = self.cell(other, exit);
            cell[other] = match now <= last {
                true => across.max(now).min(last).min(from[other] + size - 1),
                false => across.min(now).max(last).max(from[other]),
            };
            s = exit;
        }
    }

    /// How far before a plane over a square the ray is, times w: linear in `s`. Slopes
    /// are those of a cell.
    #[inline]
    fn before(&self, origin: [f64; 2], plane: Plane, s: f64) -> f64 {
        let at = self.at + s * self.slope;
        let height = self.height[0] + s * self.height[1];
        let [x, y] = [at.x - origin[0] * at.z, at.y - origin[1] * at.z];
        plane.base * at.z + plane.x * x + plane.y * y - height
    }

    /// Whether all of a part is before a height, or at it.
    #[inline]
    fn is_before(&self, height: f32, part: Part) -> bool {
        let is_before = |s| self.before([0.0; 2], Plane::level(height), s) >= 0.0;
        height == EMPTY || part.into_iter().all(is_before)
    }

    /// Whether all of a part is behind a height.
    #[inline]
    fn is_behind(&self, height: f32, part: Part) -> bool {
        let is_behind = |s| self.before([0.0; 2], Plane::level(height), s) < 0.0;
        height < EMPTY && part.into_iter().all(is_behind)
    }

    /// Adds the lit parts between the positions where the ray enters and leaves a patch.
    fn add_patch<F: FnMut(Part)>(&self, patch: &Patch, a: f64, b: f64, runs: &mut Runs<F>) {
        let ([x, y], size) = (patch.origin, patch.size);
        // Where another part of the surface begins.
        let none = f64::INFINITY;
        let splits = match patch.kind {
            Kind::Nothing => {
                runs.push([a, b]);
                return;
            }
            Kind::Falling => [self.crossing([1.0, -1.0, y - x]), none],
            Kind::Rising => [self.crossing([1.0, 1.0, -(x + y + size)]), none],
            Kind::Wall => [
                self.crossing([1.0, 0.0, -(x + 0.5)]),
                self.crossing([0.0, 1.0, -(y + 0.5)]),
            ],
        };
        let mut s = a;
        while s < b {
            let mut next = b;
            for split in splits {
                if s < split && split < next {
                    next = split;
                }
            }
            let middle = 0.5 * (s + next);
            let place = (self.at + middle * self.slope) / self.w(middle);
            let plane = patch.plane((place.x - x) / size, (place.y - y) / size);
            if plane.base >= f64::from(EMPTY) {
                runs.push([s, next]);
            } else {
                let plane = Plane {
                    x: plane.x / size,
                    y: plane.y / size,
                    ..plane
                };
                let [g, h] = [s, next].map(|s| self.before(patch.origin, plane, s));
                // Infinite where it is on neither side, which neither branch asks for.
                let crossing = (s + (next - s) * (g / (g - h))).clamp(s, next);
                match (g >= 0.0, h >= 0.0) {
                    (true, true) => runs.push([s, next]),
                    (true, false) => runs.push([s, crossing]),
                    (false, true) => runs.push([crossing, next]),
                    (false, false) => {}
                }
            }
            s = next;
        }
    }
}

//! A triangle as the light sees it.

use glam::{DVec3, DVec4};

use super::clip::clip;
use crate::identity::Identity;
use crate::{LightSpace, Slices};

/// The width of the map in steps of the grid to which vertices are snapped:
/// sixteen steps to a texel at the highest resolution.
pub(crate) const ONE: i32 = 1 << 24;

/// How far beside the map corners may lie, in widths of the map: products of
/// two differences then fit in 60 bits.
const GUARD: f64 = 15.0;

/// What a triangle means for a ray of the light that meets it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// It enters a solid here.
    Front,
    /// A surface that encloses nothing.
    Open,
    /// It leaves a solid here.
    Back,
}

/// A triangle on the grid. Depths are of a kind that is linear over the map
/// and grows with the distance: the depth itself, or −1/distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Triangle {
    /// Corners, the area at their left side or zero.
    corners: [[i32; 2]; 3],
    pub(crate) kind: Kind,
    /// The depth at the first corner, and per step along x and y.
    depth: f64,
    slope: [f64; 2],
    /// The least and the largest depth of a corner.
    range: [f64; 2],
    /// Seen from its edge: no sample is in it, but it is in the way, at all
    /// of its depths.
    thin: bool,
    /// Its number among those with holes, or [`WHOLE`].
    mask: u32,
}

/// The mask of a triangle without holes.
const WHOLE: u32 = u32::MAX;

/// Rounding errors of a depth, relative to the sum of the sizes of its three
/// terms: three products and sums lose half a unit in the last place each.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

impl Triangle {
    pub(crate) fn bounds(&self) -> [[i32; 2]; 2] {
        let [a, b, c] = self.corners;
        [
            [0, 1].map(|i| a[i].min(b[i]).min(c[i])),
            [0, 1].map(|i| a[i].max(b[i]).max(c[i])),
        ]
    }

    /// The same with the holes of this number.
    pub(crate) fn covered(self, mask: u32) -> Self {
        Self { mask, ..self }
    }

    /// What tells it from others but for its holes.
    pub(crate) fn identity(&self) -> Identity {
        let corners = self.corners.as_flattened().iter();
        let corners = corners.map(|&at| u64::from(at as u32));
        let depths = [self.depth, self.slope[0], self.slope[1]];
        let depths = depths.into_iter().chain(self.range).map(f64::to_bits);
        let kinds = [self.kind as u64, u64::from(self.thin)];
        let words = corners.chain(depths).chain(kinds);
        words.fold(Identity::new(), Identity::with)
    }

    /// The number of its holes, if it has any.
    pub(crate) fn mask(&self) -> Option<u32> {
        (self.mask != WHOLE).then_some(self.mask)
    }

    /// Corners, the area at their left side or zero.
    #[cfg(all(feature = "wgpu", not(target_family = "wasm")))]
    pub(crate) fn corners(&self) -> [[i32; 2]; 3] {
        self.corners
    }

    /// The depths of the corners, and the least and the largest of them.
    #[cfg(all(feature = "wgpu", not(target_family = "wasm")))]
    pub(crate) fn corner_depths(&self) -> ([f64; 3], [f64; 2]) {
        (self.corners.map(|corner| self.depth(corner)), self.range)
    }

    /// Twice the area, in squares of the grid.
    pub(crate) fn twice_area(&self) -> i64 {
        self.edge(0, self.corners[2])
    }

    /// The edge function of edge `i` at a point: positive at its left side.
    fn edge(&self, i: usize, at: [i32; 2]) -> i64 {
        let from = self.corners[i];
        let step = self.step(i);
        i64::from(at[1] - from[1]) * step[0] - i64::from(at[0] - from[0]) * step[1]
    }

    fn step(&self, i: usize) -> [i64; 2] {
        let (from, to) = (self.corners[i], self.corners[(i + 1) % 3]);
        [i64::from(to[0] - from[0]), i64::from(to[1] - from[1])]
    }

    /// True if the triangle, rim included, and the box from `low` to `high`
    /// may have a point in common. Never false if they have.
    pub(crate) fn meets(&self, low: [i32; 2], high: [i32; 2]) -> bool {
        let bounds = self.bounds();
        let apart = |i: usize| bounds[0][i] > high[i] || bounds[1][i] < low[i];
        !apart(0)
            && !apart(1)
            && (0..3).all(|i| {
                // The corner of the box that is furthest to the left.
                let step = self.step(i);
                let x = if step[1] > 0 { low[0] } else { high[0] };
                let y = if step[0] > 0 { high[1] } else { low[1] };
                self.edge(i, [x, y]) >= 0
            })
    }

    /// What has to be added to edge function `i` so that samples on an edge
    /// belong to one of the two triangles at it: all but top and left edges
    /// lose them.
    fn bias(&self, i: usize) -> i64 {
        let [dx, dy] = self.step(i);
        let top_left = dy < 0 || (dy == 0 && dx > 0);
        if top_left { 0 } else { -1 }
    }

    /// True if a sample belongs to the triangle.
    pub(crate) fn covers(&self, at: [i32; 2]) -> bool {
        (0..3).all(|i| self.edge(i, at) + self.bias(i) >= 0)
    }

    /// [`Triangle::covers`] for 8×8 samples from `first` on, one each `step`;
    /// bit `8 y + x`.
    pub(crate) fn coverage(&self, first: [i32; 2], step: i32) -> u64 {
        let mut mask = u64::MAX;
        for i in 0..3 {
            let at_first = self.edge(i, first) + self.bias(i);
            let [dx, dy] = self.step(i).map(|d| d * i64::from(step));
            let mut outside = 0_u64;
            for y in 0..8 {
                let row = at_first + y * dx;
                for x in 0..8 {
                    let sign = (row - x * dy) as u64 >> 63;
                    outside |= sign << (8 * y + x);
                }
            }
            mask &= !outside;
        }
        mask
    }

    /// The depth at a point: of the plane, but never beyond the corners'.
    pub(crate) fn depth(&self, at: [i32; 2]) -> f64 {
        let d = [0, 1].map(|i| f64::from(at[i] - self.corners[0][i]));
        (self.depth + self.slope[0] * d[0] + self.slope[1] * d[1])
            .clamp(self.range[0], self.range[1])
    }

    /// [`Triangle::depth`] of 8×8 samples from `first` on, one each `step`;
    /// number `8 y + x`.
    pub(crate) fn depth_rows(&self, first: [i32; 2], step: i32) -> [f64; 64] {
        let along = |axis: usize, number: i32| {
            self.slope[axis] * f64::from(first[axis] + number * step - self.corners[0][axis])
        };
        let numbers = [0, 1, 2, 3, 4, 5, 6, 7];
        let columns = numbers.map(|x| self.depth + along(0, x));
        let [least, most] = self.range;
        let mut depths = [0.0; 64];
        for (row, y) in depths.chunks_exact_mut(8).zip(numbers) {
            let down = along(1, y);
            for (depth, column) in row.iter_mut().zip(columns) {
                // This is `clamp` in a form that the compiler turns into vector instructions.
                let plane = column + down;
                let raised = if plane < least { least } else { plane };
                *depth = if raised > most { most } else { raised };
            }
        }
        depths
    }

    /// True if all samples of the box from `low` to `high` belong to the
    /// triangle, for sure.
    pub(crate) fn fills(&self, low: [i32; 2], high: [i32; 2]) -> bool {
        self.mask == WHOLE
            && [low, [high[0], low[1]], [low[0], high[1]], high]
                .into_iter()
                .all(|corner| self.covers(corner))
    }

    /// By how much depths grow per step along x and y, and a bound of how far
    /// those of two samples of the box from `low` to `high` may be from that.
    pub(crate) fn plane(&self, low: [i32; 2], high: [i32; 2]) -> ([f64; 2], f64) {
        let mut size = self.depth.abs();
        for i in 0..2 {
            let reach = |at: i32| f64::from(at - self.corners[0][i]).abs();
            size += self.slope[i].abs() * reach(low[i]).max(reach(high[i]));
        }
        (self.slope, 2.0 * ROUNDING * size)
    }

    /// How much nearer than `depth` a back face may seem to be that the
    /// triangle touches: corners of either are off by half a step along x and
    /// y, and depths rounded as if from f32.
    pub(crate) fn touch(&self, depth: f64) -> f64 {
        self.snapped() + f64::from(f32::EPSILON) * depth.abs()
    }

    /// How much of that is due to corners.
    pub(crate) fn snapped(&self) -> f64 {
        let [x, y] = self.slope.map(f64::abs);
        (2.0 * (x + y)).min(self.range[1] - self.range[0])
    }

    /// Bounds of [`Triangle::depth`] over the box from `low` to `high`.
    pub(crate) fn depths(&self, low: [i32; 2], high: [i32; 2]) -> [f64; 2] {
        if self.thin {
            return self.range;
        }
        let (mut least, mut most, mut size) = (self.depth, self.depth, self.depth.abs());
        for i in 0..2 {
            let a = self.slope[i] * f64::from(low[i] - self.corners[0][i]);
            let b = self.slope[i] * f64::from(high[i] - self.corners[0][i]);
            least += a.min(b);
            most += a.max(b);
            size += a.abs().max(b.abs());
        }
        let margin = ROUNDING * size;
        let clamp = |depth: f64| depth.clamp(self.range[0], self.range[1]);
        [clamp(least - margin), clamp(most + margin)]
    }
}

/// Turns triangles of the space of a light into those of the grid.
#[derive(Debug)]
pub(crate) struct Setup {
    /// The distance at which a perspective light begins.
    near: Option<f64>,
    /// Whether the space of the light is a mirror image.
    mirrored: bool,
}

impl Setup {
    pub(crate) fn new(light: &LightSpace) -> Self {
        let row = |i: usize| light.matrix().row(i).truncate();
        let (near, depth): (_, DVec3) = match light.slices() {
            Slices::Linear => (None, row(2)),
            Slices::Logarithmic(ends) => (Some(ends.near()), row(3)),
        };
        Self {
            near,
            mirrored: row(0).cross(row(1)).dot(depth) < 0.0,
        }
    }

    /// A triangle, given by homogeneous coordinates `(X, Y, depth, W)`; none
    /// if it has to be clipped, or is nowhere.
    pub(crate) fn whole(&self, corners: [DVec4; 3], closed: bool) -> Option<Triangle> {
        let inside = |p: &DVec4| {
            let axis = |x: f64| x + GUARD * p.w >= 0.0 && (1.0 + GUARD) * p.w - x >= 0.0;
            self.near.is_none_or(|near| p.w - near >= 0.0) && axis(p.x) && axis(p.y)
        };
        (corners.iter().all(inside))
            .then(|| self.triangle(corners, closed))
            .flatten()
    }

    /// The parts of a triangle within the range of numbers.
    pub(crate) fn clipped(
        &self,
        corners: [DVec4; 3],
        closed: bool,
    ) -> impl Iterator<Item = Triangle> {
        let mut polygon = corners.to_vec();
        if let Some(near) = self.near {
            clip(&mut polygon, |p| p.w - near);
        }
        for axis in 0..2 {
            clip(&mut polygon, |p| p[axis] + GUARD * p.w);
            clip(&mut polygon, |p| (1.0 + GUARD) * p.w - p[axis]);
        }
        (2..polygon.len()).filter_map(move |i| {
            let corners = [polygon[0], polygon[i - 1], polygon[i]];
            self.triangle(corners, closed)
        })
    }

    fn triangle(&self, corners: [DVec4; 3], closed: bool) -> Option<Triangle> {
        let snap = |x: f64| (x * f64::from(ONE)).round() as i32;
        let depth = |p: DVec4| if self.near.is_some() { -1.0 / p.w } else { p.z };
        let mut points = corners.map(|p| ([snap(p.x / p.w), snap(p.y / p.w)], depth(p)));
        if points.iter().any(|(_, depth)| !depth.is_finite()) {
            return None;
        }
        let area = |points: &[([i32; 2], f64); 3]| {
            let step = |i: usize| [0, 1].map(|k| i64::from(points[i].0[k] - points[0].0[k]));
            let (u, v) = (step(1), step(2));
            u[0] * v[1] - u[1] * v[0]
        };
        let mut twice = area(&points);
        // Seen from the light, with rows downwards, front faces turn left to
        // right: their area is negative.
        let front = (twice < 0) != self.mirrored;
        if twice < 0 {
            points.swap(1, 2);
            twice = -twice;
        }
        let kind = match (closed, front) {
            (false, _) => Kind::Open,
            (true, true) => Kind::Front,
            (true, false) => Kind::Back,
        };
        let d = [1, 2].map(|i: usize| {
            let [x, y] = [0, 1].map(|k| f64::from(points[i].0[k] - points[0].0[k]));
            (x, y, points[i].1 - points[0].1)
        });
        let [(x1, y1, z1), (x2, y2, z2)] = d;
        let thin = twice == 0;
        let slope = if thin {
            [0.0; 2]
        } else {
            [z1 * y2 - z2 * y1, z2 * x1 - z1 * x2].map(|slope| slope / twice as f64)
        };
        let depths = points.map(|(_, depth)| depth);
        Some(Triangle {
            corners: points.map(|(corner, _)| corner),
            kind,
            depth: depths[0],
            slope,
            range: [
                depths[0].min(depths[1]).min(depths[2]),
                depths[0].max(depths[1]).max(depths[2]),
            ],
            thin,
            mask: WHOLE,
        })
    }
}

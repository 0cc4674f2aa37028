//! Scan conversion of triangles as a light sees them.
//!
//! A [`Face`] is a square picture plane of a light. A triangle over it is
//! reduced to linear functions of the texel position ([`Footprint`]): three
//! whose signs tell coverage, one that gives the depth. Coverage is the sign of
//! the determinants that decide whether a ray through the texel centre meets
//! the triangle, so triangles that reach behind the light need no clipping and
//! common edges leave no gaps.
//!
//! [`nearest_depths`] has the nearest of many triangles in each texel.

mod nearest;

use std::ops::Range;

use glam::{DVec3, Quat, Vec3};

use crate::Bounds;

pub use nearest::nearest_depths;

/// A picture plane of a light, with `resolution` × `resolution` texels; row 0 is on top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// A point of every light ray for a perspective face; the point from which
    /// depth counts for an orthographic one.
    pub origin: Vec3,
    /// Unit vector to the right of the picture.
    pub right: Vec3,
    /// Unit vector to the top of the picture.
    pub up: Vec3,
    /// Unit vector into the picture: `up × right`.
    pub forward: Vec3,
    /// How light rays run.
    pub rays: Rays,
}

impl Face {
    /// The tightest picture of a box in the unit direction `direction`. Depth is the distance
    /// from a plane in front of the box.
    pub fn orthographic(bounds: Bounds, direction: Vec3) -> Self {
        let (min, max) = (bounds.min(), bounds.max());
        let centre = 0.5 * (min + max);
        let half = 0.5 * (max - min);
        let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, direction);
        let (right, up) = (rotation * Vec3::X, rotation * Vec3::Y);
        // Half the extent of the box along an axis, with a margin for rounding.
        let reach = |axis: Vec3| axis.abs().dot(half) * (1.0 + 1e-6);
        Self {
            origin: centre - reach(direction) * direction,
            right,
            up,
            forward: direction,
            rays: Rays::Parallel {
                half_width: reach(right),
                half_height: reach(up),
            },
        }
    }
}

/// How the light rays of a [`Face`] run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rays {
    /// Parallel to `forward`; the picture spans `half_width` to either side
    /// and `half_height` up and down, metres. Depth is the distance along
    /// `forward`.
    Parallel {
        /// Half the width of the picture, m.
        half_width: f32,
        /// Half the height of the picture, m.
        half_height: f32,
    },
    /// From `origin`; the picture spans the tangent `tan` to all four sides.
    /// Depth is the Euclidean distance from `origin`.
    Central {
        /// Tangent of half the opening angle.
        tan: f32,
    },
}

/// `a x + b y + c` over texel coordinates.
#[derive(Debug, Clone, Copy)]
struct Linear {
    a: f64,
    b: f64,
    c: f64,
}

impl Linear {
    fn at(&self, x: f64, y: f64) -> f64 {
        self.a * x + (self.b * y + self.c)
    }
}

/// The linear functions of a triangle.
#[derive(Debug, Clone, Copy)]
struct Lines {
    edges: [Linear; 3],
    /// Depth, or the reciprocal of the distance per length of the ray.
    depth: Linear,
    /// 0 if the triangle is seen edge-on, and not finite if the corners are too far apart for
    /// f64. Its sign tells the sides of the triangle apart.
    determinant: f64,
}

impl Lines {
    fn cover_anything(&self) -> bool {
        self.determinant != 0.0 && self.determinant.is_finite()
    }
}

/// How points in the frame of a face are projected, and what triangles look like then. All
/// functions are inlined, so that loops over many triangles are compiled for vectors.
trait Projection: Copy + Sync {
    /// A corner as [`Projection::lines`] and [`Projection::box_of`] take it.
    fn place(self, local: DVec3) -> DVec3;

    fn lines(self, corners: [DVec3; 3]) -> Lines;

    /// The box around a triangle in texels, and whether it can be relied on: not if a corner is
    /// behind the light, see [`Projection::clipped_box_of`].
    fn box_of(self, corners: [DVec3; 3]) -> (Bounds2, bool);

    /// The box around the part of a triangle in front of the light in texels, `None` if there
    /// is none.
    fn clipped_box_of(self, corners: [DVec3; 3]) -> Option<Bounds2>;
}

/// The projection of [`Rays::Parallel`].
#[derive(Debug, Clone, Copy)]
struct Parallel {
    /// Half the resolution.
    centre: f64,
    /// Texels per metre.
    scale_x: f64,
    scale_y: f64,
}

impl Parallel {
    fn new(half_width: f32, half_height: f32, resolution: u32) -> Self {
        let n = f64::from(resolution);
        Self {
            centre: 0.5 * n,
            scale_x: 0.5 * n / f64::from(half_width),
            scale_y: 0.5 * n / f64::from(half_height),
        }
    }
}

impl Projection for Parallel {
    #[inline(always)]
    fn place(self, p: DVec3) -> DVec3 {
        DVec3::new(
            self.centre + p.x * self.scale_x,
            self.centre - p.y * self.scale_y,
            p.z,
        )
    }

    #[inline(always)]
    fn lines(self, [a, b, c]: [DVec3; 3]) -> Lines {
        let (e, f) = (b - a, c - a);
        let area = e.x * f.y - e.y * f.x;
        let sign = area.signum();
        let edge = |p: DVec3, q: DVec3| Linear {
            a: sign * (p.y - q.y),
            b: sign * (q.x - p.x),
            c: sign * (p.x * q.y - p.y * q.x),
        };
        let slope_x = (e.z * f.y - f.z * e.y) / area;
        let slope_y = (f.z * e.x - e.z * f.x) / area;
        Lines {
            edges: [edge(a, b), edge(b, c), edge(c, a)],
            depth: Linear {
                a: slope_x,
                b: slope_y,
                c: a.z - slope_x * a.x - slope_y * a.y,
            },
            determinant: area,
        }
    }

    #[inline(always)]
    fn box_of(self, corners: [DVec3; 3]) -> (Bounds2, bool) {
        let [a, b, c] = corners.map(|p| (p.x, p.y));
        (Bounds2::NOTHING.and(a).and(b).and(c), true)
    }

    fn clipped_box_of(self, corners: [DVec3; 3]) -> Option<Bounds2> {
        Some(self.box_of(corners).0)
    }
}

/// The projection of [`Rays::Central`]: the ray of the texel position (x, y) is
/// (x step − tan, tan − y step, 1).
#[derive(Debug, Clone, Copy)]
struct Central {
    tan: f64,
    step: f64,
}

impl Central {
    fn new(tan: f32, resolution: u32) -> Self {
        let tan = f64::from(tan);
        Self {
            tan,
            step: 2.0 * tan / f64::from(resolution),
        }
    }

    #[inline(always)]
    fn in_texels(self, projected: Bounds2) -> Bounds2 {
        let to_x = |u: f64| (u + self.tan) / self.step;
        let to_y = |v: f64| (self.tan - v) / self.step;
        Bounds2 {
            min: (to_x(projected.min.0), to_y(projected.max.1)),
            max: (to_x(projected.max.0), to_y(projected.min.1)),
        }
    }
}

impl Projection for Central {
    #[inline(always)]
    fn place(self, local: DVec3) -> DVec3 {
        local
    }

    #[inline(always)]
    fn lines(self, [a, b, c]: [DVec3; 3]) -> Lines {
        // A ray r meets the triangle if it is a positive combination of the
        // corners; the weights are the three determinants over det(a, b, c).
        let (bc, ca, ab) = (b.cross(c), c.cross(a), a.cross(b));
        let determinant = a.dot(bc);
        let Self { tan, step } = self;
        let over_texels = |v: DVec3| Linear {
            a: v.x * step,
            b: -v.y * step,
            c: tan * (v.y - v.x) + v.z,
        };
        let sign = determinant.signum();
        let normal = (b - a).cross(c - a);
        Lines {
            edges: [bc, ca, ab].map(|v| over_texels(sign * v)),
            depth: over_texels(normal / normal.dot(a)),
            determinant,
        }
    }

    #[inline(always)]
    fn box_of(self, corners: [DVec3; 3]) -> (Bounds2, bool) {
        let near = nearest_in_front(&corners);
        let [a, b, c] = corners.map(|p| (p.x / p.z, p.y / p.z));
        let projected = Bounds2::NOTHING.and(a).and(b).and(c);
        let [a, b, c] = corners.map(|corner| corner.z >= near);
        (self.in_texels(projected), a & b & c)
    }

    fn clipped_box_of(self, corners: [DVec3; 3]) -> Option<Bounds2> {
        in_front(&corners).map(|projected| self.in_texels(projected))
    }
}

/// A triangle over the texels of a face.
#[derive(Debug, Clone, Copy)]
pub struct Footprint {
    lines: Lines,
    /// Which of the edges lies across from the second and from the third corner.
    across: [usize; 2],
    /// The projection of a perspective face.
    central: Option<Central>,
    front: bool,
    columns: (u32, u32),
    rows: (u32, u32),
}

impl Footprint {
    /// `None` if the triangle covers no texel centre: it is outside of the
    /// picture, behind the light, seen edge-on, or falls between the centres.
    pub fn new(face: &Face, triangle: &[Vec3; 3], resolution: u32) -> Option<Self> {
        let local = triangle.map(|corner| {
            let v = (corner - face.origin).as_dvec3();
            DVec3::new(
                v.dot(face.right.as_dvec3()),
                v.dot(face.up.as_dvec3()),
                v.dot(face.forward.as_dvec3()),
            )
        });
        match face.rays {
            Rays::Parallel {
                half_width,
                half_height,
            } => {
                let projection = Parallel::new(half_width, half_height, resolution);
                let (lines, [columns, rows]) = seen(projection, local, resolution)?;
                Some(Self {
                    lines,
                    // Edges begin at the first corner.
                    across: [2, 0],
                    central: None,
                    // Rows grow downwards, which turns counter-clockwise around.
                    front: lines.determinant < 0.0,
                    columns,
                    rows,
                })
            }
            Rays::Central { tan } => {
                let projection = Central::new(tan, resolution);
                let (lines, [columns, rows]) = seen(projection, local, resolution)?;
                Some(Self {
                    lines,
                    across: [1, 2],
                    central: Some(projection),
                    // This is negative in a right-handed frame, but (right, up, forward) is
                    // left-handed.
                    front: lines.determinant > 0.0,
                    columns,
                    rows,
                })
            }
        }
    }

    /// True if the light sees the outside (counter-clockwise side) of the
    /// triangle.
    pub fn is_front(&self) -> bool {
        self.front
    }

    /// First row that may be covered, and the one after the last.
    pub fn rows(&self) -> (u32, u32) {
        self.rows
    }

    /// Calls `texel(x, y, depth)` for every covered texel centre of the rows
    /// from `first` to before `end`.
    pub fn for_each(&self, first: u32, end: u32, mut texel: impl FnMut(u32, u32, f32)) {
        for row in self.rows.0.max(first)..self.rows.1.min(end) {
            let y = f64::from(row) + 0.5;
            let Some((from, to)) = self.covered_columns(y) else {
                continue;
            };
            for column in from..to {
                let x = f64::from(column) + 0.5;
                if self.lines.edges.iter().all(|edge| edge.at(x, y) >= 0.0) {
                    let depth = self.depth_at(x, y);
                    texel(column, row, depth);
                }
            }
        }
    }

    /// First column that may be covered, and the one after the last.
    pub fn columns(&self) -> (u32, u32) {
        self.columns
    }

    /// Calls `texel(x, y, depth)` for the covered texel centres in these ranges.
    /// A centre exactly on the common edge of two triangles that lie on its two
    /// sides is covered by one of them only.
    pub fn for_each_once(
        &self,
        columns: Range<u32>,
        rows: Range<u32>,
        mut texel: impl FnMut(u32, u32, f32),
    ) {
        // Two neighbours have the same line for their common edge with opposite signs, to the
        // last digit; one of the two owns the points on it.
        let covers = |edge: &Linear, x: f64, y: f64| {
            let value = edge.at(x, y);
            value > 0.0 || (value == 0.0 && (edge.a > 0.0 || (edge.a == 0.0 && edge.b > 0.0)))
        };
        for row in self.rows.0.max(rows.start)..self.rows.1.min(rows.end) {
            let y = f64::from(row) + 0.5;
            let Some((from, to)) = self.covered_columns(y) else {
                continue;
            };
            for column in from.max(columns.start)..to.min(columns.end) {
                let x = f64::from(column) + 0.5;
                if self.lines.edges.iter().all(|edge| covers(edge, x, y)) {
                    texel(column, row, self.depth_at(x, y));
                }
            }
        }
    }

    /// Barycentric coordinates of the triangle's second and third corner where the
    /// ray through the centre of a texel meets its plane.
    pub fn barycentric(&self, x: u32, y: u32) -> [f64; 2] {
        let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let weights = self.lines.edges.map(|edge| edge.at(x, y));
        let sum: f64 = weights.iter().sum();
        self.across.map(|edge| weights[edge] / sum)
    }

    /// The columns of a row in which all edges can be positive, one texel
    /// wider on either side than rounding may take away.
    fn covered_columns(&self, y: f64) -> Option<(u32, u32)> {
        let (mut from, mut to) = (f64::from(self.columns.0), f64::from(self.columns.1));
        for edge in &self.lines.edges {
            let rest = edge.b * y + edge.c;
            let crossing = -rest / edge.a;
            if edge.a > 0.0 {
                from = from.max(crossing - 1.5);
            } else if edge.a < 0.0 {
                to = to.min(crossing + 1.5);
            } else if rest < 0.0 {
                return None;
            }
        }
        // Float to integer conversion saturates, NaN becomes 0.
        (from < to).then(|| (from.max(0.0) as u32, to.ceil() as u32))
    }

    fn depth_at(&self, x: f64, y: f64) -> f32 {
        let value = self.lines.depth.at(x, y);
        let depth = match self.central {
            None => value,
            Some(Central { tan, step }) => {
                let (u, v) = (x * step - tan, tan - y * step);
                (u * u + v * v + 1.0).sqrt() / value
            }
        };
        depth as f32
    }
}

/// The lines of a triangle, and the columns and rows in which it may cover texel centres; `None`
/// if it covers none.
fn seen<P: Projection>(
    projection: P,
    local: [DVec3; 3],
    resolution: u32,
) -> Option<(Lines, [(u32, u32); 2])> {
    let corners = local.map(|corner| projection.place(corner));
    let lines = projection.lines(corners);
    if !lines.cover_anything() {
        return None;
    }
    let bounds = projection.clipped_box_of(corners)?;
    let [columns, rows] = bounds.texels(f64::from(resolution));
    let whole = |[first, end]: [f64; 2]| (first < end).then_some((first as u32, end as u32));
    Some((lines, [whole(columns)?, whole(rows)?]))
}

#[derive(Debug, Clone, Copy)]
struct Bounds2 {
    min: (f64, f64),
    max: (f64, f64),
}

impl Bounds2 {
    const NOTHING: Self = Self {
        min: (f64::INFINITY, f64::INFINITY),
        max: (f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    #[inline(always)]
    fn and(self, (x, y): (f64, f64)) -> Self {
        Self {
            min: (lesser(self.min.0, x), lesser(self.min.1, y)),
            max: (greater(self.max.0, x), greater(self.max.1, y)),
        }
    }

    /// The columns and the rows whose centres may lie within: [`texels_between`].
    #[inline(always)]
    fn texels(self, resolution: f64) -> [[f64; 2]; 2] {
        [
            texels_between(self.min.0, self.max.0, resolution),
            texels_between(self.min.1, self.max.1, resolution),
        ]
    }
}

/// The bounds of the central projection of the part of a triangle in front of
/// the light, `None` if there is none. Corners behind the light are replaced by
/// points of the edges just in front of it.
fn in_front(corners: &[DVec3; 3]) -> Option<Bounds2> {
    let near = nearest_in_front(corners);
    let mut bounds = None;
    let mut add = |point: (f64, f64)| {
        bounds = Some(bounds.unwrap_or(Bounds2::NOTHING).and(point));
    };
    for i in 0..3 {
        let (p, q) = (corners[i], corners[(i + 1) % 3]);
        if p.z >= near {
            add((p.x / p.z, p.y / p.z));
        }
        if (p.z >= near) != (q.z >= near) {
            let cut = p + (q - p) * ((near - p.z) / (q.z - p.z));
            add((cut.x / near, cut.y / near));
        }
    }
    bounds
}

/// The lesser of two numbers by one instruction, which gives `b` if one of them is NaN.
#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater of two numbers by one instruction, which gives `b` if one of them is NaN.
#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The distance along `forward` from which on a corner counts as in front of the light.
#[inline(always)]
fn nearest_in_front(corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| greater(greater(p.x.abs(), p.y.abs()), p.z.abs()));
    1e-9 * greater(greater(a, b), c)
}

/// The texels whose centres may lie between two positions, as whole numbers: first, and one
/// after the last, which is not after the first if there are none.
#[inline(always)]
fn texels_between(low: f64, high: f64, resolution: f64) -> [f64; 2] {
    let first = greater((low - 0.5 - 1e-6).ceil(), 0.0);
    let end = lesser((high - 0.5 + 1e-6).floor() + 1.0, resolution);
    [first, end]
}

#[cfg(test)]
mod tests {
    use reference::random::Random;

    use super::*;

    const PARALLEL: Face = Face {
        origin: Vec3::ZERO,
        right: Vec3::X,
        up: Vec3::Y,
        forward: Vec3::NEG_Z,
        rays: Rays::Parallel {
            half_width: 2.0,
            half_height: 1.0,
        },
    };

    fn central(tan: f32) -> Face {
        Face {
            rays: Rays::Central { tan },
            ..PARALLEL
        }
    }

    fn texels(face: &Face, triangle: &[Vec3; 3], resolution: u32) -> Vec<(u32, u32, f32)> {
        let mut found = Vec::new();
        if let Some(footprint) = Footprint::new(face, triangle, resolution) {
            footprint.for_each(0, resolution, |x, y, depth| found.push((x, y, depth)));
        }
        found
    }

    /// Whether a line meets a triangle and at which distance, by Cramer's rule.
    fn meets(origin: DVec3, direction: DVec3, triangle: &[Vec3; 3]) -> Option<f64> {
        let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
        let m = glam::DMat3::from_cols(b - a, c - a, -direction);
        if m.determinant().abs() < 1e-12 {
            return None;
        }
        let s = m.inverse() * (origin - a);
        (s.x >= 0.0 && s.y >= 0.0 && s.x + s.y <= 1.0 && s.z > 0.0).then_some(s.z)
    }

    #[test]
    fn coverage_and_depth_are_those_of_a_ray_per_texel() {
        let mut random = Random::new(3);
        let mut next = || random.unit_f64() - 0.5;
        let mut covered = 0;
        for round in 0..400 {
            let mut corner = || {
                Vec3::new(
                    6.0 * next() as f32,
                    6.0 * next() as f32,
                    6.0 * next() as f32,
                )
            };
            // Many of these reach behind the light.
            let triangle = [corner(), corner(), corner()];
            let face = if round % 2 == 0 {
                PARALLEL
            } else {
                central(0.8)
            };
            let n = 16;
            let found = texels(&face, &triangle, n);
            for y in 0..n {
                for x in 0..n {
                    let u = (f64::from(x) + 0.5) / 8.0 - 1.0;
                    let v = 1.0 - (f64::from(y) + 0.5) / 8.0;
                    let expected = if round % 2 == 0 {
                        let start = DVec3::new(2.0 * u, v, 100.0);
                        meets(start, DVec3::NEG_Z, &triangle).map(|t| t - 100.0)
                    } else {
                        let tan = f64::from(0.8_f32);
                        let ray = DVec3::new(tan * u, tan * v, -1.0);
                        meets(DVec3::ZERO, ray, &triangle).map(|t| t * ray.length())
                    };
                    let depth = found
                        .iter()
                        .find(|texel| (texel.0, texel.1) == (x, y))
                        .map(|texel| texel.2);
                    match (expected, depth) {
                        (None, None) => {}
                        (Some(e), Some(d)) => {
                            covered += 1;
                            let error = (f64::from(d) - e).abs();
                            assert!(error < 1e-5 * (1.0 + e.abs()), "{round} {e} {d}");
                        }
                        (e, d) => panic!("round {round}, texel {x} {y}: {e:?} but {d:?}"),
                    }
                }
            }
        }
        assert!(covered > 1000, "{covered}");
    }

    #[test]
    fn front_faces_are_counter_clockwise_towards_the_light() {
        let facing = [
            Vec3::new(-1.0, -1.0, -3.0),
            Vec3::new(1.0, -1.0, -3.0),
            Vec3::new(0.0, 1.0, -3.0),
        ];
        let mut averted = facing;
        averted.swap(0, 1);
        for face in [PARALLEL, central(1.0)] {
            let front = |t| Footprint::new(&face, t, 64).map(|f| f.is_front());
            assert_eq!(front(&facing), Some(true));
            assert_eq!(front(&averted), Some(false));
        }
    }

    /// Edges run through the centres of texels.
    #[test]
    fn squares_of_two_triangles_cover_every_texel_once() {
        let square = |z: f32, stretch: f32| {
            let corner = |x: f32, y: f32| Vec3::new(x, stretch * y, z);
            let [a, b, c, d] = [
                corner(-1.5, -0.75),
                corner(0.5, -0.75),
                corner(0.5, 0.25),
                corner(-1.5, 0.25),
            ];
            [[a, b, c], [a, c, d], [c, b, a], [d, a, c]]
        };
        // The diagonal rises by a texel per texel.
        for (face, z, stretch) in [(PARALLEL, -3.0, 1.0), (central(1.0), -2.0, 2.0)] {
            let mut on_an_edge = 0;
            for [first, second] in [[0, 1], [0, 3], [2, 1], [2, 3]] {
                let mut count = [0; 16 * 16];
                let mut twice = [0; 16 * 16];
                for triangle in [first, second].map(|index| square(z, stretch)[index]) {
                    let footprint = Footprint::new(&face, &triangle, 16).unwrap();
                    for (columns, rows) in [(0..7, 0..16), (7..16, 0..3), (7..16, 3..16)] {
                        let put = |x, y, _| count[(y * 16 + x) as usize] += 1;
                        footprint.for_each_once(columns, rows, put);
                    }
                    footprint.for_each(0, 16, |x, y, _| twice[(y * 16 + x) as usize] += 1);
                }
                for (once, twice) in count.into_iter().zip(twice) {
                    assert!(once <= 1 && (once == 1 || twice == 0 || twice == 1));
                    on_an_edge += u32::from(twice == 2);
                    assert!(twice < 2 || once == 1);
                }
            }
            assert!(on_an_edge > 4, "{on_an_edge}");
        }
    }

    #[test]
    fn a_fan_covers_every_texel_without_gaps() {
        let ring = |i: u32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 7.0;
            Vec3::new(20.0 * angle.cos() as f32, 20.0 * angle.sin() as f32, -3.3)
        };
        for face in [PARALLEL, central(1.0)] {
            let mut count = vec![0; 50 * 50];
            for i in 0..7 {
                let triangle = [Vec3::new(0.01, 0.02, -3.0), ring(i), ring(i + 1)];
                for (x, y, _) in texels(&face, &triangle, 50) {
                    count[(y * 50 + x) as usize] += 1;
                }
            }
            assert!(count.iter().all(|&n| n >= 1));
        }
    }
}

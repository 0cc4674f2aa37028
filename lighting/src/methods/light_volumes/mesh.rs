//! The mesh of a light volume: vertices, patches, and the quadtree of its cells.

use crate::scene::raster::{Face, Rays};
use crate::shadow_map::EMPTY;

/// The smallest and the largest height of a square of cells' vertices. The largest comes first
/// if the square is one patch, or part of one.
pub(super) type Node = [f32; 2];

/// Base-2 logarithm of the largest number of cells along a side of a patch.
pub(super) const LARGEST_PATCH: u32 = 6;

/// The largest number of levels in a quadtree. 65536 texels need 17; a uniform has room for a
/// multiple of four.
pub(super) const MOST_LEVELS: usize = 20;

/// The smallest distance from a point light, m, which keeps heights finite.
pub(super) const NEAREST: f32 = 1e-15;

/// Neighbours whose depths differ by more than this many texel widths are not of one surface:
/// its angle to the picture would exceed 86°.
pub(super) const STEEP: f32 = 16.0;

/// The layout of a quadtree, and the tolerance within which cells count as flat.
///
/// A picture of n texels per side has n + 1 cells per side; those on the border share their
/// outer corners with the inner ones. A node of level l, from 1 on, is a square of 2ˡ cells per
/// side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Layout {
    resolution: u32,
    faces: u32,
    /// For each level, the index of its first node.
    pub(super) first: [u32; MOST_LEVELS],
    nodes: u64,
    /// The width of a texel as a difference of heights: at the height 0, and its increase per
    /// unit of height.
    pub(super) width: [f32; 2],
    /// The largest distance between a patch and its vertices, in texel widths.
    pub(super) tolerance: f32,
}

impl Layout {
    pub(super) fn new(faces: &[Face], resolution: u32, tolerance: f32) -> Self {
        let texels = resolution as f32;
        let width = match faces[0].rays {
            Rays::Parallel {
                half_width,
                half_height,
            } => [2.0 * half_width.min(half_height) / texels, 0.0],
            // −1/z changes by width/z² = 2 tan/n × 1/z.
            Rays::Central { tan } => [0.0, 2.0 * tan / texels],
        };
        let mut layout = Self {
            resolution,
            faces: faces.len() as u32,
            first: [0; MOST_LEVELS],
            nodes: 0,
            width,
            // NaN counts as 0.
            tolerance: tolerance.max(0.0),
        };
        for level in 1..=layout.levels() {
            // A map of 4 GiB has fewer than 2³² nodes.
            layout.first[level as usize] = layout.nodes as u32;
            layout.nodes += u64::from(layout.faces) * u64::from(layout.side(level)).pow(2);
        }
        layout
    }

    pub(super) fn resolution(&self) -> u32 {
        self.resolution
    }

    pub(super) fn pictures(&self) -> u32 {
        self.faces
    }

    /// The level of the node that contains all cells of a picture.
    pub(super) fn levels(&self) -> u32 {
        u32::BITS - self.resolution.leading_zeros()
    }

    /// Number of nodes along a side on a level.
    pub(super) fn side(&self, level: u32) -> u32 {
        (self.resolution >> level) + 1
    }

    pub(super) fn vertices(&self) -> usize {
        self.faces as usize * (self.resolution as usize).pow(2)
    }

    pub(super) fn nodes(&self) -> usize {
        self.nodes as usize
    }

    /// The nodes of a level, and their number in a row.
    pub(super) fn level(&self, level: u32) -> (std::ops::Range<usize>, usize) {
        let side = self.side(level) as usize;
        let first = self.first[level as usize] as usize;
        (first..first + self.faces as usize * side * side, side)
    }

    /// The width of a texel at the distance of a vertex, as a difference of heights.
    pub(super) fn width_at(&self, height: f32) -> f64 {
        f64::from(self.width[0] + self.width[1] * height.abs())
    }
}

/// The mesh of a light in the memory of the host.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mesh<'a> {
    pub(super) layout: &'a Layout,
    pub(super) heights: &'a [f32],
    pub(super) nodes: &'a [Node],
}

/// A square of cells with a single surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    /// Its corner at the first cell, and the number of cells along a side.
    pub(super) origin: [f64; 2],
    pub(super) size: f64,
    /// Heights of the corners: (0, 0), (1, 0), (0, 1), (1, 1).
    pub(super) corners: [f32; 4],
    pub(super) kind: Kind,
}

/// The shape of a patch's surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Empty: the light sees nothing.
    Nothing,
    /// Two triangles with the edge from (0, 0) to (1, 1).
    Falling,
    /// Two triangles with the edge from (1, 0) to (0, 1).
    Rising,
    /// A silhouette: each quarter has the height of its corner.
    Wall,
}

/// Height = base + x · u + y · v over the square, u and v from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub(super) base: f64,
    pub(super) x: f64,
    pub(super) y: f64,
}

impl Plane {
    /// The same height everywhere.
    pub(super) fn level(height: f32) -> Self {
        Self {
            base: f64::from(height),
            x: 0.0,
            y: 0.0,
        }
    }

    fn at(&self, u: f64, v: f64) -> f64 {
        self.base + self.x * u + self.y * v
    }
}

/// The two triangles whose common edge joins the corners with more similar heights.
fn triangles(corners: [f32; 4]) -> Kind {
    match (corners[0] - corners[3]).abs() <= (corners[1] - corners[2]).abs() {
        true => Kind::Falling,
        false => Kind::Rising,
    }
}

impl Patch {
    /// The plane of the surface at a point of the square.
    pub(super) fn plane(&self, u: f64, v: f64) -> Plane {
        plane(self.kind, self.corners, u, v)
    }
}

fn plane(kind: Kind, corners: [f32; 4], u: f64, v: f64) -> Plane {
    let [a, b, c, d] = corners.map(f64::from);
    let new = |base, x, y| Plane { base, x, y };
    match kind {
        Kind::Nothing => Plane::level(EMPTY),
        Kind::Falling if u >= v => new(a, b - a, d - b),
        Kind::Falling => new(a, d - c, c - a),
        Kind::Rising if u + v <= 1.0 => new(a, b - a, c - a),
        Kind::Rising => new(b + c - d, d - c, d - b),
        Kind::Wall => {
            let corner = usize::from(u >= 0.5) + 2 * usize::from(v >= 0.5);
            Plane::level(corners[corner])
        }
    }
}

impl Mesh<'_> {
    /// The height of the vertex in front of a cell, or at the border that of its neighbour.
    #[inline]
    fn height(&self, face: usize, x: i64, y: i64) -> f32 {
        let n = i64::from(self.layout.resolution);
        let [x, y] = [x, y].map(|at| (at - 1).clamp(0, n - 1));
        self.heights[((face as i64 * n + y) * n + x) as usize]
    }

    #[inline]
    pub(super) fn node(&self, face: usize, level: u32, x: i64, y: i64) -> Node {
        let side = i64::from(self.layout.side(level));
        let first = i64::from(self.layout.first[level as usize]);
        self.nodes[(first + (face as i64 * side + y) * side + x) as usize]
    }

    fn corners(&self, face: usize, x: i64, y: i64, size: i64) -> [f32; 4] {
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| self.height(face, x + i * size, y + j * size))
    }

    /// The patch that is a square of cells, or a single cell.
    #[inline]
    pub(super) fn patch(&self, face: usize, level: u32, [x, y]: [i64; 2]) -> Patch {
        let size = 1 << level;
        let corners = self.corners(face, x, y, size);
        let least = corners.into_iter().fold(EMPTY, f32::min);
        let greatest = corners.into_iter().fold(f32::MIN, f32::max);
        let steep = f64::from(STEEP) * self.layout.width_at(greatest);
        let kind = if least == EMPTY {
            Kind::Nothing
        } else if level == 0 && f64::from(greatest) - f64::from(least) > steep || greatest == EMPTY
        {
            Kind::Wall
        } else {
            triangles(corners)
        };
        Patch {
            origin: [x as f64, y as f64],
            size: size as f64,
            corners,
            kind,
        }
    }

    /// The bounds of the vertices of four cells.
    pub(super) fn bounds_of_cells(&self, face: usize, x: i64, y: i64) -> [f32; 2] {
        let mut bounds = [EMPTY, f32::MIN];
        for (i, j) in (0..9).map(|k| (k % 3, k / 3)) {
            let height = self.height(face, 2 * x + i, 2 * y + j);
            bounds = [bounds[0].min(height), bounds[1].max(height)];
        }
        bounds
    }

    /// Whether all vertices of a square of cells are within the tolerance of two triangles, and
    /// none is empty.
    pub(super) fn is_flat(&self, face: usize, level: u32, x: i64, y: i64) -> bool {
        let size = 1_i64 << level;
        let (x, y) = (x << level, y << level);
        let corners = self.corners(face, x, y, size);
        let kind = triangles(corners);
        let tolerance = f64::from(self.layout.tolerance);
        (0..=size).all(|j| {
            (0..=size).all(|i| {
                let [u, v] = [i, j].map(|at| at as f64 / size as f64);
                let height = self.height(face, x + i, y + j);
                let patch = plane(kind, corners, u, v).at(u, v);
                (patch - f64::from(height)).abs() <= tolerance * self.layout.width_at(height)
            })
        })
    }

    pub(super) fn patches(&self) -> usize {
        let layout = self.layout;
        let mut patches = 0;
        let is_flat = |face: usize, level: u32, x: i64, y: i64| {
            level <= layout.levels() && {
                let [first, second] = self.node(face, level, x >> level, y >> level);
                first >= second
            }
        };
        for face in 0..layout.pictures() as usize {
            for level in 0..=layout.levels() {
                let side = i64::from(layout.side(level));
                for (y, x) in (0..side * side).map(|i| (i / side, i % side)) {
                    let (x, y) = (x << level, y << level);
                    let is_one = level == 0 || is_flat(face, level, x, y);
                    patches += usize::from(is_one && !is_flat(face, level + 1, x, y));
                }
            }
        }
        patches
    }
}

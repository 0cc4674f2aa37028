//! Epipolar lines in the pictures of a light, and the selection of those that a view needs.

use glam::{DVec3, Vec3};

use super::walk::{Walk, turned};
use crate::scene::raster::Face;
use crate::scene::{Emitter, Medium};
use crate::shadow_map::line::{Line, Projection};
use crate::{LightPath, Ray};

/// The logarithm of the number of cells per leaf of a tree.
pub(super) const LEAF: u32 = 3;

/// The largest number of fans of a light: two kinds of cells and two sides for six pictures.
pub(super) const MOST_FANS: usize = 24;

/// Rays closer to the direction of the light than this are walked; it is the sine of an angle
/// over the number of texels. Shaders compute lines in f32: a few roundings of 2⁻²⁴ over this
/// are the margin of a slice.
const LEAST_SINE: f64 = 4e-6;

/// Number of rays of a frame that are used to find the lines it needs.
const SAMPLES: usize = 4096;

/// The largest number of slices of all fans together, per pixel of a side of a square picture.
const LINES_PER_SIDE: f64 = 4.0;

/// The largest number of nodes of a light in a view: 128 MiB, WebGPU's limit for a binding.
const MOST_NODES: f64 = (1 << 24) as f64;

/// The half lines from the image of the eye to one side of a picture that run more along than
/// across the way there.
///
/// They are divided into slices by their intersection with this side: a texel apart there,
/// unless this is finer than the rays of a picture need, and closer before. Cells are counted
/// from that side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fan {
    /// Whether the side is at the last cell of the picture.
    pub(crate) is_last: bool,
    /// The position at which the first slice meets the side, and the number of slices per unit
    /// there.
    pub(crate) first: f64,
    pub(crate) density: f64,
    pub(crate) slices: u32,
    /// The first cell from the side that is in the tree, and the base-2 logarithm of the number
    /// of leaves.
    pub(crate) first_cell: u32,
    pub(crate) height: u32,
    /// Index of the first node.
    pub(crate) nodes: u32,
    /// The image of the eye: coordinates along the cells and across, and w.
    pub(crate) eye: DVec3,
}

impl Fan {
    /// Number of nodes of a slice: a heap, whose root is node 1.
    pub(crate) fn nodes_per_slice(&self) -> u32 {
        2 << self.height
    }

    /// The index of a cell counted from the side, or the cell with that index; the function is
    /// its own inverse.
    pub(super) fn seen_from_side(&self, cell: i64, resolution: u32) -> i64 {
        seen_from_side(self.is_last, cell, resolution)
    }

    /// The first and the last cell of a leaf, in the order of the picture; `None` beyond the
    /// picture.
    pub(super) fn cells_of_leaf(&self, leaf: u32, resolution: u32) -> Option<[i64; 2]> {
        let first = i64::from(self.first_cell + (leaf << LEAF));
        let last = (first + (1 << LEAF)).min(i64::from(resolution)) - 1;
        let cells = [first, last].map(|cell| self.seen_from_side(cell, resolution));
        (first <= last).then_some([cells[0].min(cells[1]), cells[0].max(cells[1])])
    }

    /// The two lines that bound a slice: across = base + slope × along, in texels, where along
    /// is from −1 to 1.
    pub(super) fn lines(&self, slice: u32, resolution: u32) -> [[f64; 2]; 2] {
        let side = if self.is_last { 1.0 } else { -1.0 };
        let half = 0.5 * f64::from(resolution);
        let eye = self.eye;
        let scale = half / (eye.x - side * eye.z);
        [slice, slice + 1].map(|line| {
            let meets = self.first + f64::from(line) / self.density;
            let base = half + (meets * eye.x - eye.y * side) * scale;
            [base, (eye.y - meets * eye.z) * scale]
        })
    }

    /// The coordinate of the border in front of a cell; lines begin at the eye.
    pub(super) fn border(&self, cell: i64, resolution: u32) -> f64 {
        let x = 2.0 * cell as f64 / f64::from(resolution) - 1.0;
        if self.eye.z == 0.0 {
            return x;
        }
        let begin = self.eye.x / self.eye.z;
        if self.is_last {
            x.max(begin)
        } else {
            x.min(begin)
        }
    }
}

/// The index of a cell counted from the first or the last side, or the cell with that index.
fn seen_from_side(is_last: bool, cell: i64, resolution: u32) -> i64 {
    match is_last {
        true => i64::from(resolution) - 1 - cell,
        false => cell,
    }
}

/// The epipolar lines of a light's pictures that a view needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Fans {
    /// The origin of all rays that are looked up.
    pub(crate) eye: Vec3,
    pub(crate) resolution: u32,
    /// The fans, by picture, kind of cells and side.
    pub(crate) fans: [Option<Fan>; MOST_FANS],
    /// Number of nodes of all fans.
    pub(crate) nodes: usize,
}

/// The place of a part of a ray on a fan.
#[derive(Debug, Clone, Copy)]
struct Place {
    fan: usize,
    /// The position at which its line meets the side.
    meets: f64,
    /// The image of the eye.
    eye: DVec3,
}

/// What the rays of a view need of a fan.
#[derive(Debug, Clone, Copy)]
struct Need {
    eye: DVec3,
    meets: [f64; 2],
    cells: [i64; 2],
}

/// `eye` and `slope` are the images of the eye and of the ray's direction.
fn place(walk: &Walk, face: usize, eye: DVec3, slope: DVec3, resolution: u32) -> Option<Place> {
    let [eye, slope] = [eye, slope].map(|v| turned(walk.is_row_major(), v));
    let normal = eye.cross(slope);
    let scale = eye.abs().max_element() * slope.abs().max_element();
    if !(normal.y.abs() > LEAST_SINE * f64::from(resolution) * scale) {
        return None;
    }
    let is_last = match eye.z {
        0.0 => true,
        w => (walk.middle() * w - eye.x) * w.signum() > 0.0,
    };
    let side = if is_last { 1.0 } else { -1.0 };
    let fan = 4 * face + 2 * usize::from(walk.is_row_major()) + usize::from(is_last);
    let meets = -(normal.x * side + normal.z) / normal.y;
    Some(Place { fan, meets, eye })
}

impl Fans {
    /// The fans that those of `rays` need that start at the origin of the first ray.
    pub(super) fn of_view(
        faces: &[Face],
        resolution: u32,
        rays: &[Ray],
        emitter: &Emitter,
        medium: &Medium,
    ) -> Self {
        let eye = rays.first().map_or(Vec3::ZERO, Ray::origin);
        let projections: Vec<Projection> = faces.iter().map(Projection::new).collect();
        let mut needs: [Option<Need>; MOST_FANS] = [None; MOST_FANS];
        // An odd stride does not stay within a few columns of a picture.
        let stride = (rays.len() / SAMPLES) | 1;
        for ray in rays.iter().step_by(stride) {
            let Some(path) = LightPath::new(ray, emitter, medium) else {
                continue;
            };
            let line = Line::new(ray, &faces[0]);
            let span = path.span();
            let span = [line.position(span.start), line.position(span.end)];
            line.for_each_picture(&projections, span, |face, a, b| {
                let Some(face) = face else { return };
                let pictures = line.pictures(&projections[face]);
                let walk = Walk::new(&line, pictures, [a, b], resolution);
                let eye = eye_picture(&projections[face], eye, &faces[0]);
                let Some(place) = place(&walk, face, eye, pictures[1], resolution) else {
                    return;
                };
                let is_last = place.fan % 2 == 1;
                let cells = (walk.cells()).map(|cell| seen_from_side(is_last, cell, resolution));
                let cells = [cells[0].min(cells[1]), cells[0].max(cells[1])];
                let need = needs[place.fan].get_or_insert(Need {
                    eye: place.eye,
                    meets: [place.meets; 2],
                    cells,
                });
                need.meets = [
                    need.meets[0].min(place.meets),
                    need.meets[1].max(place.meets),
                ];
                need.cells = [need.cells[0].min(cells[0]), need.cells[1].max(cells[1])];
            });
        }
        // The rays of a picture lie on about as many lines as its border has pixels.
        let lines = LINES_PER_SIDE * (rays.len() as f64).sqrt();
        Self::new(eye, resolution, &needs, (stride > 1, lines))
    }

    fn new(
        eye: Vec3,
        resolution: u32,
        needs: &[Option<Need>; MOST_FANS],
        (is_sampled, lines): (bool, f64),
    ) -> Self {
        let n = f64::from(resolution);
        // An allowance for the rays between those that were looked at.
        let more = if is_sampled { 1.0 / 16.0 } else { 0.0 };
        let fan = |index: usize, coarseness: f64| {
            let need = needs[index]?;
            let [low, high] = need.meets;
            let texel = 2.0 / n;
            let beside = more * (high - low) + texel;
            let [low, high] = [
                (low - beside).max(-3.0 - texel),
                (high + beside).min(3.0 + texel),
            ];
            let density = 0.5 * n / coarseness;
            let [near, far] = need.cells;
            let beside = (more * (far - near) as f64) as i64;
            let near = (near - beside).max(0) >> LEAF << LEAF;
            let far = (far + beside).min(i64::from(resolution) - 1);
            let leaves = ((far - near) >> LEAF) as u32 + 1;
            Some(Fan {
                is_last: index % 2 == 1,
                first: low,
                density,
                slices: ((high - low) * density).ceil().max(1.0) as u32,
                first_cell: near as u32,
                height: leaves.next_power_of_two().ilog2(),
                nodes: 0,
                eye: need.eye,
            })
        };
        let of_all = |coarseness: f64, count: &dyn Fn(&Fan) -> f64| -> f64 {
            let fans = (0..MOST_FANS).filter_map(|index| fan(index, coarseness));
            fans.map(|fan| count(&fan)).sum()
        };
        let slices = of_all(1.0, &|fan| f64::from(fan.slices));
        let nodes_at = |coarseness: f64| {
            of_all(coarseness, &|fan| {
                f64::from(fan.slices) * f64::from(fan.nodes_per_slice())
            })
        };
        let mut coarseness = (slices / lines).max(1.0);
        while nodes_at(coarseness) > MOST_NODES {
            coarseness *= 2.0;
        }
        let mut nodes = 0;
        let fans = std::array::from_fn(|index| {
            let mut fan = fan(index, coarseness)?;
            fan.nodes = nodes;
            nodes += fan.slices * fan.nodes_per_slice();
            Some(fan)
        });
        Self {
            eye,
            resolution,
            fans,
            nodes: nodes as usize,
        }
    }

    /// The fan and the slice of a part of a ray from the eye, if there is one.
    pub(super) fn find(
        &self,
        walk: &Walk,
        face: usize,
        eye: DVec3,
        slope: DVec3,
    ) -> Option<(&Fan, u32)> {
        let place = place(walk, face, eye, slope, self.resolution)?;
        let fan = self.fans[place.fan].as_ref()?;
        let slice = (place.meets - fan.first) * fan.density;
        if !(slice >= 0.0 && slice < f64::from(fan.slices)) {
            return None;
        }
        let reach = i64::from(1_u32 << (fan.height + LEAF));
        let inside = walk.cells().into_iter().all(|cell| {
            let cell = fan.seen_from_side(cell, self.resolution) - i64::from(fan.first_cell);
            (0..reach).contains(&cell)
        });
        inside.then_some((fan, slice as u32))
    }
}

/// The image of the eye.
pub(super) fn eye_picture(projection: &Projection, eye: Vec3, face: &Face) -> DVec3 {
    projection.of_point((eye - face.origin).as_dvec3())
}

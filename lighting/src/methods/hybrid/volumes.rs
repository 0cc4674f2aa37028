//! Shadow volumes of what stands for the casters: one of each cell of a light's
//! pictures.

use glam::{DVec3, Vec3};
use gpu_backend::{Backend, Cpu, Error, Host, Memory};

use super::picture::{Picture, Square};
use crate::scene::{Caster, Emitter, Geometry};
use crate::shadow_map::faces;

/// Texels along a side of the finest cells, at least.
const LEAST_CELL: u32 = 8;

/// Finest cells along a side of a picture, at most.
const MOST_CELLS: u32 = 256;

/// The depth of cells without a caster, m: farther than anything, and its square is a
/// number.
const NOTHING: f32 = 1e18;

/// What the roundings of a depth add up to, relative to it, and what those of a
/// position do, relative to the largest coordinate: a few times 2⁻²⁴ each.
const DEPTH: f64 = 4e-6;
const POSITION: f64 = 1e-6;

/// Triangles that are added to a grid of their own.
const CHUNK: usize = 1 << 14;

/// Grids that are made at the same time, at most: of a cube 1.5 MiB each.
const MOST_CHUNKS: usize = 64;

/// Shadow volumes that hold every shadow of a light.
///
/// Each picture of the light is divided into square cells, and a cell has the least
/// distance at which there is any caster in it. What lies farther away in the same cell
/// is its shadow volume: a pyramid without a top, or a prism in parallel light. The
/// cells of all levels of a pyramid have one, down to eight texels of the shadow map.
///
/// A shadow, whether the map's or an exact one, is never outside of these volumes: cells
/// are those that a triangle touches or comes within a texel of, whatever the samples of
/// the map say, and depths are bounds. Masked triangles count as solid.
#[derive(Debug)]
pub struct ShadowVolumes<M: Memory> {
    origin: Vec3,
    pictures: Vec<Picture>,
    /// Texels per side of the map.
    resolution: u32,
    /// Texels per side of a finest cell.
    cell: u32,
    /// Finest cells per side, a power of two.
    side: u32,
    /// Depths, the finest level first; each picture by picture, row by row.
    near: M::Buffer<f32>,
}

impl<M: Memory> ShadowVolumes<M> {
    /// Of all pictures.
    pub(super) fn origin(&self) -> Vec3 {
        self.origin
    }

    pub(super) fn pictures(&self) -> &[Picture] {
        &self.pictures
    }

    /// Texels per side and pictures of the shadow map that they go with.
    pub(super) fn size(&self) -> (u32, usize) {
        (self.resolution, self.pictures.len())
    }

    /// Texels per side of that.
    pub fn resolution(&self) -> u32 {
        self.resolution
    }

    /// Texels per side of a cell of the finest level.
    pub fn cell(&self) -> u32 {
        self.cell
    }

    /// Cells per side of the finest level.
    pub(super) fn side(&self) -> u32 {
        self.side
    }

    /// The coarsest level, a single cell for each picture.
    pub(super) fn top(&self) -> u32 {
        self.side.ilog2()
    }

    /// Least distances, in the memory of the backend.
    pub fn near(&self) -> &M::Buffer<f32> {
        &self.near
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        4 * cells(self.pictures.len(), self.side, self.top() + 1) as u64
    }
}

/// Cells of so many levels.
fn cells(pictures: usize, side: u32, levels: u32) -> usize {
    let all = (0..levels).map(|level| ((side >> level) as usize).pow(2));
    pictures * all.sum::<usize>()
}

impl ShadowVolumes<Host> {
    /// Those of a light, for a shadow map of so many texels per side.
    ///
    /// Takes time in proportion to the number of triangles and of the cells in the boxes
    /// around them, and while it is at it at most 96 MiB.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory: 2 MiB for a cube.
    pub fn new(
        cpu: &Cpu,
        geometry: &Geometry,
        emitter: &Emitter,
        resolution: u32,
    ) -> Result<Self, Error> {
        let faces = faces(geometry.bounds(), emitter);
        let cell = resolution.div_ceil(MOST_CELLS).max(LEAST_CELL);
        let cell = cell.next_power_of_two();
        let side = resolution.div_ceil(cell).next_power_of_two();
        let pictures: Vec<Picture> = faces.iter().map(|f| Picture::new(f, resolution)).collect();
        let finest = faces.len() * (side as usize).pow(2);
        let grid = Grid {
            origin: faces[0].origin,
            pictures: &pictures,
            cell: f64::from(cell),
            side,
        };
        let triangles = geometry.triangles().len();
        // A grid for each, of which the least is the same however triangles are divided.
        let chunk = CHUNK.max(triangles.div_ceil(MOST_CHUNKS));
        let parts = cpu.map(triangles.div_ceil(chunk), |number| {
            grid.of_triangles(geometry, number * chunk, chunk)
        });
        let scale = [
            geometry.bounds().min(),
            geometry.bounds().max(),
            grid.origin,
        ];
        let scale = scale.map(|v| v.abs().max_element()).into_iter();
        let margin = POSITION * f64::from(scale.fold(0.0, f32::max));
        let mut near = cpu.zeros::<f32>(cells(faces.len(), side, side.ilog2() + 1))?;
        for (index, depth) in near[..finest].iter_mut().enumerate() {
            let least = parts.iter().map(|part| part[index]);
            let least = f64::from(least.fold(NOTHING, f32::min));
            *depth = (least - DEPTH * least.abs() - margin) as f32;
        }
        let mut from = 0;
        for level in 1..=side.ilog2() {
            let width = (side >> level) as usize;
            let (fine, coarse) = near[from..].split_at_mut(faces.len() * 4 * width * width);
            for (index, depth) in coarse[..faces.len() * width * width].iter_mut().enumerate() {
                // Rows of all pictures are one after the other.
                let (row, column) = (index / width, index % width);
                let first = 2 * row * 2 * width + 2 * column;
                let four = [0, 1, 2 * width, 2 * width + 1].map(|cell| fine[first + cell]);
                *depth = four.into_iter().fold(NOTHING, f32::min);
            }
            from += fine.len();
        }
        Ok(Self {
            origin: grid.origin,
            pictures,
            resolution,
            cell,
            side,
            near,
        })
    }

    /// The same on another backend.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit there.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<ShadowVolumes<B::Memory>, Error> {
        Ok(ShadowVolumes {
            origin: self.origin,
            pictures: self.pictures.clone(),
            resolution: self.resolution,
            cell: self.cell,
            side: self.side,
            near: backend.upload(&self.near)?,
        })
    }

    /// The cell of a picture at a level.
    #[inline]
    pub(super) fn near_of(&self, picture: usize, level: u32, [column, row]: [u32; 2]) -> f32 {
        let width = self.side >> level;
        let before = 4 * (self.side * self.side - width * width) / 3;
        let all = before as usize * self.pictures.len();
        let rows = picture * width as usize + row as usize;
        self.near[all + rows * width as usize + column as usize]
    }
}

/// The finest cells of all pictures, in the making.
struct Grid<'a> {
    origin: Vec3,
    pictures: &'a [Picture],
    cell: f64,
    side: u32,
}

impl Grid<'_> {
    /// The least depths of some triangles.
    fn of_triangles(&self, geometry: &Geometry, first: usize, count: usize) -> Vec<f32> {
        let per_picture = (self.side as usize).pow(2);
        let mut near = vec![NOTHING; self.pictures.len() * per_picture];
        for (index, triangle) in (first..).zip(&geometry.triangles()[first..]).take(count) {
            // What a shadow map is rendered from.
            if !matches!(geometry.caster(index), Caster::Solid | Caster::Masked(_)) {
                continue;
            }
            let corners = triangle.map(|corner| (corner - self.origin).as_dvec3());
            for (picture, near) in self.pictures.iter().zip(near.chunks_exact_mut(per_picture)) {
                self.add(picture, &corners, near);
            }
        }
        near
    }

    fn add(&self, picture: &Picture, corners: &[DVec3; 3], near: &mut [f32]) {
        let Some(all) = picture.bounds(corners) else {
            return;
        };
        let border = picture.margin();
        let last = f64::from(self.side - 1);
        let cell = |texel: f64| (texel / self.cell).floor();
        let Square { low, high } = all.wider(border);
        if high.min_element() < 0.0 || low.max_element() >= self.cell * (last + 1.0) {
            return;
        }
        // Conversions of what is clamped to the cells there are.
        let [from, to] = [low, high].map(|at| [at.x, at.y].map(|t| cell(t).clamp(0.0, last)));
        let [from, to] = [from, to].map(|at| at.map(|t| t as usize));
        let is_small = to[0] - from[0] <= 1 && to[1] - from[1] <= 1;
        let side = self.side as usize;
        let cells = |row: usize| row * side + from[0]..=row * side + to[0];
        if is_small {
            let depth = picture.least_depth(corners, all);
            for row in from[1]..=to[1] {
                for cell in &mut near[cells(row)] {
                    *cell = cell.min(depth);
                }
            }
            return;
        }
        let Some(plane) = picture.plane(corners) else {
            return;
        };
        for row in from[1]..=to[1] {
            for (column, near) in (from[0]..).zip(&mut near[cells(row)]) {
                let square = Square::new([column, row], self.cell).wider(border);
                if let Some(depth) = plane.least_depth(picture, square) {
                    *near = near.min(depth);
                }
            }
        }
    }
}

//! Square cells of the pictures of a light, and a pyramid of larger ones.

use glam::Vec3;

use super::picture::Picture;
use crate::scene::raster::Face;

/// Texels along a side of the finest cells, at least.
const LEAST_CELL: u32 = 8;

/// Finest cells along a side of a picture, at most.
const MOST_CELLS: u32 = 256;

/// A depth that is farther than anything, m, and whose square is a number.
pub(super) const NOTHING: f32 = 1e18;

/// The largest rounding error of a depth, relative to it, and of a position, relative to its
/// largest coordinate: a few times 2⁻²⁴ each.
pub(super) const DEPTH: f64 = 4e-6;
pub(super) const POSITION: f64 = 1e-6;

/// Which cells there are. Their values are kept with the finest level first, each
/// picture by picture, row by row.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    /// Of all pictures.
    pub(super) origin: Vec3,
    pub(super) pictures: Vec<Picture>,
    /// The same as a shader has them.
    #[cfg(feature = "wgpu")]
    pub(super) faces: Vec<Face>,
    /// Texels per side of the map.
    pub(super) resolution: u32,
    /// Texels per side of a finest cell.
    pub(super) cell: u32,
    /// Finest cells per side, a power of two.
    pub(super) side: u32,
}

impl Cells {
    pub(super) fn new(faces: &[Face], resolution: u32) -> Self {
        let cell = resolution.div_ceil(MOST_CELLS).max(LEAST_CELL);
        let cell = cell.next_power_of_two();
        Self {
            origin: faces[0].origin,
            pictures: faces.iter().map(|f| Picture::new(f, resolution)).collect(),
            #[cfg(feature = "wgpu")]
            faces: faces.to_vec(),
            resolution,
            cell,
            side: resolution.div_ceil(cell).next_power_of_two(),
        }
    }

    /// Texels per side and pictures of the shadow map that they go with.
    pub(super) fn of_map(&self) -> (u32, usize) {
        (self.resolution, self.pictures.len())
    }

    /// The coarsest level, a single cell for each picture.
    pub(super) fn top(&self) -> u32 {
        self.side.ilog2()
    }

    /// Cells of all levels below one.
    pub(super) fn before(&self, level: u32) -> usize {
        let width = self.side >> level;
        4 * (self.side * self.side - width * width) as usize / 3 * self.pictures.len()
    }

    /// Cells of the finest level.
    pub(super) fn finest(&self) -> usize {
        self.before(1)
    }

    /// Cells of all levels.
    pub(super) fn len(&self) -> usize {
        self.before(self.top()) + self.pictures.len()
    }

    /// The cell of a picture at a level.
    #[inline]
    pub(super) fn index(&self, picture: usize, level: u32, [column, row]: [u32; 2]) -> usize {
        let width = (self.side >> level) as usize;
        self.before(level) + (picture * width + row as usize) * width + column as usize
    }

    /// Makes the coarser levels of what is there for the finest one.
    pub(super) fn fill(&self, values: &mut [f32], worse: fn(f32, f32) -> f32) {
        for level in 1..=self.top() {
            let width = (self.side >> level) as usize;
            let (fine, coarse) = values[self.before(level - 1)..]
                .split_at_mut(self.pictures.len() * 4 * width * width);
            let coarse = &mut coarse[..self.pictures.len() * width * width];
            for (index, value) in coarse.iter_mut().enumerate() {
                // The rows of all pictures lie one after the other, so that the pictures are
                // halved as if they were a single one.
                let (row, column) = (index / width, index % width);
                let first = 2 * row * 2 * width + 2 * column;
                let [a, b, c, d] = [0, 1, 2 * width, 2 * width + 1].map(|cell| fine[first + cell]);
                *value = worse(worse(a, b), worse(c, d));
            }
        }
    }
}

//! The least and the greatest depth of short rows and columns of a shadow map, from
//! which the trees of any view are made.

use gpu_backend::{Backend, Cpu, Error, Host, Memory};

use super::tree::{NONE, Node, joined};
use crate::shadow_map::ShadowMap;

/// The logarithm of the number of texels of a block.
pub(super) const BLOCK: u32 = 3;

/// Bounds of all blocks of eight texels of a shadow map: those along a row, and those
/// along a column. They depend on the map alone and serve the trees of every view.
#[derive(Debug)]
pub struct MapBlocks<M: Memory> {
    /// By picture, kind of cells (columns, then rows), block along the cells, texel
    /// across.
    pub(super) bounds: M::Buffer<Node>,
    pub(super) resolution: u32,
    pub(super) pictures: usize,
}

/// Makes the blocks of shadow maps.
pub trait BuildMapBlocks: Backend {
    /// The bounds of all blocks of a map.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory: half as much as the map.
    fn map_blocks(&self, map: &ShadowMap<Self::Memory>) -> Result<MapBlocks<Self::Memory>, Error>;
}

/// Blocks along a side.
pub(super) fn blocks_per_side(resolution: u32) -> u32 {
    resolution.div_ceil(1 << BLOCK)
}

impl<M: Memory> MapBlocks<M> {
    /// Blocks of a map of so many pictures.
    pub(super) fn len(resolution: u32, pictures: usize) -> usize {
        let side = resolution as usize;
        2 * pictures * blocks_per_side(resolution) as usize * side
    }

    /// Makes sure that they are those of a map of this size.
    pub(super) fn check(&self, map: &ShadowMap<M>) -> Result<(), Error> {
        let len = Self::len;
        let expected = len(map.resolution(), map.faces().len());
        let actual = len(self.resolution, self.pictures);
        if (map.resolution(), expected) == (self.resolution, actual) {
            return Ok(());
        }
        Err(Error::LengthMismatch {
            what: "the blocks of a shadow map",
            expected,
            actual,
        })
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        (size_of::<Node>() * Self::len(self.resolution, self.pictures)) as u64
    }
}

impl MapBlocks<Host> {
    /// The bounds of the texels `low` to `high` across the cells that a block along
    /// them has, of a fan's picture and kind of cells.
    #[inline]
    pub(super) fn bounds(&self, fan: usize, block: u32, low: usize, high: usize) -> Node {
        let side = self.resolution as usize;
        let per_kind = blocks_per_side(self.resolution) as usize * side;
        let first = (fan / 2) * per_kind + block as usize * side;
        let all = &self.bounds[first + low..=first + high];
        all.iter().copied().fold(NONE, joined)
    }
}

impl BuildMapBlocks for Cpu {
    fn map_blocks(&self, map: &ShadowMap<Host>) -> Result<MapBlocks<Host>, Error> {
        let (resolution, pictures) = (map.resolution(), map.faces().len());
        let side = resolution as usize;
        let mut bounds = self.zeros(MapBlocks::<Host>::len(resolution, pictures))?;
        let blocks = blocks_per_side(resolution) as usize;
        self.for_each_chunk(&mut bounds, side, |first, chunk| {
            let (kind, block) = (first / side / blocks, first / side % blocks);
            let texels = &map.depth()[kind / 2 * side * side..][..side * side];
            let cells = block << BLOCK..((block + 1) << BLOCK).min(side);
            chunk.fill(NONE);
            if kind % 2 == 0 {
                for (row, node) in texels.chunks_exact(side).zip(chunk) {
                    for depth in &row[cells.clone()] {
                        *node = joined(*node, [*depth; 2]);
                    }
                }
            } else {
                for row in texels[cells.start * side..cells.end * side].chunks_exact(side) {
                    for (node, depth) in chunk.iter_mut().zip(row) {
                        *node = joined(*node, [*depth; 2]);
                    }
                }
            }
        });
        Ok(MapBlocks {
            bounds,
            resolution,
            pictures,
        })
    }
}

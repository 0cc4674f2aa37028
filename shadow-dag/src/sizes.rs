//! Where the bytes are.

use crate::ShadowDag;
use crate::layout::Stored;

/// What shadows take in memory and in a file, in bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sizes {
    /// The head of the file.
    pub head: usize,
    /// 8×8 masks, 8 bytes each.
    pub masks: usize,
    /// The table of shapes of the packed form.
    pub shapes: usize,
    /// Nodes level by level, from 8×8×8 voxels to the whole grid.
    pub levels: Vec<LevelSize>,
    /// All of the file: the above and some bytes to fill up.
    pub file: usize,
    /// The grid in place of the coarsest levels, in memory only.
    pub top_grid: usize,
}

/// The nodes of one level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LevelSize {
    /// Voxels along each side of a node.
    pub side: u32,
    /// How many there are, no two of them equal.
    pub nodes: u32,
    /// What they take.
    pub bytes: usize,
}

impl<B: AsRef<[u8]>> ShadowDag<B> {
    /// What there is of each kind and level, and what it takes.
    pub fn sizes(&self) -> Sizes {
        let mut shapes = 0;
        let levels: Vec<(u32, usize)> = match &self.layout.stored {
            Stored::Plain(levels) => (levels.iter())
                .map(|level| (level.nodes, 4 * level.words as usize))
                .collect(),
            Stored::Packed {
                shapes: tables,
                levels,
            } => {
                shapes = tables.iter().map(|(_, count)| 4 * *count as usize).sum();
                (levels.iter())
                    .map(|level| (level.nodes(), level.end - level.start))
                    .collect()
            }
        };
        Sizes {
            head: self.layout.masks,
            masks: 8 * self.layout.mask_count as usize,
            shapes,
            levels: (levels.into_iter().zip(3..))
                .map(|((nodes, bytes), log2)| LevelSize {
                    side: 1 << log2,
                    nodes,
                    bytes,
                })
                .collect(),
            file: self.as_bytes().len(),
            top_grid: self.top.bytes(),
        }
    }
}

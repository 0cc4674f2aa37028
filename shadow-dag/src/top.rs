//! A grid of references in place of the coarsest levels.

use crate::layout::Layout;
use crate::nodes::Nodes;
use crate::pool::{Reference, is_mixed};

/// References to the nodes of one level, cell `(z · 2^log2 + y) · 2^log2 + x`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Top {
    /// Logarithm of the number of cells along each axis.
    pub(crate) log2: u32,
    /// The level of the nodes.
    pub(crate) level: usize,
    pub(crate) cells: Vec<Reference>,
}

/// 32³ references: 128 kB in place of six levels.
const MAX_LOG2: u32 = 5;

impl Top {
    /// The grid of one cell.
    pub(crate) fn root(layout: &Layout) -> Self {
        Self {
            log2: 0,
            level: layout.resolution.root_level(),
            cells: vec![layout.root],
        }
    }

    pub(crate) fn allowed(layout: &Layout, log2: u32) -> u32 {
        log2.min(MAX_LOG2)
            .min(layout.resolution.root_level() as u32)
    }

    /// The largest grid that takes no more than `bytes`.
    pub(crate) fn suitable(layout: &Layout, bytes: usize) -> u32 {
        let largest = Self::allowed(layout, MAX_LOG2);
        (1..=largest)
            .rev()
            .find(|log2| 4 << (3 * log2) <= bytes)
            .unwrap_or(0)
    }

    pub(crate) fn new<N: Nodes>(nodes: &N, layout: &Layout, log2: u32) -> Self {
        let mut top = Self::root(layout);
        for _ in 0..log2 {
            top = top.split(nodes);
        }
        top
    }

    fn split<N: Nodes>(&self, nodes: &N) -> Self {
        let log2 = self.log2 + 1;
        let mask = (1_u32 << log2) - 1;
        let cells = (0..1_u32 << (3 * log2)).map(|cell| {
            let (x, y, z) = (cell & mask, cell >> log2 & mask, cell >> (2 * log2));
            let parent = self.cell(x >> 1, y >> 1, z >> 1);
            if is_mixed(parent) {
                nodes.child(
                    nodes.node(self.level, parent),
                    (z & 1) << 2 | (y & 1) << 1 | x & 1,
                )
            } else {
                parent
            }
        });
        Self {
            log2,
            level: self.level - 1,
            cells: cells.collect(),
        }
    }

    #[inline]
    pub(crate) fn cell(&self, x: u32, y: u32, z: u32) -> Reference {
        self.cells[((z << self.log2 | y) << self.log2 | x) as usize]
    }

    /// Logarithm of the width of a cell in voxels.
    #[inline]
    pub(crate) fn shift(&self) -> u32 {
        self.level as u32 + 3
    }

    /// The reference to the cell in which a voxel is.
    #[inline]
    pub(crate) fn find(&self, x: u32, y: u32, z: u32) -> Reference {
        let shift = self.shift();
        self.cell(x >> shift, y >> shift, z >> shift)
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice())
    }
}

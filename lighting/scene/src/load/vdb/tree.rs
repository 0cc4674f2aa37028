//! The tree of a grid: a root of nodes of 4096³ voxels, below it nodes of 128³, and
//! leaves of 8³; tiles where all voxels of a node are one.

use std::collections::HashSet;

use super::StoredGrid;
use super::values::{Packing, is_on};
use crate::load::LoadError;
use crate::load::limits::Budget;
use crate::load::voxels::{Dense, Placement, VoxelGrid};
use crate::load::words::Words;

const WHAT: &str = "the nodes of an OpenVDB grid";

/// Voxels along a leaf.
const LEAF: i64 = 8;

/// Children along a node of each level, and voxels along a child.
const UPPER: (usize, i64) = (32, 128);
const LOWER: (usize, i64) = (16, LEAF);

/// A grid of floats.
#[derive(Debug)]
pub(super) struct Tree<'a> {
    placement: Placement,
    packing: Packing,
    background: f32,
    /// Of active voxels, least and greatest included.
    indices: Option<[[i64; 3]; 2]>,
    /// From the root's tiles on, and the numbers of these and of the root's nodes.
    topology: Words<'a>,
    counts: [u32; 2],
    /// The corners of all leaves, and their values in the same order.
    leaves: Vec<[i32; 3]>,
    values: Words<'a>,
}

/// A part of a tree.
#[derive(Debug)]
enum Part<'a> {
    /// Voxels of one value.
    Tile {
        corner: [i64; 3],
        size: i64,
        value: f32,
        is_active: bool,
    },
    /// A leaf, with the mask of its active voxels.
    Leaf { corner: [i64; 3], mask: &'a [u8] },
}

impl<'a> Tree<'a> {
    pub(super) fn new(grid: &StoredGrid<'a>, budget: &mut Budget) -> Result<Self, LoadError> {
        let mut words = Words::new(grid.nodes);
        let buffers = words.u32(WHAT)?;
        if buffers != 1 {
            let what = format!("an OpenVDB grid of {buffers} values per voxel");
            return Err(LoadError::Unsupported(what));
        }
        let background = f32::from_le_bytes(words.item(WHAT)?);
        let counts = [words.u32(WHAT)?, words.u32(WHAT)?];
        let [tiles, nodes] = counts.map(u64::from);
        let needed = 17 * tiles + 12 * nodes;
        if needed > words.available() as u64 {
            return Err(LoadError::truncated(WHAT, needed, words.available()));
        }
        budget.take(WHAT, tiles + nodes, 2 * size_of::<[i64; 3]>())?;
        let mut tree = Self {
            placement: grid.placement,
            packing: grid.packing,
            background,
            indices: None,
            topology: words.clone(),
            counts,
            leaves: Vec::new(),
            values: words,
        };
        let mut bounds: Option<[[i64; 3]; 2]> = None;
        let mut leaves = Vec::new();
        let mut meet = |low: [i64; 3], high: [i64; 3]| {
            let [least, greatest] = bounds.get_or_insert([low, high]);
            for axis in 0..3 {
                least[axis] = least[axis].min(low[axis]);
                greatest[axis] = greatest[axis].max(high[axis]);
            }
        };
        tree.values = tree.walk(|part| {
            match part {
                Part::Tile {
                    corner,
                    size,
                    is_active,
                    ..
                } => {
                    if is_active {
                        meet(corner, corner.map(|index| index + size - 1));
                    }
                }
                Part::Leaf { corner, mask } => {
                    budget.take(WHAT, 1, size_of::<[i32; 3]>())?;
                    leaves.push(corner.map(|index| index as i32));
                    if let Some([low, high]) = active(mask) {
                        let at = |offset: [i64; 3]| [0, 1, 2].map(|i| corner[i] + offset[i]);
                        meet(at(low), at(high));
                    }
                }
            }
            Ok(())
        })?;
        (tree.indices, tree.leaves) = (bounds, leaves);
        Ok(tree)
    }

    /// Visits all tiles and leaves; what follows them is returned.
    fn walk(
        &self,
        mut visit: impl FnMut(Part<'a>) -> Result<(), LoadError>,
    ) -> Result<Words<'a>, LoadError> {
        let mut words = self.topology.clone();
        let [tiles, nodes] = self.counts;
        let mut corners = HashSet::new();
        let size = UPPER.0 as i64 * UPPER.1;
        for index in 0..u64::from(tiles) + u64::from(nodes) {
            let corner = [(); 3].map(|()| words.u32(WHAT));
            let [x, y, z] = corner;
            let corner = [x?, y?, z?].map(|index| i64::from(index.cast_signed()));
            // Of two nodes at one place both would be written, however often.
            let is_place = corner.iter().all(|index| index % size == 0) && corners.insert(corner);
            if !is_place {
                let what = "the place of a node of an OpenVDB grid";
                let value = format!("{corner:?}");
                return Err(LoadError::bad_value(what, value, "one of its own, by 4096"));
            }
            if index < tiles.into() {
                let value = f32::from_le_bytes(words.item(WHAT)?);
                let [active] = words.item(WHAT)?;
                visit(Part::Tile {
                    corner,
                    size,
                    value,
                    is_active: active != 0,
                })?;
            } else {
                self.node(&mut words, corner, UPPER, &mut visit)?;
            }
        }
        Ok(words)
    }

    /// Visits what is below a node.
    fn node(
        &self,
        words: &mut Words<'a>,
        corner: [i64; 3],
        level: (usize, i64),
        visit: &mut impl FnMut(Part<'a>) -> Result<(), LoadError>,
    ) -> Result<(), LoadError> {
        let (width, size) = level;
        let count = width * width * width;
        let children = words.bytes(WHAT, count as u64 / 8)?;
        let mask = words.bytes(WHAT, count as u64 / 8)?;
        let mut values = Vec::with_capacity(count);
        self.packing
            .read(words, mask, self.background, &mut values)?;
        let place = |index: usize| {
            let offset = [
                index / (width * width),
                index / width % width,
                index % width,
            ];
            [0, 1, 2].map(|axis| corner[axis] + size * offset[axis] as i64)
        };
        for (index, &value) in values.iter().enumerate() {
            if !is_on(children, index) {
                visit(Part::Tile {
                    corner: place(index),
                    size,
                    value,
                    is_active: is_on(mask, index),
                })?;
            }
        }
        for index in (0..count).filter(|&index| is_on(children, index)) {
            let corner = place(index);
            if size == LEAF {
                let mask = words.bytes(WHAT, 64)?;
                visit(Part::Leaf { corner, mask })?;
            } else {
                self.node(words, corner, LOWER, visit)?;
            }
        }
        Ok(())
    }
}

impl VoxelGrid for Tree<'_> {
    const FORMAT: &'static str = "OpenVDB";

    fn indices(&self) -> Option<[[i64; 3]; 2]> {
        self.indices
    }

    fn placement(&self) -> Placement {
        self.placement
    }

    fn background(&self) -> f32 {
        self.background
    }

    fn fill(&self, dense: &mut Dense) -> Result<(), LoadError> {
        self.walk(|part| {
            if let Part::Tile {
                corner,
                size,
                value,
                ..
            } = part
                && value != self.background
            {
                dense.fill([corner, corner.map(|index| index + size - 1)], value);
            }
            Ok(())
        })?;
        let mut words = self.values.clone();
        let mut values = Vec::new();
        for corner in &self.leaves {
            let mask = words.bytes(WHAT, 64)?;
            self.packing
                .read(&mut words, mask, self.background, &mut values)?;
            dense.leaf(corner.map(i64::from), |index| values[index]);
        }
        Ok(())
    }
}

/// The least and the greatest place of the voxels of a leaf that are active.
fn active(mask: &[u8]) -> Option<[[i64; 3]; 2]> {
    let (mut low, mut high) = ([LEAF; 3], [-1; 3]);
    for (row, &byte) in mask.iter().enumerate().filter(|(_, byte)| **byte != 0) {
        let [x, y] = [row as i64 / LEAF, row as i64 % LEAF];
        let [first, last] = [byte.trailing_zeros(), 7 - byte.leading_zeros()].map(i64::from);
        for (axis, [from, to]) in [[x, x], [y, y], [first, last]].into_iter().enumerate() {
            low[axis] = low[axis].min(from);
            high[axis] = high[axis].max(to);
        }
    }
    (high[0] >= 0).then_some([low, high])
}

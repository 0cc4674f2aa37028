//! Volumes that neighbouring questions of a batch share.
//!
//! Neighbours ask about the same few volumes of 8 × 8 × 8 voxels. [`Blocks`] keeps those that
//! were met last as eight masks, so that a batch descends once to a volume, however many of its
//! questions fall into it and in whatever order they come. Where most questions meet new volumes
//! it looks away for a while: those have little in common, and are answered one by one.
//!
//! A question whose volumes are kept takes a product, a comparison and a mask for each of them,
//! 80 bytes at most in the caches of the first and second level. A new volume is a chain of
//! loads, one for each level of the graph and two for packed nodes, and eight masks; this binds.
//! Row by row over a city, voxels take 0.25 (packed) and 0.4 (plain) of the time that they take
//! one by one, and windows of 9 × 9 texels 0.5 and 0.7, which is 2.3 to 2.9 times that of a dense
//! map of 16 bits.

use glam::UVec3;

use super::filter::{Count, Window, count_all};
use super::point::{bit, is_lit, octant};
use crate::nodes::Nodes;
use crate::pool::{LIT, Reference, SHADOWED};
use crate::top::Top;

/// The most volumes that are kept: 64 KiB of masks, which is what a row of a large picture
/// meets.
const MOST: usize = 1024;

/// Windows of more tiles than this are counted on the way down, where what is all lit or all
/// shadowed is one step.
const WIDE: u32 = 64;

/// How many more questions than not may meet new volumes, and how many are then answered
/// without what is kept. Voxels of a city in no order take 0.9 to 1.0 of the time that they take
/// one by one with these, and windows 0.9 to 1.2.
const PATIENCE: i32 = 128;
const REST: u32 = 1024;

/// No volume has this number, since there are 2¹⁷ along each axis at most.
const NONE: u64 = u64::MAX;

/// The volumes that were met last, each at the one place that its number names.
pub(super) struct Blocks<'a, N> {
    nodes: &'a N,
    top: &'a Top,
    /// The volume whose masks are at each place.
    kept: Vec<u64>,
    masks: Vec<[u64; 8]>,
    /// A hash shifted down by this is the number of a place.
    shift: u32,
    /// Whether a question has met a volume that is not kept yet.
    is_new: bool,
    /// The questions of late that met none less those that did, at most [`PATIENCE`].
    use_of_late: i32,
    /// Questions to come that are answered without what is kept.
    rest: u32,
}

impl<'a, N: Nodes> Blocks<'a, N> {
    /// With room for what so many questions may share.
    pub(super) fn new(nodes: &'a N, top: &'a Top, questions: usize) -> Self {
        let room = (questions / 4).clamp(2, MOST).next_power_of_two();
        Self {
            nodes,
            top,
            kept: vec![NONE; room],
            masks: vec![[0; 8]; room],
            shift: u64::BITS - room.trailing_zeros(),
            is_new: false,
            use_of_late: 0,
            rest: 0,
        }
    }

    /// Whether to look for the volumes of the next question: not where most have met new ones,
    /// since decoding what is not asked about again costs more than the way down.
    #[inline(always)]
    fn is_of_use(&mut self) -> bool {
        if self.rest > 0 {
            self.rest -= 1;
            return false;
        }
        let change = if self.is_new { -1 } else { 1 };
        self.is_new = false;
        self.use_of_late = (self.use_of_late + change).min(PATIENCE);
        if self.use_of_late < -PATIENCE {
            (self.use_of_late, self.rest) = (0, REST);
        }
        true
    }

    /// The number of the volume in which a voxel is, and its place. The product with the
    /// golden ratio spreads volumes that are neighbours along any axis.
    #[inline(always)]
    fn place(&self, x: u32, y: u32, z: u32) -> (u64, usize) {
        let volume = u64::from(x >> 3) | u64::from(y >> 3) << 20 | u64::from(z >> 3) << 40;
        let hash = volume.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (volume, (hash >> self.shift) as usize)
    }

    /// The mask around a voxel.
    #[inline(always)]
    fn mask(&mut self, x: u32, y: u32, z: u32) -> u64 {
        let (volume, at) = self.place(x, y, z);
        if self.kept[at] != volume {
            self.is_new = true;
            self.kept[at] = volume;
            self.decode(at, x, y, z);
        }
        self.masks[at][z as usize & 7]
    }

    #[cold]
    #[inline(never)]
    fn decode(&mut self, at: usize, x: u32, y: u32, z: u32) {
        self.masks[at] = volume(self.nodes, self.top, x, y, z);
    }

    /// Whether a voxel of the grid is lit.
    #[inline(always)]
    pub(super) fn is_lit(&mut self, voxel: UVec3) -> bool {
        if self.is_of_use() {
            self.mask(voxel.x, voxel.y, voxel.z) >> bit(voxel.x, voxel.y) & 1 == 1
        } else {
            is_lit(self.nodes, self.top, voxel)
        }
    }

    /// Counts the lit texels of a window of slice `z`.
    #[inline(always)]
    pub(super) fn count<C: Count>(&mut self, window: Window, z: u32, into: &mut C) {
        let tiles = |[first, last]: [u32; 2]| (last >> 3) - (first >> 3) + 1;
        if tiles(window.x).saturating_mul(tiles(window.y)) > WIDE || !self.is_of_use() {
            return count_all(self.nodes, self.top, window, z, into);
        }
        for y in window.y[0] >> 3..=window.y[1] >> 3 {
            for x in window.x[0] >> 3..=window.x[1] >> 3 {
                let mask = self.mask(x << 3, y << 3, z);
                into.masked(window.cut(x, y, 3), mask);
            }
        }
    }
}

/// The eight slices of the volume of 8 × 8 × 8 voxels around a voxel of the grid.
fn volume<N: Nodes>(nodes: &N, top: &Top, x: u32, y: u32, z: u32) -> [u64; 8] {
    let mask = |reference: Reference| match reference {
        LIT => u64::MAX,
        SHADOWED => 0,
        slice => nodes.mask(slice),
    };
    let mut reference = top.find(x, y, z);
    let mut level = top.level;
    loop {
        if let LIT | SHADOWED = reference {
            return [mask(reference); 8];
        }
        let node = nodes.node(level, reference);
        if level == 0 {
            return nodes.children(node).map(mask);
        }
        reference = nodes.child(node, octant(level, x, y, z));
        level -= 1;
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::Resolution;
    use crate::pool::{Children, Pool};

    /// Counts the nodes that are looked at.
    struct Counted<'a>(&'a Pool, Cell<usize>);

    impl Nodes for Counted<'_> {
        type Node = <Pool as Nodes>::Node;

        fn node(&self, level: usize, reference: Reference) -> Self::Node {
            self.1.set(self.1.get() + 1);
            self.0.node(level, reference)
        }

        fn child(&self, node: Self::Node, child: u32) -> Reference {
            self.0.child(node, child)
        }

        fn children(&self, node: Self::Node) -> Children {
            self.0.children(node)
        }

        fn mask(&self, reference: Reference) -> u64 {
            self.0.mask(reference)
        }

        fn extent(&self, level: usize) -> usize {
            self.0.extent(level)
        }

        fn mask_extent(&self) -> usize {
            self.0.mask_extent()
        }
    }

    /// Nodes on the way to a mask.
    const WAY: usize = 4;

    /// A grid of 64³ voxels, of whose every volume of 8³ the slices name masks 1 to 8.
    fn grid() -> (Pool, Top) {
        let mut pool = Pool::new(Resolution::new(64).unwrap());
        let slices = [1, 2, 3, 4, 5, 6, 7, 8].map(|mask| Pool::mask(&mut pool, mask));
        let mut reference = Pool::node(&mut pool, 0, slices);
        for level in 1..WAY {
            reference = Pool::node(&mut pool, level, [reference; 8]);
        }
        let top = Top {
            log2: 0,
            level: WAY - 1,
            cells: vec![reference],
        };
        (pool, top)
    }

    #[test]
    fn questions_about_one_volume_descend_to_it_once() {
        let (pool, top) = grid();
        let nodes = Counted(&pool, Cell::new(0));
        let mut blocks = Blocks::new(&nodes, &top, 512);
        for i in 0..512 {
            let [x, y, z] = [i % 8, i / 8 % 8, i / 64];
            let expected = u64::from(z + 1) >> bit(x, y) & 1 == 1;
            let voxel = UVec3::new(16 + x, 8 + y, 40 + z);
            assert_eq!(blocks.is_lit(voxel), expected, "{voxel}");
        }
        assert_eq!(nodes.1.get(), WAY);
    }

    #[test]
    fn windows_over_the_same_tiles_descend_to_each_once() {
        let (pool, top) = grid();
        let nodes = Counted(&pool, Cell::new(0));
        let mut blocks = Blocks::new(&nodes, &top, 512);
        for i in 0..49 {
            let window = Window {
                x: [17 + i % 7, 24 + i % 7],
                y: [9 + i / 7, 16 + i / 7],
            };
            let (mut lit, mut expected) = (0, 0);
            blocks.count(window, 42, &mut lit);
            count_all(&pool, &top, window, 42, &mut expected);
            assert_eq!(lit, expected, "{window:?}");
        }
        assert_eq!(nodes.1.get(), 4 * WAY);
    }

    #[test]
    fn questions_about_different_volumes_descend_once_each() {
        let (pool, top) = grid();
        let nodes = Counted(&pool, Cell::new(0));
        let mut blocks = Blocks::new(&nodes, &top, 512);
        for i in 0..512 {
            blocks.is_lit(8 * UVec3::new(i % 8, i / 8 % 8, i / 64));
        }
        assert_eq!(nodes.1.get(), 512 * WAY);
    }
}

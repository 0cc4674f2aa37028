//! Nodes as they are stored, and what queries need to know of them.

use crate::bytes::{load_bits, load_u32, load_u64};
use crate::layout::{PackedLevel, PlainLevel};
use crate::pool::{Children, LIT, Pool, Reference, SHADOWED};

/// Stored nodes that can be walked.
pub(crate) trait Nodes {
    /// A node that has been found.
    type Node: Copy;

    /// The node of `level` that `reference` names.
    fn node(&self, level: usize, reference: Reference) -> Self::Node;

    /// Child 0 to 7 of a node: octants `4 z + 2 y + x`, or slices on level 0.
    fn child(&self, node: Self::Node, child: u32) -> Reference;

    /// All children of a node.
    fn children(&self, node: Self::Node) -> Children;

    /// The mask that a child of a node of level 0 names.
    fn mask(&self, reference: Reference) -> u64;

    /// One more than the largest reference to a node of `level`.
    fn extent(&self, level: usize) -> usize;

    /// One more than the largest reference to a mask.
    fn mask_extent(&self) -> usize;
}

impl Nodes for Pool {
    type Node = Children;

    fn node(&self, level: usize, reference: Reference) -> Children {
        self.levels[level].items()[reference as usize]
    }

    fn child(&self, node: Children, child: u32) -> Reference {
        node[child as usize]
    }

    fn children(&self, node: Children) -> Children {
        node
    }

    fn mask(&self, reference: Reference) -> u64 {
        self.masks.items()[reference as usize]
    }

    fn extent(&self, level: usize) -> usize {
        self.levels[level].items().len()
    }

    fn mask_extent(&self) -> usize {
        self.masks.items().len()
    }
}

/// The kind of a child, in two bits.
pub(crate) mod kind {
    pub(crate) const SHADOWED: u32 = 0;
    pub(crate) const LIT: u32 = 1;
    pub(crate) const MIXED: u32 = 2;
    /// The bits that tell mixed children from others.
    pub(crate) const ALL_MIXED: u32 = 0xaaaa;
}

/// A word with two bits per child, followed by a word for each mixed child.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plain<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) masks: usize,
    pub(crate) mask_count: u32,
    pub(crate) levels: &'a [PlainLevel],
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct PlainNode {
    kinds: u32,
    at: usize,
}

impl Nodes for Plain<'_> {
    type Node = PlainNode;

    #[inline]
    fn node(&self, level: usize, reference: Reference) -> PlainNode {
        let at = self.levels[level].start + 4 * reference as usize;
        PlainNode {
            kinds: load_u32(self.bytes, at),
            at,
        }
    }

    #[inline]
    fn child(&self, node: PlainNode, child: u32) -> Reference {
        match node.kinds >> (2 * child) & 3 {
            kind::SHADOWED => SHADOWED,
            kind::LIT => LIT,
            _ => {
                let below = node.kinds & kind::ALL_MIXED & ((1 << (2 * child)) - 1);
                load_u32(self.bytes, node.at + 4 + 4 * below.count_ones() as usize)
            }
        }
    }

    #[inline]
    fn children(&self, node: PlainNode) -> Children {
        let mut at = node.at;
        std::array::from_fn(|child| match node.kinds >> (2 * child) & 3 {
            kind::SHADOWED => SHADOWED,
            kind::LIT => LIT,
            _ => {
                at += 4;
                load_u32(self.bytes, at)
            }
        })
    }

    #[inline]
    fn mask(&self, reference: Reference) -> u64 {
        load_u64(self.bytes, self.masks + 8 * reference as usize)
    }

    fn extent(&self, level: usize) -> usize {
        self.levels[level].words as usize
    }

    fn mask_extent(&self) -> usize {
        self.mask_count as usize
    }
}

/// Values of a child in a shape that say that no reference is stored for it.
pub(crate) mod slot {
    pub(crate) const LIT: u32 = 8;
    pub(crate) const SHADOWED: u32 = 9;
    /// From here on: the reference of the child in front, plus what the value
    /// is above this.
    pub(crate) const AFTER: u32 = 10;
}

/// The number of a shape, followed by the references that differ.
///
/// A *shape* says for each child, in four bits, which of the references it
/// has, or that it is lit or shadowed: equal neighbours along the light cost
/// nothing, and neither do masks whose number is the next. Nodes are sorted by
/// their number of references, so that the number of a node says where it is,
/// and numbers of nodes, shapes and masks take as many bits as the level
/// needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Packed<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) masks: usize,
    pub(crate) mask_count: u32,
    /// Where the shapes of slice nodes and of all others lie.
    pub(crate) shapes: [usize; 2],
    pub(crate) levels: &'a [PackedLevel],
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct PackedNode {
    shape: u32,
    width: u32,
    /// The bit at which the references begin.
    at: u64,
}

impl Nodes for Packed<'_> {
    type Node = PackedNode;

    #[inline]
    fn node(&self, level: usize, reference: Reference) -> PackedNode {
        let info = &self.levels[level];
        let at = info.address(reference);
        let shape = load_bits(self.bytes, at, info.shape_width);
        let shapes = self.shapes[usize::from(level > 0)];
        PackedNode {
            shape: load_u32(self.bytes, shapes + 4 * shape as usize),
            width: info.width,
            at: at + u64::from(info.shape_width),
        }
    }

    #[inline]
    fn child(&self, node: PackedNode, child: u32) -> Reference {
        let mut slot = node.shape >> (4 * child) & 15;
        let mut steps = 0;
        match slot {
            slot::LIT => return LIT,
            slot::SHADOWED => return SHADOWED,
            _ => {}
        }
        // In front of the first child there is nothing in a sound file.
        let mut stored = child;
        while slot >= slot::AFTER && stored > 0 {
            steps += slot - slot::AFTER;
            stored -= 1;
            slot = node.shape >> (4 * stored) & 15;
        }
        let at = node.at + u64::from(slot) * u64::from(node.width);
        load_bits(self.bytes, at, node.width).wrapping_add(steps)
    }

    #[inline]
    fn children(&self, node: PackedNode) -> Children {
        // The reference of the child in front, which is mixed in a sound file.
        let mut reference: Reference = 0;
        std::array::from_fn(|child| {
            match node.shape >> (4 * child) & 15 {
                slot::LIT => return LIT,
                slot::SHADOWED => return SHADOWED,
                slot if slot >= slot::AFTER => {
                    reference = reference.wrapping_add(slot - slot::AFTER);
                }
                slot => {
                    let at = node.at + u64::from(slot) * u64::from(node.width);
                    reference = load_bits(self.bytes, at, node.width);
                }
            }
            reference
        })
    }

    #[inline]
    fn mask(&self, reference: Reference) -> u64 {
        load_u64(self.bytes, self.masks + 8 * reference as usize)
    }

    fn extent(&self, level: usize) -> usize {
        self.levels[level].nodes() as usize
    }

    fn mask_extent(&self) -> usize {
        self.mask_count as usize
    }
}

//! The least and the most that is lit in a box.

use glam::{IVec3, UVec3};

use super::point::clamp;
use crate::ShadowDag;
use crate::dag::with_nodes;
use crate::nodes::Nodes;
use crate::pool::{LIT, Reference, SHADOWED};

/// What there is in a box. As a number, bit 0 says that some voxels are lit
/// and bit 1 that some are shadowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Visibility {
    /// Only voxels that are lit.
    Lit = 1,
    /// Only voxels that are shadowed.
    Shadowed = 2,
    /// Some of either.
    Mixed = 3,
}

/// Which kinds of voxels were met.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    lit: bool,
    shadowed: bool,
}

/// A part of the grid, ends included.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    first: UVec3,
    last: UVec3,
}

impl Seen {
    fn mask(&mut self, mask: u64, window: u64) {
        self.lit |= mask & window != 0;
        self.shadowed |= !mask & window != 0;
    }

    /// Looks at the part of a node that is in `bounds`, in coordinates of the
    /// grid; the node begins at `origin`.
    fn visit<N: Nodes>(
        &mut self,
        nodes: &N,
        level: usize,
        reference: Reference,
        origin: UVec3,
        bounds: Bounds,
    ) {
        match reference {
            LIT => self.lit = true,
            SHADOWED => self.shadowed = true,
            _ => {
                let node = nodes.node(level, reference);
                let half = 4 << level;
                let first = bounds.first.max(origin) - origin;
                let last = (bounds.last - origin).min(UVec3::splat(2 * half - 1));
                if level == 0 {
                    let window = window(first.x, last.x, first.y, last.y);
                    for z in first.z..=last.z {
                        let mask = match nodes.child(node, z) {
                            LIT => u64::MAX,
                            SHADOWED => 0,
                            slice => nodes.mask(slice),
                        };
                        self.mask(mask, window);
                    }
                    return;
                }
                for child in 0..8 {
                    let at = UVec3::new(child & 1, child >> 1 & 1, child >> 2) * half;
                    let meets = at.cmple(last).all() && (at + (half - 1)).cmpge(first).all();
                    if meets && !(self.lit && self.shadowed) {
                        let below = nodes.child(node, child);
                        self.visit(nodes, level - 1, below, origin + at, bounds);
                    }
                }
            }
        }
    }
}

/// The bits of a mask in columns `x0` to `x1` and rows `y0` to `y1`, all 0…7,
/// ends included.
#[inline(always)]
pub(crate) fn window(x0: u32, x1: u32, y0: u32, y1: u32) -> u64 {
    let row = 0xff_u64 >> (7 - (x1 - x0)) << x0;
    let rows = u64::MAX >> (8 * (7 - (y1 - y0))) << (8 * y0);
    (row * 0x0101_0101_0101_0101) & rows
}

impl<B: AsRef<[u8]>> ShadowDag<B> {
    /// Whether the voxels from `first` to `last`, both included, are all lit,
    /// all shadowed or neither; outside of the grid as for
    /// [`ShadowDag::is_lit`]. If an axis runs backwards the box is empty, and
    /// lit.
    ///
    /// Stops as soon as it has met both.
    pub fn visibility(&self, first: impl Into<[i32; 3]>, last: impl Into<[i32; 3]>) -> Visibility {
        let first = IVec3::from_array(first.into());
        let last = IVec3::from_array(last.into());
        if first.cmpgt(last).any() {
            return Visibility::Lit;
        }
        let end = IVec3::splat(self.resolution().side() as i32 - 1);
        let inside = first.cmpge(IVec3::ZERO).all() && last.truncate().cmple(end.truncate()).all();
        let mut seen = Seen {
            lit: !inside,
            shadowed: false,
        };
        // The part of the box inside of the grid.
        let within = |voxel: IVec3| clamp(voxel, self.resolution().side());
        let (near, far) = (within(first.max(IVec3::ZERO)), within(last.min(end)));
        if let (Some(first), Some(last)) = (near, far) {
            let bounds = Bounds { first, last };
            with_nodes!(self, nodes => seen.visit(
                nodes,
                self.resolution().root_level(),
                self.layout.root,
                UVec3::ZERO,
                bounds,
            ));
        }
        match seen {
            Seen {
                lit: true,
                shadowed: true,
            } => Visibility::Mixed,
            Seen { shadowed: true, .. } => Visibility::Shadowed,
            _ => Visibility::Lit,
        }
    }
}

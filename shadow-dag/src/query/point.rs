//! Whether a voxel is lit.

use glam::{IVec3, UVec3};

use crate::ShadowDag;
use crate::dag::with_nodes;
use crate::nodes::Nodes;
use crate::pool::{LIT, Reference, SHADOWED};
use crate::top::Top;

/// The octant of a node of `level` > 0 in which a voxel is.
#[inline]
pub(crate) fn octant(level: usize, x: u32, y: u32, z: u32) -> u32 {
    let shift = level as u32 + 2;
    (z >> shift & 1) << 2 | (y >> shift & 1) << 1 | (x >> shift & 1)
}

/// The bit of a voxel in its mask.
#[inline]
pub(crate) fn bit(x: u32, y: u32) -> u32 {
    (y & 7) << 3 | (x & 7)
}

/// Whether a voxel below a node is lit; all coordinates are of the grid, or of
/// the node.
#[inline]
pub(crate) fn descend<N: Nodes>(
    nodes: &N,
    mut level: usize,
    mut reference: Reference,
    x: u32,
    y: u32,
    z: u32,
) -> bool {
    loop {
        match reference {
            LIT => return true,
            SHADOWED => return false,
            _ => {}
        }
        let node = nodes.node(level, reference);
        if level == 0 {
            let slice = nodes.child(node, z & 7);
            return match slice {
                LIT => true,
                SHADOWED => false,
                _ => nodes.mask(slice) >> bit(x, y) & 1 == 1,
            };
        }
        reference = nodes.child(node, octant(level, x, y, z));
        level -= 1;
    }
}

/// Whether a voxel of the grid is lit.
#[inline]
pub(crate) fn is_lit<N: Nodes>(nodes: &N, top: &Top, voxel: UVec3) -> bool {
    let UVec3 { x, y, z } = voxel;
    descend(nodes, top.level, top.find(x, y, z), x, y, z)
}

/// The voxel of a grid of `side` that answers for `voxel`; none if it is lit
/// because nothing is known there.
#[inline]
pub(crate) fn clamp(voxel: IVec3, side: u32) -> Option<UVec3> {
    let voxel = voxel.with_z(voxel.z.min(side as i32 - 1));
    let known = voxel.cmpge(IVec3::ZERO).all() && voxel.max_element() < side as i32;
    known.then(|| voxel.as_uvec3())
}

impl<B: AsRef<[u8]>> ShadowDag<B> {
    /// True if light reaches the voxel. Voxels beside the map or in front of
    /// it are lit; those behind the last slice answer as the last slice does.
    pub fn is_lit(&self, voxel: impl Into<[i32; 3]>) -> bool {
        let voxel = IVec3::from_array(voxel.into());
        match clamp(voxel, self.resolution().side()) {
            None => true,
            Some(voxel) => with_nodes!(self, nodes => is_lit(nodes, &self.top, voxel)),
        }
    }
}

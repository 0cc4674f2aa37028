//! Back from voxels to the depth of a texel.

use glam::UVec2;

use super::point::{bit, descend};
use crate::ShadowDag;
use crate::dag::with_nodes;
use crate::nodes::Nodes;
use crate::pool::{LIT, Reference, SHADOWED};

/// The first shadowed slice below a node, from its front; its size if there
/// is none.
fn first_shadowed<N: Nodes>(
    nodes: &N,
    mut level: usize,
    mut reference: Reference,
    x: u32,
    y: u32,
) -> u32 {
    let mut front = 0;
    loop {
        match reference {
            LIT => return front + (8 << level),
            SHADOWED => return front,
            _ => {}
        }
        let node = nodes.node(level, reference);
        if level == 0 {
            let lit = |&z: &u32| match nodes.child(node, z) {
                LIT => true,
                SHADOWED => false,
                slice => nodes.mask(slice) >> bit(x, y) & 1 == 1,
            };
            return front + (0..8).take_while(lit).count() as u32;
        }
        let shift = level as u32 + 2;
        let quarter = (y >> shift & 1) << 1 | (x >> shift & 1);
        let near = nodes.child(node, quarter);
        // A column turns from lit to shadowed once: if the near half is still lit at its
        // end, it is lit throughout.
        let half = 4 << level;
        reference = if descend(nodes, level - 1, near, x, y, half - 1) {
            front += half;
            nodes.child(node, 4 + quarter)
        } else {
            near
        };
        level -= 1;
    }
}

impl<B: AsRef<[u8]>> ShadowDag<B> {
    /// The first slice of a texel that is shadowed: between its enter and
    /// exit slice. N if all of the column is lit, and for texels beside the
    /// map.
    ///
    /// Takes a time in proportion to the square of the number of levels. A
    /// file that was not built here might hold columns that turn more than
    /// once; for those it is some slice at which they do.
    pub fn depth(&self, texel: impl Into<[u32; 2]>) -> u32 {
        let texel = UVec2::from_array(texel.into());
        let side = self.resolution().side();
        if texel.max_element() >= side {
            return side;
        }
        with_nodes!(self, nodes => first_shadowed(
            nodes,
            self.resolution().root_level(),
            self.layout.root,
            texel.x,
            texel.y,
        ))
    }
}

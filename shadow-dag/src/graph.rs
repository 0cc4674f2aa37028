//! The finished set of nodes, in an order that only depends on its contents.

use crate::nodes::Nodes;
use crate::pool::{Children, Reference, is_mixed};
use crate::resolution::Resolution;

/// A directed acyclic graph of nodes without duplicates.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Graph {
    pub(crate) resolution: Resolution,
    /// A node of the coarsest level, or a homogeneous volume.
    pub(crate) root: Reference,
    pub(crate) masks: Vec<u64>,
    /// From the finest level to the root.
    pub(crate) levels: Vec<Vec<Children>>,
}

impl Graph {
    /// The nodes that `root` needs. Each level is numbered in the order in
    /// which its nodes are met going through the level above, so the order in
    /// which they were made or stored leaves no trace.
    pub(crate) fn collect<N: Nodes>(resolution: Resolution, nodes: &N, root: Reference) -> Self {
        let mut levels = vec![Vec::new(); resolution.root_level() + 1];
        let mut wanted: Vec<Reference> = Vec::from_iter(is_mixed(root).then_some(root));
        let new_root = if is_mixed(root) { 0 } else { root };
        for (level, found) in levels.iter_mut().enumerate().rev() {
            let below = match level {
                0 => nodes.mask_extent(),
                _ => nodes.extent(level - 1),
            };
            let mut names = vec![u32::MAX; below];
            let mut next: Vec<Reference> = Vec::new();
            found.extend(wanted.iter().map(|&reference| {
                let node = nodes.node(level, reference);
                nodes.children(node).map(|child| {
                    if !is_mixed(child) {
                        return child;
                    }
                    let name = &mut names[child as usize];
                    if *name == u32::MAX {
                        *name = next.len() as u32;
                        next.push(child);
                    }
                    *name
                })
            }));
            wanted = next;
        }
        Self {
            resolution,
            root: new_root,
            masks: wanted.iter().map(|&mask| nodes.mask(mask)).collect(),
            levels,
        }
    }
}

//! How a blocker is put among the nodes of a curve, and one curve among those of
//! another.

use crate::BlockerSegment;
use crate::lookup::Rules;
use crate::node::{Node, count_in_front};
use crate::numeric::fraction;

/// A node at `depth` on the curve, to be put at `index`, between its
/// neighbours there.
#[inline]
fn on_the_curve<L: Rules, const C: usize>(nodes: &[Node<C>], index: usize, depth: f32) -> Node<C> {
    if index == 0 {
        return Node {
            depth,
            value: [L::CLEAR; C],
            ..Node::UNUSED
        };
    }
    let mut node = nodes[index - 1];
    if let Some(next) = nodes.get(index) {
        let fraction = fraction(node.depth, next.depth, depth);
        for (value, next) in node.value.iter_mut().zip(next.value) {
            *value = L::mix(*value, next, fraction);
        }
    }
    Node { depth, ..node }
}

/// Moves the nodes from `start` to `end` back by `by` entries.
#[inline(always)]
fn move_back<const C: usize>(nodes: &mut [Node<C>], start: usize, end: usize, by: usize) {
    // For the few nodes of a curve this loop is faster than a call to a copying function.
    for index in (start..end).rev() {
        nodes[index + by] = nodes[index];
    }
}

/// Multiplies the curve of the first `len` nodes by a blocker. Adds nodes where
/// it begins and ends, unless there are some: two at most, for which there must
/// be room.
#[inline]
pub(crate) fn insert<L: Rules, const C: usize>(
    nodes: &mut [Node<C>],
    len: &mut usize,
    segment: &BlockerSegment<C>,
) {
    let (entry, exit) = (segment.entry(), segment.exit());
    let before = *len;
    let (mut first, mut after) = counts_in_front(&nodes[..before], [entry, exit]);
    let is_at = |index: usize, depth: f32| index < before && nodes[index].depth == depth;
    let is_there = is_at(first, entry);
    let is_step = is_there && is_at(first + 1, entry);
    if exit > entry {
        let ends_there = is_at(after, exit);
        let start = (!is_there).then(|| on_the_curve::<L, C>(&nodes[..before], first, entry));
        let end = (!ends_there).then(|| on_the_curve::<L, C>(&nodes[..before], after, exit));
        let added = usize::from(!is_there);
        move_back(nodes, after, before, added + usize::from(!ends_there));
        if let Some(node) = end {
            nodes[after + added] = node;
        }
        if let Some(node) = start {
            move_back(nodes, first, after, 1);
            nodes[first] = node;
        }
        *len += added + usize::from(!ends_there);
        // Now `first` is the last node that is not behind the entry, and `after` the first that
        // gets all of the optical depth.
        first += usize::from(is_step);
        after += added;
    } else {
        // A surface is a step of two nodes, one in front of it and one behind.
        after = first + 1;
        if !is_step {
            let node = if is_there {
                nodes[first]
            } else {
                on_the_curve::<L, C>(&nodes[..before], first, entry)
            };
            let added = 1 + usize::from(!is_there);
            move_back(nodes, first, before, added);
            nodes[first] = node;
            nodes[after] = node;
            *len += added;
        }
    }
    L::attenuate(&mut nodes[first..*len], after - first, segment);
}

/// [`count_in_front`] of two depths.
#[inline(always)]
fn counts_in_front<const C: usize>(nodes: &[Node<C>], depths: [f32; 2]) -> (usize, usize) {
    /// Up to this number, comparing all is as fast.
    const FEW: usize = 12;
    if nodes.len() > FEW {
        let count = |depth| count_in_front(|index| nodes[index].depth, nodes.len(), depth);
        return (count(depths[0]), count(depths[1]));
    }
    let mut counts = (0, 0);
    for node in nodes {
        counts.0 += usize::from(node.depth < depths[0]);
        counts.1 += usize::from(node.depth < depths[1]);
    }
    counts
}

/// The product of two curves, in `out`; its number of nodes is at most the sum
/// of theirs, for which there must be room, there and in `scratch`.
pub(crate) fn multiply<L: Rules, const C: usize>(
    a: &[Node<C>],
    b: &[Node<C>],
    out: &mut [Node<C>],
    scratch: &mut [Node<C>],
) -> usize {
    /// Takes the next node of a curve if it is at `depth`, else one that says
    /// what the curve has there.
    fn step<L: Rules, const C: usize>(nodes: &[Node<C>], next: &mut usize, depth: f32) -> Node<C> {
        match nodes.get(*next) {
            Some(node) if node.depth == depth => {
                *next += 1;
                *node
            }
            _ => on_the_curve::<L, C>(nodes, *next, depth),
        }
    }
    let (mut i, mut j, mut len) = (0, 0, 0);
    while i < a.len() || j < b.len() {
        let depth_of = |node: Option<&Node<C>>| node.map_or(f32::INFINITY, |node| node.depth);
        let depth = depth_of(a.get(i)).min(depth_of(b.get(j)));
        out[len] = step::<L, C>(a, &mut i, depth);
        scratch[len] = step::<L, C>(b, &mut j, depth);
        len += 1;
    }
    L::multiply(&mut out[..len], &scratch[..len]);
    len
}

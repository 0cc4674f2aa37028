//! Nodes of a transmittance curve, and how a blocker is put among them.
//!
//! Nodes are ordered by depth. At most two share a depth: the value just
//! before a surface and the value behind it. The first has the value of a
//! clear ray, so that what lies in front of it is 1; what lies behind the last
//! has the last one's value.

use crate::Segment;
use crate::lookup::Rules;

/// A point of the curve, and what is known about the stretch up to the next.
///
/// Values are those of the curve's lookup: transmittances (linear) or optical
/// depths (exponential). On the stretch that begins here the exact curve lies
/// between `interpolated − below` and `interpolated + above` in the same
/// quantity, roundings of the values aside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node<const C: usize> {
    pub(crate) depth: f32,
    pub(crate) value: [f32; C],
    pub(crate) above: [f32; C],
    pub(crate) below: [f32; C],
}

impl<const C: usize> Node<C> {
    /// What unused places hold.
    pub(crate) const UNUSED: Self = Self {
        depth: 0.0,
        value: [0.0; C],
        above: [0.0; C],
        below: [0.0; C],
    };
}

/// Share of the way from `from` to `to` at which `depth` lies. In f64 neither
/// the depths of f32 nor their differences can overflow or get lost.
#[inline]
pub(crate) fn fraction(from: f32, to: f32, depth: f32) -> f64 {
    let from = f64::from(from);
    let length = f64::from(to) - from;
    if length != 0.0 {
        (f64::from(depth) - from) / length
    } else {
        0.0
    }
}

/// `from + (to − from) · fraction`, rounded once, and never beyond `to`.
#[inline]
pub(crate) fn mix(from: f32, to: f32, fraction: f64) -> f32 {
    let mixed = (f64::from(from) + (f64::from(to) - f64::from(from)) * fraction) as f32;
    mixed.max(from.min(to)).min(from.max(to))
}

/// Number of the first `len` depths that are in front of `depth`; 0 for NaN.
///
/// Two levels: every fourth depth says which group, the group says the rest.
/// There is no branch that depends on the depths.
#[inline]
pub(crate) fn count_in_front(depths: impl Fn(usize) -> f32, len: usize, depth: f32) -> usize {
    const GROUP: usize = 4;
    let groups = (0..len / GROUP)
        .filter(|group| depths(group * GROUP + GROUP - 1) < depth)
        .count();
    let start = groups * GROUP;
    start
        + (start..len.min(start + GROUP))
            .filter(|&index| depths(index) < depth)
            .count()
}

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
            *value = mix(*value, next, fraction);
        }
    }
    Node { depth, ..node }
}

/// Opens a place at `index` for `node`.
#[inline]
fn place<const C: usize>(nodes: &mut [Node<C>], len: &mut usize, index: usize, node: Node<C>) {
    nodes.copy_within(index..*len, index + 1);
    nodes[index] = node;
    *len += 1;
}

/// Multiplies the curve of the first `len` nodes by a blocker. Adds nodes where
/// it begins and ends, unless there are some: two at most, for which there must
/// be room.
#[inline]
pub(crate) fn insert<L: Rules, const C: usize>(
    nodes: &mut [Node<C>],
    len: &mut usize,
    segment: &Segment<C>,
) {
    let (entry, exit) = (segment.entry(), segment.exit());
    // The last node that is not behind the entry, made to be at the entry.
    let mut first = count_in_front(|index| nodes[index].depth, *len, entry);
    let at = |nodes: &[Node<C>], len: usize, index: usize, depth: f32| {
        index < len && nodes[index].depth == depth
    };
    let there = at(nodes, *len, first, entry);
    let step = there && at(nodes, *len, first + 1, entry);
    if !there {
        let node = on_the_curve::<L, C>(&nodes[..*len], first, entry);
        place(nodes, len, first, node);
    }
    // The first node that gets all of it, made to be at the exit.
    let after = if exit > entry {
        first += usize::from(step);
        let after = count_in_front(|index| nodes[index].depth, *len, exit);
        if !at(nodes, *len, after, exit) {
            let node = on_the_curve::<L, C>(&nodes[..*len], after, exit);
            place(nodes, len, after, node);
        }
        after
    } else {
        if !step {
            let node = nodes[first];
            place(nodes, len, first, node);
        }
        first + 1
    };
    L::attenuate(&mut nodes[first..*len], after - first, segment);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_levels_find_what_one_level_finds() {
        let depths = [1.0_f32, 2.0, 2.0, 3.0, 5.0, 8.0, 8.0, 9.0, 9.5, 11.0, 12.0];
        for len in 0..=depths.len() {
            for depth in [0.0, 1.0, 1.5, 2.0, 2.5, 8.0, 8.5, 9.2, 11.0, 12.0, 13.0] {
                let plain = depths[..len].iter().filter(|&&d| d < depth).count();
                let found = count_in_front(|index| depths[index], len, depth);
                assert_eq!(found, plain, "{depth} in {len}");
            }
            assert_eq!(count_in_front(|index| depths[index], len, f32::NAN), 0);
        }
    }
}

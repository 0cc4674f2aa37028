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

/// The smaller of two numbers: one instruction, where [`f32::min`] also has an
/// answer for NaN.
#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Share of the way from `from` to `to` at which `depth` lies. In f64 neither
/// the depths of f32 nor their differences can overflow or get lost.
#[inline]
pub(crate) fn fraction(from: f32, to: f32, depth: f32) -> f64 {
    let from = f64::from(from);
    let length = f64::from(to) - from;
    let fraction = (f64::from(depth) - from) / length;
    // Computed in any case: a branch costs more than a division.
    if length != 0.0 { fraction } else { 0.0 }
}

/// `from + (to − from) · fraction`, rounded once, and never beyond `to`.
#[inline]
pub(crate) fn mix(from: f32, to: f32, fraction: f64) -> f32 {
    let mixed = (f64::from(from) + (f64::from(to) - f64::from(from)) * fraction) as f32;
    smaller(larger(mixed, smaller(from, to)), larger(from, to))
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

/// Moves the nodes from `start` to `end` back by `by` places.
#[inline(always)]
fn move_back<const C: usize>(nodes: &mut [Node<C>], start: usize, end: usize, by: usize) {
    // The few nodes of a curve are moved before a call to do it has begun.
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
    segment: &Segment<C>,
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
        // The last node that is not behind the entry, and the first that gets all.
        first += usize::from(is_step);
        after += added;
    } else {
        // A step: what is in front of it, and what is behind.
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
    /// Up to this number, looking at all is as fast.
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

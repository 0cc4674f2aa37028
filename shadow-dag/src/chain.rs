//! An order of masks in which many follow the one that they follow along the
//! light.
//!
//! The masks of a tile lose cells from one to the next, and the same ones
//! follow each other in many tiles. Where the second has the next number, the
//! packed form need not store it.

use crate::pool::{Children, Reference, is_mixed};

/// New numbers for `masks` masks, by their old ones, given the slice nodes.
///
/// The most frequent pairs of neighbours become neighbours in number, as long
/// as each has one neighbour on either side. For masks that only lose cells, so
/// that none comes back and no circle needs to be cut, at least half as many
/// pairs are neighbours as there can be; for others, a third.
pub(crate) fn order(masks: usize, nodes: &[Children]) -> Vec<Reference> {
    let mut pairs: Vec<[Reference; 2]> = Vec::new();
    for children in nodes {
        let neighbours = children.windows(2).map(|pair| [pair[0], pair[1]]);
        pairs.extend(neighbours.filter(|[a, b]| is_mixed(*a) && is_mixed(*b) && a != b));
    }
    pairs.sort_unstable();
    let mut counted: Vec<(usize, [Reference; 2])> = (pairs.chunk_by(|a, b| a == b))
        .map(|same| (same.len(), same[0]))
        .collect();
    counted.sort_unstable_by_key(|&(count, pair)| (std::cmp::Reverse(count), pair));

    const NONE: Reference = Reference::MAX;
    let mut next = vec![NONE; masks];
    let mut is_first = vec![true; masks];
    // The other end of the chain, for either end of one.
    let mut other_end: Vec<Reference> = (0..masks as Reference).collect();
    for (_, [a, b]) in counted {
        let (tail, head) = (a as usize, b as usize);
        // Joined to itself a chain would have no beginning.
        if next[tail] == NONE && is_first[head] && other_end[tail] != b {
            next[tail] = b;
            is_first[head] = false;
            let (first, last) = (other_end[tail], other_end[head]);
            other_end[first as usize] = last;
            other_end[last as usize] = first;
        }
    }
    let mut names = vec![0; masks];
    let mut name = 0;
    for first in (0..masks).filter(|&mask| is_first[mask]) {
        let mut mask = first as Reference;
        while mask != NONE {
            names[mask as usize] = name;
            name += 1;
            mask = next[mask as usize];
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pool::{LIT, SHADOWED};
    use proptest::prelude::*;

    /// Few enough for all of their orders.
    const MASKS: u32 = 5;

    fn nodes() -> impl Strategy<Value = Vec<Children>> {
        let child = prop_oneof![4 => 0..MASKS, 1 => Just(LIT), 1 => Just(SHADOWED)];
        proptest::collection::vec(proptest::array::uniform8(child), 0..20)
    }

    /// How many pairs in `nodes` are neighbours in number.
    fn weight(nodes: &[Children], names: &[Reference]) -> usize {
        let pairs = nodes.iter().flat_map(|children| children.windows(2));
        let named = |mask: Reference| names.get(mask as usize).copied();
        pairs
            .filter(|pair| match (named(pair[0]), named(pair[1])) {
                (Some(a), Some(b)) => a + 1 == b,
                _ => false,
            })
            .count()
    }

    /// The most of all orders of the masks from `first` on.
    fn most(nodes: &[Children], names: &mut [Reference; MASKS as usize], first: usize) -> usize {
        let mut found = weight(nodes, names);
        for other in first..names.len() {
            names.swap(first, other);
            found = found.max(most(nodes, names, first + 1));
            names.swap(first, other);
        }
        found
    }

    proptest! {
        #![proptest_config(reference::property::cases(256))]

        #[test]
        fn every_mask_has_a_number_and_many_pairs_are_neighbours(mut nodes in nodes()) {
            let all = [0, 1, 2, 3, 4];
            let names = order(all.len(), &nodes);
            let (found, best) = (weight(&nodes, &names), most(&nodes, &mut all.clone(), 0));
            prop_assert!(3 * found >= best, "{} of {}", found, best);
            let mut sorted = names;
            sorted.sort_unstable();
            prop_assert_eq!(&sorted, &all);
            // No mask comes back.
            for children in &mut nodes {
                children.sort_unstable();
            }
            let names = order(all.len(), &nodes);
            let (found, best) = (weight(&nodes, &names), most(&nodes, &mut all.clone(), 0));
            prop_assert!(2 * found >= best, "{} of {}", found, best);
        }
    }

    #[test]
    fn chains_are_numbered_through_and_circles_cut() {
        let node = |a, b, c| [LIT, a, b, c, c, SHADOWED, SHADOWED, SHADOWED];
        // 0, then 2, then 3 before 1 before 4.
        assert_eq!(order(5, &[node(3, 1, 4)]), [0, 3, 1, 2, 4]);
        // The rarest pair of 0, 1, 2, 0, … is left out.
        let circle = [node(0, 1, 2), node(1, 2, 0), node(1, 2, 0)];
        assert_eq!(order(3, &circle), [2, 0, 1]);
    }
}

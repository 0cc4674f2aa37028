//! Removal of nodes one after the other, the cheapest first.
//!
//! A node takes about 100 cycles, which are one chain: the least key says which node
//! goes, its neighbours' new areas take two divisions behind each other, and these
//! are the next keys to choose from. The bounds of the stretch that is left are
//! computed beside it.

use crate::joined::joined;
use crate::lookup::Rules;
use crate::metric::Cost;
use crate::node::Node;
use crate::numeric::{larger, smaller};

/// The largest number of nodes that a working curve can have.
pub(crate) const MOST_NODES: usize = 256;

/// The bits of a key that hold the node's number in place of the lowest bits of its cost. Such
/// keys are floats that compare as the costs do, so that one minimum, which takes an instruction
/// for four, finds the least cost and its node at once.
const NUMBER: u32 = MOST_NODES as u32 - 1;

/// The key of nodes that must not be removed.
const NONE: f32 = f32::MAX;

/// Removes inner nodes from the first `len` until at most `keep` are left; the
/// first and the last stay, and no node moves. Returns how many are left.
///
/// `nodes` has room for `W × N`, of which the first `room` may be in use, so that
/// everything here has a fixed size.
#[inline(always)]
pub(crate) fn remove<L: Rules, M: Cost, const C: usize, const N: usize, const W: usize>(
    nodes: &mut [[Node<C>; N]; W],
    room: usize,
    len: usize,
    keep: usize,
) -> usize {
    if len <= keep {
        return len;
    }
    let nodes = &mut nodes.as_flattened_mut()[..room];
    let mut transmittance = [[[0.0; C]; N]; W];
    let transmittance = &mut transmittance.as_flattened_mut()[..room];
    for (transmittance, node) in transmittance.iter_mut().zip(&*nodes) {
        *transmittance = node.value.map(L::transmittance);
    }
    let mut keys = M::of_each::<L, C, N, W>(nodes, transmittance, len);
    let keys = &mut keys.as_flattened_mut()[..room];
    for (q, key) in keys.iter_mut().enumerate() {
        let is_inner = (q as u32).wrapping_sub(1) < len as u32 - 2;
        *key = if is_inner { key_of(*key, q) } else { NONE };
    }
    if len - keep <= 2 {
        return remove_few::<L, M, C>(nodes, transmittance, keys, len, keep);
    }
    let (mut previous, mut next) = ([[0_u8; N]; W], [[0_u8; N]; W]);
    let (previous, next) = (previous.as_flattened_mut(), next.as_flattened_mut());
    for index in 1..len {
        previous[index] = (index - 1) as u8;
        next[index - 1] = index as u8;
    }
    let mut least_of_all = least(keys);
    for _ in keep..len {
        let q = number(least_of_all);
        let (p, n) = (usize::from(previous[q]), usize::from(next[q]));
        // The least of the other keys is found while the new costs of the neighbours are
        // computed.
        for index in [p, q, n] {
            keys[index] = NONE;
        }
        let others = least(keys);
        nodes_joined::<L, C>(nodes, [p, q, n]);
        let around = [usize::from(previous[p]), p, n, usize::from(next[n])];
        let [front, back] = M::of_two::<L, C>(
            around.map(|index| &nodes[index]),
            around.map(|index| transmittance[index]),
        );
        next[p] = n as u8;
        previous[n] = p as u8;
        let front = if p > 0 { key_of(front, p) } else { NONE };
        let back = if n + 1 < len { key_of(back, n) } else { NONE };
        (keys[p], keys[n]) = (front, back);
        least_of_all = smaller(others, smaller(front, back));
    }
    let mut index = 0;
    for kept in 0..keep {
        nodes[kept] = nodes[index];
        index = usize::from(next[index]);
    }
    keep
}

/// Removes one or two nodes, which is what each blocker of a curve without spare room takes. It
/// does without the links that many nodes need, and no branch depends on which nodes they are.
#[inline(always)]
fn remove_few<L: Rules, M: Cost, const C: usize>(
    nodes: &mut [Node<C>],
    transmittance: &[[f32; C]],
    keys: &[f32],
    len: usize,
    keep: usize,
) -> usize {
    let q = number(least(keys));
    nodes_joined::<L, C>(nodes, [q - 1, q, q + 1]);
    let mut removed = [q, len];
    if len - keep == 2 {
        // The removed node and its neighbours are left out here instead of in memory, because
        // numbers that were just written are slow to read as vectors.
        let others = least_key(keys, |index, key| {
            let is_near = (index as u32 + 1).wrapping_sub(q as u32) <= 2;
            if is_near { NONE } else { key }
        });
        let around = [q.saturating_sub(2), q - 1, q + 1, (q + 2).min(len - 1)];
        let [front, back] = M::of_two::<L, C>(
            around.map(|index| &nodes[index]),
            around.map(|index| transmittance[index]),
        );
        // Keys are not negative, so that they compare as integers as they do as floats, and
        // one is chosen without a branch.
        let [front, back] =
            [(front, q - 1), (back, q + 1)].map(|(cost, q)| key_of(cost, q).to_bits());
        let front = if q > 1 { front } else { u32::MAX };
        let back = if q + 2 < len { back } else { u32::MAX };
        let r = number(f32::from_bits(others.to_bits().min(front).min(back)));
        let p = r - 1 - usize::from(r - 1 == q);
        let n = r + 1 + usize::from(r + 1 == q);
        nodes_joined::<L, C>(nodes, [p, r, n]);
        removed = [q.min(r), q.max(r)];
    }
    for place in 0..keep {
        let by = usize::from(place >= removed[0]) + usize::from(place + 1 >= removed[1]);
        nodes[place] = nodes[place + by];
    }
    keep
}

#[inline(always)]
fn key_of(cost: f32, node: usize) -> f32 {
    // NaN counts as a cost of 0, infinity as the largest cost.
    let cost = smaller(larger(cost, 0.0), NONE);
    f32::from_bits((cost.to_bits() & !NUMBER) | node as u32)
}

/// The node of a key.
#[inline(always)]
fn number(key: f32) -> usize {
    (key.to_bits() & NUMBER) as usize
}

/// The least key.
#[inline(always)]
fn least(keys: &[f32]) -> f32 {
    least_key(keys, |_, key| key)
}

/// The least of the keys after `change`, four at a time.
#[inline(always)]
fn least_key(keys: &[f32], change: impl Fn(usize, f32) -> f32) -> f32 {
    let (fours, rest) = keys.as_chunks::<4>();
    let mut least = [NONE; 4];
    for (index, four) in fours.iter().enumerate() {
        let changed: [f32; 4] = std::array::from_fn(|lane| change(4 * index + lane, four[lane]));
        least = std::array::from_fn(|lane| smaller(least[lane], changed[lane]));
    }
    let [a, b, c, d] = least;
    let least = smaller(smaller(a, b), smaller(c, d));
    let rest = rest.iter().enumerate();
    rest.fold(least, |least, (lane, &key)| {
        smaller(least, change(4 * fours.len() + lane, key))
    })
}

/// Gives the first of three nodes the bounds that it has without the second.
#[inline(always)]
fn nodes_joined<L: Rules, const C: usize>(nodes: &mut [Node<C>], [p, q, n]: [usize; 3]) {
    let (above, below) = joined::<L, C>(&nodes[p], &nodes[q], &nodes[n]);
    (nodes[p].above, nodes[p].below) = (above, below);
}

//! Removal of nodes one after the other, the cheapest first.

use crate::lookup::Rules;
use crate::metric::{Cost, joined};
use crate::node::Node;

/// The largest number of nodes that a working curve can have.
pub(crate) const MOST_NODES: usize = 256;

/// What finds the least cost: the cost in the high bits, so that integers
/// compare as costs do, and the node's number in the low ones.
const NUMBER: i32 = MOST_NODES as i32 - 1;

/// Removes inner nodes from the first `len` until at most `keep` are left; the
/// first and the last stay, and no node moves. Returns how many are left.
///
/// `nodes` has room for `W × N`, so that everything here has a fixed size.
pub(crate) fn remove<L: Rules, M: Cost, const C: usize, const N: usize, const W: usize>(
    nodes: &mut [[Node<C>; N]; W],
    len: usize,
    keep: usize,
) -> usize {
    if len <= keep {
        return len;
    }
    let nodes = nodes.as_flattened_mut();
    let mut transmittance = [[[0.0; C]; N]; W];
    let transmittance = transmittance.as_flattened_mut();
    for (transmittance, node) in transmittance.iter_mut().zip(&*nodes) {
        *transmittance = node.value.map(L::transmittance);
    }
    let mut keys = [[i32::MAX; N]; W];
    if len - keep <= 2 {
        for q in 1..len - 1 {
            let around = [q - 1, q, q + 1];
            keys.as_flattened_mut()[q] = key::<L, M, C>(nodes, transmittance, around);
        }
        return remove_few::<L, M, C, N, W>(nodes, transmittance, &mut keys, len, keep);
    }
    let costs = M::of_each::<L, C, N, W>(nodes, transmittance, len);
    let each = keys.as_flattened_mut().iter_mut().zip(costs.as_flattened());
    for (q, (key, &cost)) in each.enumerate() {
        let inner = 0 < q && q + 1 < len;
        *key = if inner { key_of(cost, q) } else { i32::MAX };
    }
    let (mut previous, mut next) = ([[0_u8; N]; W], [[0_u8; N]; W]);
    let (previous, next) = (previous.as_flattened_mut(), next.as_flattened_mut());
    for index in 1..len {
        previous[index] = (index - 1) as u8;
        next[index - 1] = index as u8;
    }
    for _ in keep..len {
        let q = least(&keys);
        let (p, n) = (usize::from(previous[q]), usize::from(next[q]));
        nodes_joined(nodes, [p, q, n]);
        let keys = keys.as_flattened_mut();
        keys[q] = i32::MAX;
        next[p] = n as u8;
        previous[n] = p as u8;
        if p > 0 {
            keys[p] = key::<L, M, C>(nodes, transmittance, [usize::from(previous[p]), p, n]);
        }
        if n + 1 < len {
            keys[n] = key::<L, M, C>(nodes, transmittance, [p, n, usize::from(next[n])]);
        }
    }
    let mut index = 0;
    for kept in 0..keep {
        nodes[kept] = nodes[index];
        index = usize::from(next[index]);
    }
    keep
}

/// One or two nodes, without the links that many need: what every blocker of a
/// curve without spare room comes to.
#[inline(always)]
fn remove_few<L: Rules, M: Cost, const C: usize, const N: usize, const W: usize>(
    nodes: &mut [Node<C>],
    transmittance: &[[f32; C]],
    keys: &mut [[i32; N]; W],
    len: usize,
    keep: usize,
) -> usize {
    let q = least(keys);
    nodes_joined(nodes, [q - 1, q, q + 1]);
    if len - keep == 1 {
        nodes.copy_within(q + 1..len, q);
        return keep;
    }
    let flat = keys.as_flattened_mut();
    flat[q] = i32::MAX;
    if q > 1 {
        flat[q - 1] = key::<L, M, C>(nodes, transmittance, [q - 2, q - 1, q + 1]);
    }
    if q + 2 < len {
        flat[q + 1] = key::<L, M, C>(nodes, transmittance, [q - 1, q + 1, q + 2]);
    }
    let r = least(keys);
    let (p, n) = (
        r - 1 - usize::from(r - 1 == q),
        r + 1 + usize::from(r + 1 == q),
    );
    nodes_joined(nodes, [p, r, n]);
    let (a, b) = (q.min(r), q.max(r));
    nodes.copy_within(a + 1..b, a);
    nodes.copy_within(b + 1..len, b - 1);
    keep
}

/// The key of the middle one of three nodes.
#[inline(always)]
fn key<L: Rules, M: Cost, const C: usize>(
    nodes: &[Node<C>],
    transmittance: &[[f32; C]],
    around: [usize; 3],
) -> i32 {
    let cost = M::of_removal::<L, C>(
        around.map(|index| &nodes[index]),
        around.map(|index| transmittance[index]),
    );
    key_of(cost, around[1])
}

#[inline]
fn key_of(cost: f32, node: usize) -> i32 {
    // A cost that is not a number counts as none.
    (cost.max(0.0).to_bits() as i32 & !NUMBER) | node as i32
}

/// The node of the least key.
#[inline]
fn least<const N: usize, const W: usize>(keys: &[[i32; N]; W]) -> usize {
    let least = keys
        .as_flattened()
        .iter()
        .fold(i32::MAX, |least, &key| least.min(key));
    (least & NUMBER) as usize
}

/// Gives the first of three nodes the bounds that it has without the second.
#[inline]
fn nodes_joined<const C: usize>(nodes: &mut [Node<C>], [p, q, n]: [usize; 3]) {
    let (above, below) = joined(&nodes[p], &nodes[q], &nodes[n]);
    (nodes[p].above, nodes[p].below) = (above, below);
}

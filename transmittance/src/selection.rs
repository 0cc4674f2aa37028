//! The best subset of a working curve's nodes, by dynamic programming.
//!
//! Removing one node after the other is near-sighted: a node that was cheap to
//! remove makes its neighbours dear. From a few dozen nodes the subset of least
//! total cost can be had at once, because the cost of a stretch depends on its
//! two ends only:
//!
//! ```text
//! best(s, j) = min over i < j of best(s − 1, i) + cost(i, j)
//! ```

use crate::joined::widen;
use crate::lookup::Rules;
use crate::metric::Cost;
use crate::node::Node;

/// Keeps `N` of the first `len` nodes, or all if there are fewer: the first,
/// the last, and those between that cost least together. Returns how many are
/// left.
///
/// Of the order of `len³` operations.
pub(crate) fn select<L: Rules, M: Cost, const C: usize, const N: usize, const W: usize>(
    nodes: &mut [[Node<C>; N]; W],
    len: usize,
) -> usize {
    if len <= N {
        return len;
    }
    let nodes = &mut nodes.as_flattened_mut()[..len];
    let columns = Columns::<C, N, W>::new::<L>(nodes);
    // best[s][j]: least cost of a curve from the first node to node j by way
    // of s nodes between, and the last of those.
    let mut best = [[[f32::INFINITY; N]; W]; N];
    let mut from = [[[0_u32; N]; W]; N];
    let mut costs = [[0.0_f32; N]; W];
    // This many nodes are left out, at most all of them in one stretch.
    let left_out = len - N;
    for i in 0..len - 1 {
        let ends = i + 1..len.min(i + left_out + 2);
        columns.costs::<L, M>(i, ends.end, costs.as_flattened_mut());
        let costs = &costs.as_flattened()[ends.clone()];
        // The places in the chosen curve that node i can have.
        let first_place = i.saturating_sub(left_out).max(usize::from(i > 0));
        for place in first_place..(i + 1).min(N - 1) {
            let so_far = match place.checked_sub(1) {
                Some(before) => best[before].as_flattened()[i],
                None => 0.0,
            };
            let best = &mut best[place].as_flattened_mut()[ends.clone()];
            let from = &mut from[place].as_flattened_mut()[ends.clone()];
            for ((best, from), &cost) in best.iter_mut().zip(from).zip(costs) {
                let cost = M::both(so_far, cost);
                let better = cost < *best;
                *best = if better { cost } else { *best };
                *from = if better { i as u32 } else { *from };
            }
        }
    }
    let mut chosen = [len - 1; N];
    chosen[0] = 0;
    for place in (1..N - 1).rev() {
        chosen[place] = from[place].as_flattened()[chosen[place + 1]] as usize;
    }
    for place in 0..N {
        let mut node = nodes[chosen[place]];
        if place + 1 < N {
            widen::<L, C>(&nodes[chosen[place]..=chosen[place + 1]], &mut node);
        }
        nodes[place] = node;
    }
    N
}

/// The nodes, one quantity after the other.
struct Columns<const C: usize, const N: usize, const W: usize> {
    /// A quarter of the depth: differences cannot overflow.
    depth: [[f32; N]; W],
    /// Half of the distance between a node's neighbours.
    share: [[f32; N]; W],
    value: [[[f32; N]; W]; C],
    transmittance: [[[f32; N]; W]; C],
    /// Bounds of a stretch.
    above: [[[f32; N]; W]; C],
    below: [[[f32; N]; W]; C],
}

impl<const C: usize, const N: usize, const W: usize> Columns<C, N, W> {
    fn new<L: Rules>(nodes: &[Node<C>]) -> Self {
        let mut columns = Self {
            depth: [[0.0; N]; W],
            share: [[0.0; N]; W],
            value: [[[0.0; N]; W]; C],
            transmittance: [[[0.0; N]; W]; C],
            above: [[[0.0; N]; W]; C],
            below: [[[0.0; N]; W]; C],
        };
        for (index, node) in nodes.iter().enumerate() {
            columns.depth.as_flattened_mut()[index] = 0.25 * node.depth;
            for c in 0..C {
                columns.value[c].as_flattened_mut()[index] = node.value[c];
                columns.transmittance[c].as_flattened_mut()[index] =
                    L::transmittance(node.value[c]);
                columns.above[c].as_flattened_mut()[index] = node.above[c];
                columns.below[c].as_flattened_mut()[index] = node.below[c];
            }
        }
        for index in 1..nodes.len() - 1 {
            let depth = columns.depth.as_flattened();
            columns.share.as_flattened_mut()[index] = 0.5 * (depth[index + 1] - depth[index - 1]);
        }
        columns
    }

    /// Cost of the stretches from node `i` to each node behind it. Rows of
    /// independent lanes, one per end, so that they vectorise.
    fn costs<L: Rules, M: Cost>(&self, i: usize, len: usize, costs: &mut [f32]) {
        let depth = self.depth.as_flattened();
        let share = self.share.as_flattened();
        costs[i + 1..len].fill(0.0);
        let mut inverse = [[0.0_f32; N]; W];
        let inverse = inverse.as_flattened_mut();
        for j in i + 1..len {
            // A stretch of no length has nothing inside.
            inverse[j] = (depth[j] - depth[i]).max(f32::MIN_POSITIVE).recip();
        }
        for c in 0..C {
            let value = self.value[c].as_flattened();
            let transmittance = self.transmittance[c].as_flattened();
            let (above, below) = (self.above[c].as_flattened(), self.below[c].as_flattened());
            let (mut most, mut least) = ([[above[i]; N]; W], [[below[i]; N]; W]);
            let (most, least) = (most.as_flattened_mut(), least.as_flattened_mut());
            for x in i + 1..len - 1 {
                let way = depth[x] - depth[i];
                let ends = x + 1..len;
                let chords = value[ends.clone()].iter().zip(&inverse[ends.clone()]);
                let chords = chords
                    .map(|(&end, &inverse)| value[i] + (end - value[i]) * (way * inverse).min(1.0));
                if M::WEIGHS_AREA {
                    for (cost, chord) in costs[ends].iter_mut().zip(chords) {
                        *cost += share[x] * (transmittance[x] - L::transmittance(chord)).abs();
                    }
                } else {
                    let (up, down) = (above[x - 1].max(above[x]), below[x - 1].max(below[x]));
                    let bounds = most[ends.clone()].iter_mut().zip(&mut least[ends]);
                    for ((most, least), chord) in bounds.zip(chords) {
                        let height = value[x] - chord;
                        *most = most.max(up + height.max(0.0));
                        *least = least.max(down + (-height).max(0.0));
                    }
                }
            }
            if !M::WEIGHS_AREA {
                for j in i + 1..len {
                    let ends = [transmittance[i], transmittance[j]];
                    costs[j] = costs[j].max(L::spread(ends, least[j], most[j]));
                }
            }
        }
    }
}

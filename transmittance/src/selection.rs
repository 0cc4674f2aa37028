//! The best subset of a working curve's nodes, by dynamic programming.
//!
//! Removing one node after the other is short-sighted: a node that was cheap to
//! remove makes its neighbours expensive. From a few dozen nodes the subset of least
//! total cost can be found directly, because the cost of a stretch depends only on its
//! two ends:
//!
//! ```text
//! best(s, j) = min over i < j of best(s − 1, i) + cost(i, j)
//! ```
//!
//! Arithmetic binds this: a node inside four stretches takes four exponentials, which
//! are some 40 vector instructions. Nothing leaves the first-level cache.

use std::array::from_fn;
use std::ops::Range;

use wide::{CmpGt, CmpLt, f32x4};

use crate::joined::widen;
use crate::lookup::Rules;
use crate::metric::Cost;
use crate::node::Node;

/// Ends of stretches that are priced together.
const LANES: usize = 4;

/// After every so many nodes of a stretch it is checked whether it costs too much already.
const LOOKS: usize = 4;

/// Stretches from a node to so many times [`LANES`] ends are short.
const SHORT: usize = 2;

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
    let chosen = choose::<L, M, C, N, W>(&Columns::new::<L>(nodes), len);
    for place in 0..N {
        let mut node = nodes[chosen[place]];
        if place + 1 < N {
            widen::<L, C>(&nodes[chosen[place]..=chosen[place + 1]], &mut node);
        }
        nodes[place] = node;
    }
    N
}

/// The nodes that are left.
fn choose<L: Rules, M: Cost, const C: usize, const N: usize, const W: usize>(
    columns: &Columns<C, N, W>,
    len: usize,
) -> [usize; N] {
    let mut paths = Paths::<N, W>::new(len);
    // The area of a stretch is a sum of positive terms. Once the best curve of short stretches
    // is known, the sum for a long stretch can therefore end where any curve with it would cost
    // more.
    let mut short = [[[f32x4::ZERO; SHORT]; N]; W];
    let ends_early = if M::WEIGHS_AREA { len - 1 } else { 0 };
    let short = &mut short.as_flattened_mut()[..ends_early];
    for (i, all) in short.iter_mut().enumerate() {
        for (costs, first) in all.iter_mut().zip(paths.firsts(i)) {
            *costs = columns.costs::<L, M>(i, first, len, [0.0, f32::INFINITY]);
            paths.extend::<M>(i, first, *costs);
        }
    }
    let most = paths.total();
    paths = Paths::new(len);
    for i in 0..len - 1 {
        let so_far = paths.least_to(i);
        let known = short.get(i).map_or(&[][..], |all| all);
        for (four, first) in paths.firsts(i).enumerate() {
            let costs = match known.get(four) {
                Some(costs) => *costs,
                None => columns.costs::<L, M>(i, first, len, [so_far, most]),
            };
            paths.extend::<M>(i, first, costs);
        }
    }
    paths.chosen()
}

/// The best curves from the first node to each node, by how many nodes they have.
struct Paths<const N: usize, const W: usize> {
    len: usize,
    /// `best[s][j]`: least cost of a curve from the first node to node j by way of s
    /// nodes between.
    best: [[[f32; N]; W]; N],
    /// The last of those nodes.
    from: [[[f32; N]; W]; N],
}

impl<const N: usize, const W: usize> Paths<N, W> {
    #[inline(always)]
    fn new(len: usize) -> Self {
        Self {
            len,
            best: [[[f32::INFINITY; N]; W]; N],
            from: [[[0.0; N]; W]; N],
        }
    }

    /// The last end of a stretch from node `i`, by which all nodes that are to be left
    /// out are.
    fn farthest(&self, i: usize) -> usize {
        (i + self.len - N + 1).min(self.len - 1)
    }

    /// The first of each of the ends of stretches from node `i` that are priced together.
    fn firsts(&self, i: usize) -> impl Iterator<Item = usize> + use<N, W> {
        (i + 1..self.farthest(i) + 1).step_by(LANES)
    }

    /// The places in the chosen curve that node `i` can have.
    fn places(&self, i: usize) -> Range<usize> {
        i.saturating_sub(self.len - N).max(usize::from(i > 0))..(i + 1).min(N - 1)
    }

    /// Least cost of a curve from the first node to node `i` at one of its places.
    fn to(&self, i: usize, place: usize) -> f32 {
        match place.checked_sub(1) {
            Some(before) => self.best[before].as_flattened()[i],
            None => 0.0,
        }
    }

    /// Least cost of a curve from the first node to node `i`.
    fn least_to(&self, i: usize) -> f32 {
        let costs = self.places(i).map(|place| self.to(i, place));
        costs.fold(f32::INFINITY, f32::min)
    }

    /// Cost of the best curve to the last node.
    fn total(&self) -> f32 {
        self.best[N - 2].as_flattened()[self.len - 1]
    }

    /// Goes on from node `i` to the nodes from `first` on, at these costs.
    #[inline(always)]
    fn extend<M: Cost>(&mut self, i: usize, first: usize, costs: f32x4) {
        let last = f32x4::splat(self.farthest(i) as f32);
        let beyond = numbers(first).cmp_gt(last);
        let costs = beyond.blend(f32x4::splat(f32::INFINITY), costs);
        for place in self.places(i) {
            let so_far = f32x4::splat(self.to(i, place));
            let best = &mut self.best[place].as_flattened_mut()[first..];
            let from = &mut self.from[place].as_flattened_mut()[first..];
            let cost = M::both(so_far, costs);
            if let (Some(best), Some(from)) = (best.first_chunk_mut(), from.first_chunk_mut()) {
                let (old, old_from) = (f32x4::from(*best), f32x4::from(*from));
                let better = cost.cmp_lt(old);
                *best = better.blend(cost, old).to_array();
                *from = better.blend(f32x4::splat(i as f32), old_from).to_array();
            } else {
                for ((best, from), cost) in best.iter_mut().zip(from).zip(cost.to_array()) {
                    if cost < *best {
                        (*best, *from) = (cost, i as f32);
                    }
                }
            }
        }
    }

    /// The nodes of the best curve to the last node.
    fn chosen(&self) -> [usize; N] {
        let mut chosen = [self.len - 1; N];
        chosen[0] = 0;
        for place in (1..N - 1).rev() {
            chosen[place] = self.from[place].as_flattened()[chosen[place + 1]] as usize;
        }
        chosen
    }
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

    /// Costs of the stretches from node `i` to the nodes from `first` on; those to nodes behind
    /// the last of `len` mean nothing. If each of the areas exceeds `most` together with
    /// `so_far`, they may be too small, but still exceed it.
    #[inline(always)]
    fn costs<L: Rules, M: Cost>(
        &self,
        i: usize,
        first: usize,
        len: usize,
        [so_far, most]: [f32; 2],
    ) -> f32x4 {
        let [so_far, most_in_all] = [so_far, most].map(f32x4::splat);
        let depth = self.depth.as_flattened();
        let share = self.share.as_flattened();
        // A stretch of no length has nothing inside.
        let length = lanes(depth, first) - f32x4::splat(depth[i]);
        let inverse = f32x4::splat(1.0) / length.fast_max(f32x4::splat(f32::MIN_POSITIVE));
        let number = numbers(first);
        let mut costs = f32x4::ZERO;
        for c in 0..C {
            let value = self.value[c].as_flattened();
            let transmittance = self.transmittance[c].as_flattened();
            let (above, below) = (self.above[c].as_flattened(), self.below[c].as_flattened());
            let start = f32x4::splat(value[i]);
            let rise = lanes(value, first) - start;
            let (mut most, mut least) = (f32x4::splat(above[i]), f32x4::splat(below[i]));
            for x in i + 1..(first + LANES - 1).min(len - 1) {
                let way = (f32x4::splat(depth[x] - depth[i]) * inverse).fast_min(f32x4::splat(1.0));
                let chord = start + rise * way;
                // Only stretches that end behind the node contain it.
                let counts = number.cmp_gt(f32x4::splat(x as f32));
                if M::WEIGHS_AREA {
                    let off = f32x4::splat(transmittance[x]) - L::transmittances(chord);
                    costs += (f32x4::splat(share[x]) * off.abs()) & counts;
                    if x % LOOKS == 0 && (so_far + costs).cmp_gt(most_in_all).all() {
                        return costs;
                    }
                } else {
                    let (up, down) = (above[x - 1].max(above[x]), below[x - 1].max(below[x]));
                    let height = f32x4::splat(value[x]) - chord;
                    let up = f32x4::splat(up) + height.fast_max(f32x4::ZERO);
                    let down = f32x4::splat(down) + (-height).fast_max(f32x4::ZERO);
                    most = most.fast_max(up & counts);
                    least = least.fast_max(down & counts);
                }
            }
            if !M::WEIGHS_AREA {
                let (end, most, least) = (
                    lanes(transmittance, first),
                    most.to_array(),
                    least.to_array(),
                );
                let spread = |lane: usize| {
                    let ends = [transmittance[i], end.to_array()[lane]];
                    L::spread(ends, least[lane], most[lane])
                };
                costs = costs.fast_max(f32x4::from(from_fn(spread)));
            }
        }
        costs
    }
}

/// The numbers from `first` on.
#[inline(always)]
fn numbers(first: usize) -> f32x4 {
    f32x4::from(from_fn(|lane| (first + lane) as f32))
}

/// Entries of a column from `first` on; behind the last it is repeated.
#[inline(always)]
fn lanes(column: &[f32], first: usize) -> f32x4 {
    match column.get(first..first + LANES) {
        Some(lanes) => f32x4::from(from_fn(|lane| lanes[lane])),
        None => f32x4::from(from_fn(|lane| column[(first + lane).min(column.len() - 1)])),
    }
}

#[cfg(test)]
mod tests {
    use reference::random::Random;

    use super::*;
    use crate::{Area, Exponential, Linear, Maximum};

    /// Nodes of a curve that falls in steps of all sizes, some of them at one depth.
    fn nodes(random: &mut Random, len: usize) -> [[Node<1>; 8]; 4] {
        let mut nodes = [[Node::UNUSED; 8]; 4];
        let (mut depth, mut value) = (0.0, 0.0);
        for node in &mut nodes.as_flattened_mut()[..len] {
            let bounds = [random.unit(), random.unit()].map(|bound| 1e-3 * bound);
            *node = Node {
                depth,
                value: [value],
                above: [bounds[0]],
                below: [bounds[1]],
            };
            depth += (random.unit() * 8.0).floor() * random.unit();
            value += 0.3 * random.unit().powi(4);
        }
        nodes
    }

    /// Least cost of the curves that keep eight of the nodes, and cost of the chosen one.
    fn costs<L: Rules, M: Cost>(nodes: &[Node<1>]) -> [f32; 2] {
        let len = nodes.len();
        let columns = Columns::<1, 8, 4>::new::<L>(nodes);
        let of_stretch = |i: usize, j: usize| {
            columns
                .costs::<L, M>(i, j, len, [0.0, f32::INFINITY])
                .to_array()[0]
        };
        let of_stretches: Vec<Vec<f32>> = (0..len)
            .map(|i| {
                (0..len)
                    .map(|j| if i < j { of_stretch(i, j) } else { 0.0 })
                    .collect()
            })
            .collect();
        let cost = |kept: &[usize]| {
            kept.windows(2).fold(0.0, |so_far, ends| {
                let cost = of_stretches[ends[0]][ends[1]];
                M::both(f32x4::splat(so_far), f32x4::splat(cost)).to_array()[0]
            })
        };
        let between = (0_u32..1 << (len - 2)).filter(|between| between.count_ones() == 6);
        let least = between.map(|between| {
            let is_kept = |&i: &usize| i == 0 || i == len - 1 || between >> (i - 1) & 1 == 1;
            cost(&(0..len).filter(is_kept).collect::<Vec<_>>())
        });
        let chosen = choose::<L, M, 1, 8, 4>(&columns, len);
        [least.fold(f32::INFINITY, f32::min), cost(&chosen)]
    }

    #[test]
    fn no_other_choice_costs_less() {
        let mut random = Random::new(4);
        for _ in 0..200 {
            let len = 9 + random.below(5) as usize;
            let nodes = nodes(&mut random, len);
            let nodes = &nodes.as_flattened()[..len];
            for [least, chosen] in [
                costs::<Exponential, Area>(nodes),
                costs::<Exponential, Maximum>(nodes),
            ] {
                assert_eq!(chosen, least);
            }
        }
    }

    /// Stretches from the first node into the cluster cost more than the best curve,
    /// and the one past it, which is longer, is part of that curve.
    #[test]
    fn areas_need_not_grow_with_the_stretch() {
        let nodes = [
            (0.0, 1.0),
            (50.0, 0.5),
            (50.001, 0.13),
            (50.002, 0.125),
            (50.003, 0.12),
            (50.004, 0.115),
            (50.005, 0.11),
            (50.006, 0.105),
            (50.007, 0.1),
            (90.0, 0.1),
            (3090.0, 0.099),
            (23_090.0, 0.098),
            (23_095.0, 0.097),
            (43_095.0, 0.077),
            (63_095.0, 0.067),
            (63_105.0, 0.047),
        ]
        .map(|(depth, transmittance)| Node {
            depth,
            value: [transmittance],
            above: [0.0],
            below: [0.0],
        });
        let [least, chosen] = costs::<Linear, Area>(&nodes);
        assert_eq!(chosen, least);
    }
}

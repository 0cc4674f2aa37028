//! What a removed node costs.

use std::fmt::Debug;

use crate::joined::joined;
use crate::lookup::Rules;
use crate::node::Node;

/// What is kept small when nodes are removed: [`Area`] or [`Maximum`].
pub trait Metric: Cost {}

/// The area between the curves before and after, as in the paper: keeps the
/// mean error small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Area;

/// The bound of the error on the stretch that the removal leaves: keeps the
/// largest error small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Maximum;

impl Metric for Area {}
impl Metric for Maximum {}

/// Distance from one node to another, a quarter of it: sums of such lengths
/// times transmittances cannot overflow.
#[inline]
pub(crate) fn quarter<const C: usize>(from: &Node<C>, to: &Node<C>) -> f32 {
    0.25 * to.depth - 0.25 * from.depth
}

/// The arithmetic behind [`Metric`].
pub trait Cost: Debug + Clone + Copy + Default + PartialEq + Send + Sync + 'static {
    /// The same for shaders.
    #[cfg(feature = "wgsl")]
    const WGSL: &'static str;

    /// What it costs to remove the middle one of three nodes, whose
    /// transmittances are given.
    fn of_removal<L: Rules, const C: usize>(
        nodes: [&Node<C>; 3],
        transmittance: [[f32; C]; 3],
    ) -> f32;

    /// [`Cost::of_removal`] of each inner node of the first `len`, at its index;
    /// what is at other indices means nothing.
    fn of_each<L: Rules, const C: usize, const N: usize, const W: usize>(
        nodes: &[[Node<C>; N]; W],
        transmittance: &[[[f32; C]; N]; W],
        len: usize,
    ) -> [[f32; N]; W];

    /// The cost of two stretches or channels together.
    fn both(a: f32, b: f32) -> f32;

    /// Whether the cost of a stretch is the area that its inner nodes have been
    /// cut from; else it is the bound of its error.
    const WEIGHS_AREA: bool;
}

impl Cost for Area {
    #[cfg(feature = "wgsl")]
    const WGSL: &'static str = include_str!("gpu/area.wgsl");

    #[inline]
    fn of_removal<L: Rules, const C: usize>(
        [p, q, n]: [&Node<C>; 3],
        [at_p, at_q, at_n]: [[f32; C]; 3],
    ) -> f32 {
        let widths = [quarter(p, q), quarter(q, n)];
        let mut cost = 0.0;
        for c in 0..C {
            let values = [p.value[c], q.value[c], n.value[c]];
            cost += L::area(widths, values, [at_p[c], at_q[c], at_n[c]]);
        }
        cost
    }

    #[inline(always)]
    fn of_each<L: Rules, const C: usize, const N: usize, const W: usize>(
        nodes: &[[Node<C>; N]; W],
        transmittance: &[[[f32; C]; N]; W],
        _: usize,
    ) -> [[f32; N]; W] {
        // One quantity after the other and all of the capacity, used or not, so that it
        // vectorises.
        let (nodes, transmittance) = (nodes.as_flattened(), transmittance.as_flattened());
        let mut costs = [[0.0; N]; W];
        let mut depth = [[0.0_f32; N]; W];
        for (depth, node) in depth.as_flattened_mut().iter_mut().zip(nodes) {
            *depth = 0.25 * node.depth;
        }
        let d = depth.as_flattened();
        for c in 0..C {
            let (mut value, mut t) = ([[0.0_f32; N]; W], [[0.0_f32; N]; W]);
            for (value, node) in value.as_flattened_mut().iter_mut().zip(nodes) {
                *value = node.value[c];
            }
            for (t, transmittance) in t.as_flattened_mut().iter_mut().zip(transmittance) {
                *t = transmittance[c];
            }
            let (v, t) = (value.as_flattened(), t.as_flattened());
            let costs = costs.as_flattened_mut();
            for q in 1..N * W - 1 {
                let (p, n) = (q - 1, q + 1);
                let widths = [d[q] - d[p], d[n] - d[q]];
                costs[q] += L::area(widths, [v[p], v[q], v[n]], [t[p], t[q], t[n]]);
            }
        }
        costs
    }

    #[inline]
    fn both(a: f32, b: f32) -> f32 {
        a + b
    }

    const WEIGHS_AREA: bool = true;
}

impl Cost for Maximum {
    #[cfg(feature = "wgsl")]
    const WGSL: &'static str = include_str!("gpu/maximum.wgsl");

    #[inline]
    fn of_removal<L: Rules, const C: usize>(
        [p, q, n]: [&Node<C>; 3],
        [at_p, _, at_n]: [[f32; C]; 3],
    ) -> f32 {
        let (above, below) = joined::<L, C>(p, q, n);
        let mut cost = 0.0_f32;
        for c in 0..C {
            cost = cost.max(L::spread([at_p[c], at_n[c]], below[c], above[c]));
        }
        cost
    }

    fn of_each<L: Rules, const C: usize, const N: usize, const W: usize>(
        nodes: &[[Node<C>; N]; W],
        transmittance: &[[[f32; C]; N]; W],
        len: usize,
    ) -> [[f32; N]; W] {
        let (nodes, transmittance) = (nodes.as_flattened(), transmittance.as_flattened());
        let mut costs = [[0.0; N]; W];
        for q in 1..len - 1 {
            let around = [q - 1, q, q + 1];
            costs.as_flattened_mut()[q] = Self::of_removal::<L, C>(
                around.map(|index| &nodes[index]),
                around.map(|index| transmittance[index]),
            );
        }
        costs
    }

    #[inline]
    fn both(a: f32, b: f32) -> f32 {
        a.max(b)
    }

    const WEIGHS_AREA: bool = false;
}

//! The cost of removing a node.

use std::fmt::Debug;

use wide::f32x4;

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

/// The arithmetic behind [`Metric`].
pub trait Cost: Debug + Clone + Copy + Default + PartialEq + Send + Sync + 'static {
    /// The same for shaders.
    #[cfg(feature = "wgsl")]
    const WGSL: &'static str;

    /// The costs of removing the second and the third of four nodes, whose transmittances are
    /// given.
    fn of_two<L: Rules, const C: usize>(
        nodes: [&Node<C>; 4],
        transmittance: [[f32; C]; 4],
    ) -> [f32; 2];

    /// The cost of removing each inner node of the first `len`, at its index; values at other
    /// indices mean nothing.
    fn of_each<L: Rules, const C: usize, const N: usize, const W: usize>(
        nodes: &[Node<C>],
        transmittance: &[[f32; C]],
        len: usize,
    ) -> [[f32; N]; W];

    /// The costs of two stretches together.
    fn both(a: f32x4, b: f32x4) -> f32x4;

    /// Whether the cost of a stretch is the area that its inner nodes have been
    /// cut from; else it is the bound of its error.
    const WEIGHS_AREA: bool;
}

impl Cost for Area {
    #[cfg(feature = "wgsl")]
    const WGSL: &'static str = include_str!("gpu/area.wgsl");

    #[inline(always)]
    fn of_two<L: Rules, const C: usize>(
        nodes: [&Node<C>; 4],
        transmittance: [[f32; C]; 4],
    ) -> [f32; 2] {
        // Both at once.
        let triple = |x: [f32; 4]| {
            let lanes = |front, back| f32x4::from([front, back, front, back]);
            [lanes(x[0], x[1]), lanes(x[1], x[2]), lanes(x[2], x[3])]
        };
        let [p, q, n] = triple(nodes.map(|node| 0.25 * node.depth));
        let mut costs = f32x4::ZERO;
        for c in 0..C {
            let values = triple(nodes.map(|node| node.value[c]));
            let transmittances = triple(transmittance.map(|transmittance| transmittance[c]));
            costs += L::area([q - p, n - q], values, transmittances);
        }
        let [front, back, ..] = costs.to_array();
        [front, back]
    }

    #[inline(always)]
    fn of_each<L: Rules, const C: usize, const N: usize, const W: usize>(
        nodes: &[Node<C>],
        transmittance: &[[f32; C]],
        _: usize,
    ) -> [[f32; N]; W] {
        // One quantity after the other and all of the capacity, used or not, so that it
        // vectorises.
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
            for q in 1..nodes.len() - 1 {
                let (p, n) = (q - 1, q + 1);
                let widths = [d[q] - d[p], d[n] - d[q]];
                costs[q] += L::area(widths, [v[p], v[q], v[n]], [t[p], t[q], t[n]]);
            }
        }
        costs
    }

    #[inline]
    fn both(a: f32x4, b: f32x4) -> f32x4 {
        a + b
    }

    const WEIGHS_AREA: bool = true;
}

impl Cost for Maximum {
    #[cfg(feature = "wgsl")]
    const WGSL: &'static str = include_str!("gpu/maximum.wgsl");

    #[inline]
    fn of_two<L: Rules, const C: usize>(
        nodes: [&Node<C>; 4],
        transmittance: [[f32; C]; 4],
    ) -> [f32; 2] {
        let [a, b, c, d] = nodes;
        let [at_a, at_b, at_c, at_d] = transmittance;
        [
            Self::of_removal::<L, C>([a, b, c], [at_a, at_c]),
            Self::of_removal::<L, C>([b, c, d], [at_b, at_d]),
        ]
    }

    fn of_each<L: Rules, const C: usize, const N: usize, const W: usize>(
        nodes: &[Node<C>],
        transmittance: &[[f32; C]],
        len: usize,
    ) -> [[f32; N]; W] {
        let mut costs = [[0.0; N]; W];
        for q in 1..len - 1 {
            costs.as_flattened_mut()[q] = Self::of_removal::<L, C>(
                [q - 1, q, q + 1].map(|index| &nodes[index]),
                [q - 1, q + 1].map(|index| transmittance[index]),
            );
        }
        costs
    }

    #[inline]
    fn both(a: f32x4, b: f32x4) -> f32x4 {
        a.fast_max(b)
    }

    const WEIGHS_AREA: bool = false;
}

impl Maximum {
    /// The cost of removing the middle one of three nodes; the transmittances of the outer ones
    /// are given.
    #[inline]
    fn of_removal<L: Rules, const C: usize>(
        [p, q, n]: [&Node<C>; 3],
        [at_p, at_n]: [[f32; C]; 2],
    ) -> f32 {
        let (above, below) = joined::<L, C>(p, q, n);
        let mut cost = 0.0_f32;
        for c in 0..C {
            cost = cost.max(L::spread([at_p[c], at_n[c]], below[c], above[c]));
        }
        cost
    }
}

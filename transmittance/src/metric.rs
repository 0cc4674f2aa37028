//! What a removed node costs.

use std::fmt::Debug;

use crate::lookup::Rules;
use crate::node::{Node, fraction};

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

/// The bounds of a stretch from which the inner node `q` is removed.
#[inline]
pub(crate) fn joined<const C: usize>(
    p: &Node<C>,
    q: &Node<C>,
    n: &Node<C>,
) -> ([f32; C], [f32; C]) {
    // An ULP for the rounding of the height and one for that of the sum.
    const UP: f32 = 1.000_000_4;
    let fraction = fraction(p.depth, n.depth, q.depth);
    let (mut above, mut below) = ([0.0; C], [0.0; C]);
    for c in 0..C {
        let height = (f64::from(q.value[c])
            - f64::from(p.value[c])
            - (f64::from(n.value[c]) - f64::from(p.value[c])) * fraction)
            as f32;
        above[c] = (p.above[c].max(q.above[c]) + height.max(0.0)) * UP;
        below[c] = (p.below[c].max(q.below[c]) + (-height).max(0.0)) * UP;
    }
    (above, below)
}

/// The arithmetic behind [`Metric`].
pub trait Cost: Debug + Clone + Copy + Default + PartialEq + Send + Sync + 'static {
    /// What it costs to remove the middle one of three nodes, whose
    /// transmittances are given.
    fn of_removal<L: Rules, const C: usize>(
        nodes: [&Node<C>; 3],
        transmittance: [[f32; C]; 3],
    ) -> f32;

    /// The cost of two stretches or channels together.
    fn both(a: f32, b: f32) -> f32;

    /// Whether the cost of a stretch is the area that its inner nodes have been
    /// cut from; else it is the bound of its error.
    const WEIGHS_AREA: bool;
}

impl Cost for Area {
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

    #[inline]
    fn both(a: f32, b: f32) -> f32 {
        a + b
    }

    const WEIGHS_AREA: bool = true;
}

impl Cost for Maximum {
    #[inline]
    fn of_removal<L: Rules, const C: usize>(
        [p, q, n]: [&Node<C>; 3],
        [at_p, _, at_n]: [[f32; C]; 3],
    ) -> f32 {
        let (above, below) = joined(p, q, n);
        let mut cost = 0.0_f32;
        for c in 0..C {
            cost = cost.max(L::spread([at_p[c], at_n[c]], below[c], above[c]));
        }
        cost
    }

    #[inline]
    fn both(a: f32, b: f32) -> f32 {
        a.max(b)
    }

    const WEIGHS_AREA: bool = false;
}

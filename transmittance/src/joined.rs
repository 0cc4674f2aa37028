//! The bounds of a stretch from which nodes are removed.
//!
//! Without an inner node the stored curve runs along the chord of its
//! neighbours. What it moves by on the way is added to the bounds (see
//! [`certificate`](crate::certificate)), on the side on which the node lay.
//!
//! Where optical depths reach [`Rules::DARK`], depths beyond do not count: a wall
//! is an optical depth of 1e30, and its rounding alone would be a bound of
//! 1e22 on the stretches around it. What is kept for an exact optical depth `e`
//! and a stored one `v` is
//!
//! ```text
//! e ≥ min(v, DARK) − below    and    min(e, DARK) ≤ v + above
//! ```
//!
//! and both survive adding the same to `e` and `v`. `below` need not hold
//! between the first end of a stretch and the next float, where nothing can be
//! asked; at the first end itself the chord is no deeper than the curve was.

use crate::lookup::Rules;
use crate::node::Node;
use crate::numeric::{fraction, larger};

/// An ULP for the rounding of a height and one for that of the sum.
const UP: f32 = 1.000_000_4;

/// The bounds above and below of a stretch from which the inner node `q` is
/// removed.
#[inline]
pub(crate) fn joined<L: Rules, const C: usize>(
    p: &Node<C>,
    q: &Node<C>,
    n: &Node<C>,
) -> ([f32; C], [f32; C]) {
    let fraction = fraction(p.depth, n.depth, q.depth);
    let (mut above, mut below) = ([0.0; C], [0.0; C]);
    for c in 0..C {
        if n.value[c] > L::DARK {
            [above[c], below[c]] = in_the_dark::<L, C>([p, q, n].into_iter(), c);
            continue;
        }
        let height = (f64::from(q.value[c])
            - f64::from(p.value[c])
            - (f64::from(n.value[c]) - f64::from(p.value[c])) * fraction)
            as f32;
        above[c] = (larger(p.above[c], q.above[c]) + larger(height, 0.0)) * UP;
        below[c] = (larger(p.below[c], q.below[c]) + larger(-height, 0.0)) * UP;
    }
    (above, below)
}

/// The bounds of a stretch from the first to the last of `nodes` that leaves
/// out those between, into `node`.
pub(crate) fn widen<L: Rules, const C: usize>(nodes: &[Node<C>], node: &mut Node<C>) {
    let (first, last) = (&nodes[0], &nodes[nodes.len() - 1]);
    for c in 0..C {
        if last.value[c] > L::DARK {
            [node.above[c], node.below[c]] = in_the_dark::<L, C>(nodes.iter(), c);
            continue;
        }
        let height = |index: usize| {
            if index == 0 || index + 1 == nodes.len() {
                return 0.0;
            }
            let q = &nodes[index];
            let rise = f64::from(last.value[c]) - f64::from(first.value[c]);
            let fraction = fraction(first.depth, last.depth, q.depth);
            (f64::from(q.value[c]) - f64::from(first.value[c]) - rise * fraction) as f32
        };
        let (mut above, mut below, mut left) = (0.0_f32, 0.0_f32, 0.0_f32);
        for (index, stretch) in nodes.iter().enumerate().take(nodes.len() - 1) {
            let right = height(index + 1);
            above = above.max((stretch.above[c] + left.max(right).max(0.0)) * UP);
            below = below.max((stretch.below[c] + (-left.min(right)).max(0.0)) * UP);
            left = right;
        }
        (node.above[c], node.below[c]) = (above, below);
    }
}

/// The bounds above and below, in one channel, of a stretch that leaves out all
/// but the first and the last of `nodes`, where the last is dark.
#[cold]
fn in_the_dark<'a, L: Rules, const C: usize>(
    mut nodes: impl DoubleEndedIterator<Item = &'a Node<C>> + Clone,
    c: usize,
) -> [f32; 2] {
    let point = |node: &Node<C>| [f64::from(node.depth), f64::from(node.value[c])];
    let (Some(first), Some(last)) = (nodes.clone().next(), nodes.clone().next_back()) else {
        return [0.0; 2];
    };
    let asked_from = f64::from(first.depth.next_up());
    let chord = [point(first), point(last)];
    let (mut above, mut below) = (0.0_f32, 0.0_f32);
    let mut start = nodes.next();
    for end in nodes {
        if let Some(stretch) = start {
            let moved = moved(
                [point(stretch), point(end)],
                chord,
                asked_from,
                L::DARK.into(),
            );
            above = above.max((stretch.above[c] + moved[0]) * UP);
            below = below.max((stretch.below[c] + moved[1]) * UP);
        }
        start = Some(end);
    }
    [above, below]
}

/// How far a stretch lies above a chord at most, and how far below from the
/// depth `asked_from` on, with values beyond `dark` cut off.
fn moved([a, b]: [[f64; 2]; 2], [p, n]: [[f64; 2]; 2], asked_from: f64, dark: f64) -> [f32; 2] {
    let length = b[0] - a[0];
    if !(length > 0.0) {
        // No depth lies on it.
        return [0.0; 2];
    }
    // Distances are measured from the start of the stretch, beside which they may be small.
    let slope = (n[1] - p[1]) / (n[0] - p[0]);
    let chord = [p[1] + slope * (a[0] - p[0]), p[1] + slope * (b[0] - p[0])];
    let along = |ends: [f64; 2], way: f64| ends[0] + (ends[1] - ends[0]) * (way / length);
    let lies_above = |way: f64| along([a[1], b[1]], way).min(dark) - along(chord, way).min(dark);
    // Both are straight lines that are cut off at `dark`, so that the extremes of their
    // difference are at the ends and where one of them is cut off.
    let cut = |ends: [f64; 2]| {
        let way = length * ((dark - ends[0]) / (ends[1] - ends[0]));
        if way > 0.0 && way < length { way } else { 0.0 }
    };
    let ways = [0.0, length, cut([a[1], b[1]]), cut(chord)];
    let first_asked = (asked_from - a[0]).max(0.0);
    // 1e-12 makes up for the roundings here.
    let (mut above, mut below) = (1e-12_f64, 1e-12_f64);
    for way in ways {
        above = above.max(lies_above(way) + 1e-12);
        below = below.max(1e-12 - lies_above(way.max(first_asked)));
    }
    [above as f32, below as f32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Exponential, Linear};

    fn node(depth: f32, value: f32) -> Node<1> {
        Node {
            depth,
            value: [value],
            ..Node::UNUSED
        }
    }

    #[test]
    fn roundings_of_an_opaque_ramp_are_no_bound() {
        let ramp = [node(105.0, 0.5), node(107.0, 4e29), node(110.0, 1e30)];
        let off = node(107.0, 4e29 * (1.0 + 1e-6));
        for middle in [ramp[1], off] {
            let ([above], [below]) = joined::<Exponential, 1>(&ramp[0], &middle, &ramp[2]);
            assert!(above < 1e-3 && below < 1e-3, "{above:e} {below:e}");
        }
    }

    #[test]
    fn a_curve_that_turns_dark_too_early_is_bounded_by_the_dark() {
        // The chord is dark right behind 1, where the curve had 0.25.
        let nodes = [node(1.0, 0.25), node(2.0, 0.5), node(2.0, 1e30)];
        let ([above], [below]) = joined::<Exponential, 1>(&nodes[0], &nodes[1], &nodes[2]);
        assert!(above < 1e-6);
        assert!((below - 127.75).abs() < 1e-3, "{below}");
    }

    #[test]
    fn both_ways_of_removal_give_the_same_bounds() {
        for values in [[0.5, 0.75, 0.9], [0.5, 3.0, 200.0], [0.5, 150.0, 200.0]] {
            let nodes = [
                node(1.0, values[0]),
                node(2.0, values[1]),
                node(3.5, values[2]),
            ];
            let ([above], [below]) = joined::<Exponential, 1>(&nodes[0], &nodes[1], &nodes[2]);
            let mut wide = nodes[0];
            widen::<Exponential, 1>(&nodes, &mut wide);
            assert!((wide.above[0] - above).abs() <= 1e-6 * above, "{values:?}");
            assert!((wide.below[0] - below).abs() <= 1e-6 * below, "{values:?}");
        }
        // Transmittances are never dark.
        let nodes = [node(1.0, 1.0), node(2.0, 0.25), node(3.0, 0.0)];
        let (above, below) = joined::<Linear, 1>(&nodes[0], &nodes[1], &nodes[2]);
        assert_eq!((above, below), ([0.0], [0.25 * UP]));
    }
}

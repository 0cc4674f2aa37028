//! The upper bound of a curve's error.
//!
//! # What is carried
//!
//! Each stretch between two nodes carries how far the exact curve may lie above
//! and below the stored one (see [`Node`]), in the quantity that is interpolated:
//!
//! * A node that is added lies on the curve; both parts keep the bounds.
//! * Adding a blocker's optical depth changes the stored and the exact curve by
//!   the same linear function: [`Exponential`](crate::Exponential) bounds stay.
//!   Linear bounds shrink by what passes the blocker up to there, and grow by
//!   how far a product of chords is from the product.
//! * Removing a node `q` moves the stored curve by a tent whose height is `q`'s
//!   distance to the chord of its neighbours: the larger bound of the two parts,
//!   plus that height on the side on which `q` lay. Heights in the dark are cut
//!   off (see [`joined`](crate::joined)).
//!
//! Roundings of the values grow with the number of insertions, by a known share
//! of the final value for each, so that counting them is enough.
//!
//! # What is made of it
//!
//! On a stretch the exact transmittance is within these bounds, and because it
//! cannot rise, it is also at most what it is at the left end and at least what
//! it is at the right one, where the bounds of both neighbours hold.

use crate::lookup::Rules;
use crate::node::Node;
use crate::numeric::fraction;

/// The number of insertions of a curve that lacks some of its segments, or of
/// one that has more than can be counted.
pub(crate) const INCOMPLETE: u32 = u32::MAX;

/// Bound of the error on the stretch that ends at node `next`; the stretch of
/// number `nodes.len()` is what lies behind the last node.
///
/// [`INCOMPLETE`] insertions have a bound of 1 everywhere: what is lacking may
/// be in front of the first node, and the curve may have no node.
pub(crate) fn error_bound<L: Rules, const C: usize>(
    nodes: &[Node<C>],
    next: usize,
    insertions: u32,
) -> [f32; C] {
    if insertions == INCOMPLETE {
        return [1.0; C];
    }
    std::array::from_fn(|c| {
        let Some(first) = next.checked_sub(1) else {
            return 0.0;
        };
        let end = |index: usize| {
            // In front of the first and behind the last node there is no error
            // but rounding.
            let (mut below, mut above) = (0.0, 0.0);
            if index > 0 && index + 1 < nodes.len() {
                let (left, right) = (&nodes[index - 1], &nodes[index]);
                below = f64::from(left.below[c].min(right.below[c]));
                above = f64::from(left.above[c].min(right.above[c]));
            }
            L::range(nodes[index].value[c], below, above, insertions)
        };
        let last = next.min(nodes.len() - 1);
        let node = &nodes[first];
        // Only depths that are f32 can be asked. The first is the float behind the node, where
        // a stretch that leads into the dark has already fallen.
        let values = [node.value[c], nodes[last].value[c]].map(f64::from);
        let fraction = fraction(node.depth, nodes[last].depth, node.depth.next_up());
        let [from, to] = values;
        let values = if fraction < 1.0 {
            [from + (to - from) * fraction, to]
        } else {
            [to; 2]
        };
        let ends = [end(first), end(last)];
        let bound = L::error(values, node.below[c], node.above[c], ends, insertions);
        (bound as f32).next_up().min(1.0)
    })
}

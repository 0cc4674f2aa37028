//! Adaptive transmittance curves of at most `N` nodes.
//!
//! Based on: M. Salvi, K. Vidimče, A. Lauritzen, A. Lefohn, "Adaptive Volumetric
//! Shadow Maps", Eurographics Symposium on Rendering 2010.
//!
//! [`Curve::insert`] is the paper's algorithm: two nodes per blocker, the curve
//! multiplied by it, and then, one at a time, the inner node removed whose
//! removal changes the area under the curve least. Departures:
//!
//! * Exponential lookup has its own area (the paper takes trapezoids for both),
//!   and its nodes hold optical depths.
//! * Blockers that begin or end at a node add none there, so that coincident
//!   surfaces and touching voxels use up no capacity.
//! * A surface is a step of two nodes at one depth, instead of a thin slab.
//! * Every stretch carries a bound of its error.
//!
//! An insertion takes about 370 cycles with 8 nodes and 500 with 16. No memory
//! binds it but a chain: where the ends lie, the values there (a division in f64), the
//! product, the areas, the least of them twice, each with a division for the bound,
//! and nodes that are moved as a whole, so that the next insertion waits for bounds.

use std::marker::PhantomData;

use crate::certificate;
use crate::insertion::{insert, multiply};
use crate::lookup::{Exponential, Lookup};
use crate::metric::Area;
use crate::node::{Node, count_in_front};
use crate::numeric::{fraction, mix};
use crate::removal::{MOST_NODES, remove};
use crate::{Accumulate, BlockerSegment, Evaluate};

/// Transmittance along a light ray, in at most `N` nodes and `C` channels that
/// share the depths of the nodes.
///
/// The curve is 1 in front of the first node, never rises, and ends with the
/// product of all blockers. Nodes lie where blockers began or ended. As long as
/// no node had to be removed, an [`Exponential`] curve is exact but for
/// rounding. Everything is of fixed size; `N` is from 2 to 64.
///
/// ```
/// use transmittance::{Curve, BlockerSegment};
///
/// let mut curve = Curve::<8>::new();
/// curve.insert(&BlockerSegment::from_density(1.0, 3.0, 0.5)?); // smoke
/// curve.insert(&BlockerSegment::surface(2.0, 0.25)?); // a leaf inside of it
/// assert_eq!(curve.transmittance(1.0), 1.0);
/// let behind = curve.transmittance(10.0);
/// assert!((behind - 0.25 * (-1.0_f32).exp()).abs() <= curve.error_bound(10.0));
/// assert_eq!(curve.depth_at(0.3), 2.0);
/// # Ok::<(), transmittance::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curve<const N: usize, L = Exponential, const C: usize = 1> {
    nodes: [Node<C>; N],
    len: u32,
    insertions: u32,
    lookup: PhantomData<L>,
}

impl<const N: usize, L: Lookup, const C: usize> Default for Curve<N, L, C> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize, L: Lookup, const C: usize> Curve<N, L, C> {
    /// Room for a curve and two more nodes, in whole vectors of four.
    const ROOM: usize = {
        let vectors = (N + 2).next_multiple_of(4);
        if vectors < 2 * N { vectors } else { 2 * N }
    };

    /// A clear ray.
    #[must_use]
    pub fn new() -> Self {
        const { assert!(N >= 2 && N <= MOST_NODES / 4, "N is from 2 to 64") }
        Self {
            nodes: [Node::UNUSED; N],
            len: 0,
            insertions: 0,
            lookup: PhantomData,
        }
    }

    /// The first `len ≤ N` of `nodes`.
    pub(crate) fn from_nodes(nodes: &[Node<C>], insertions: u32) -> Self {
        let mut curve = Self::new();
        curve.nodes[..nodes.len()].copy_from_slice(nodes);
        curve.len = nodes.len() as u32;
        curve.insertions = insertions;
        curve
    }

    pub(crate) fn insertions(&self) -> u32 {
        self.insertions
    }

    pub(crate) fn nodes(&self) -> &[Node<C>] {
        &self.nodes[..self.len as usize]
    }

    /// Adds a blocker by the paper's rule. A clear one changes nothing.
    #[inline]
    pub fn insert(&mut self, segment: &BlockerSegment<C>) {
        if segment.is_clear() {
            return;
        }
        // Two nodes more than N, where N ≥ 2, fit into 2 N.
        let mut room = [self.nodes, [Node::UNUSED; N]];
        let mut len = self.len as usize;
        insert::<L, C>(room.as_flattened_mut(), &mut len, segment);
        len = remove::<L, Area, C, N, 2>(&mut room, Self::ROOM, len, N);
        self.nodes = room[0];
        self.len = len as u32;
        self.insertions = self.insertions.saturating_add(1);
    }

    /// The curve of what blocks this one and what blocks `other`: their product
    /// at every depth, reduced to `N` nodes by the paper's rule.
    #[must_use]
    pub fn merged(&self, other: &Self) -> Self {
        let mut room = [[Node::UNUSED; N]; 2];
        let mut scratch = [[Node::UNUSED; N]; 2];
        let len = multiply::<L, C>(
            self.nodes(),
            other.nodes(),
            room.as_flattened_mut(),
            scratch.as_flattened_mut(),
        );
        let len = remove::<L, Area, C, N, 2>(&mut room, 2 * N, len, N);
        // Each factor has its own roundings; the product rounds once more, and
        // so does a node that one of them lacked.
        let insertions = self.insertions.saturating_add(other.insertions);
        Self::from_nodes(&room[0][..len], insertions.saturating_add(1))
    }

    /// Share of the light that gets as far as `depth`, per channel.
    ///
    /// What is exactly at `depth` casts no shadow on it. A depth of NaN counts
    /// as in front of everything.
    #[must_use]
    #[inline]
    pub fn transmittances(&self, depth: f32) -> [f32; C] {
        let nodes = self.nodes();
        let Some(last) = nodes.len().checked_sub(1) else {
            return [1.0; C];
        };
        let next = count_in_front(|index| nodes[index].depth, nodes.len(), depth);
        // In front of the first node, which is clear, and behind the last one, both nodes are
        // the same, so that its value comes out without a branch.
        let (node, next) = (&nodes[next.saturating_sub(1)], &nodes[next.min(last)]);
        let fraction = fraction(node.depth, next.depth, depth);
        std::array::from_fn(|c| L::transmittance(L::mix(node.value[c], next.value[c], fraction)))
    }

    /// An upper bound of the error of [`Curve::transmittances`] at `depth`, per
    /// channel, all roundings included. The truth is the product of the
    /// segments' own transmittances (see [`BlockerSegment`]). It is 1 at all depths if
    /// the curve lacks segments, as one that a GPU made of more than its lists
    /// promised.
    #[must_use]
    pub fn error_bounds(&self, depth: f32) -> [f32; C] {
        let nodes = self.nodes();
        let next = count_in_front(|index| nodes[index].depth, nodes.len(), depth);
        certificate::error_bound::<L, C>(nodes, next, self.insertions)
    }

    /// An upper bound of the error at all depths and in all channels.
    #[must_use]
    pub fn max_error_bound(&self) -> f32 {
        if self.insertions == certificate::INCOMPLETE {
            return 1.0;
        }
        let nodes = self.nodes();
        (1..=nodes.len())
            // No depth lies between two nodes at the same depth.
            .filter(|&next| next == nodes.len() || nodes[next].depth > nodes[next - 1].depth)
            .flat_map(|next| certificate::error_bound::<L, C>(nodes, next, self.insertions))
            .fold(0.0, f32::max)
    }

    /// Depth and transmittances of each node, from front to back.
    pub fn points(&self) -> impl ExactSizeIterator<Item = (f32, [f32; C])> {
        let transmittances = |node: &Node<C>| (node.depth, node.value.map(L::transmittance));
        self.nodes().iter().map(transmittances)
    }
}

impl<const N: usize, L: Lookup> Curve<N, L> {
    /// [`Curve::transmittances`] of the only channel.
    #[must_use]
    #[inline]
    pub fn transmittance(&self, depth: f32) -> f32 {
        self.transmittances(depth)[0]
    }

    /// [`Curve::error_bounds`] of the only channel.
    #[must_use]
    pub fn error_bound(&self, depth: f32) -> f32 {
        self.error_bounds(depth)[0]
    }

    /// How far at least the share `transmittance` of the light gets: the
    /// largest float at which [`Curve::transmittance`] is not below it. Infinite
    /// if the curve never falls below it, and for NaN; −∞ for more than 1.
    #[must_use]
    pub fn depth_at(&self, transmittance: f32) -> f32 {
        if transmittance > 1.0 {
            return f32::NEG_INFINITY;
        }
        let nodes = self.nodes();
        let below = |node: &Node<1>| L::transmittance(node.value[0]) < transmittance;
        let Some(next) = nodes.iter().position(below) else {
            return f32::INFINITY;
        };
        // `next` is not the first node, whose transmittance is 1, because what is sought is at
        // most 1.
        let (front, back) = (&nodes[next - 1], &nodes[next]);
        let share = fraction(front.value[0], back.value[0], L::value(transmittance));
        let guess = mix(front.depth, back.depth, share.clamp(0.0, 1.0));
        // The guess is rounded, and a stretch may be a single float long: the
        // lookup itself decides between the floats around it.
        last_float([front.depth, back.depth], guess, |depth| {
            let fraction = fraction(front.depth, back.depth, depth);
            L::transmittance(L::mix(front.value[0], back.value[0], fraction)) >= transmittance
        })
    }
}

/// The last float for which `holds`, which does so at the first of `ends` and no
/// longer at the second; found fastest if it is within a few floats of `guess`.
fn last_float(ends: [f32; 2], guess: f32, holds: impl Fn(f32) -> bool) -> f32 {
    /// How far beside a guess the answer usually is, floats.
    const NEAR: i64 = 3;
    // Integers that are ordered as floats are, and back.
    let flipped = |bits: i32| bits ^ (((bits >> 31) as u32) >> 1) as i32;
    let key = |x: f32| i64::from(flipped(x.to_bits() as i32));
    let float = |key: i64| f32::from_bits(flipped(key as i32) as u32);
    let [mut last, mut end] = ends.map(key);
    let mut beside = [key(guess) + NEAR, key(guess) - NEAR].into_iter();
    while end - last > 1 {
        let inside = |at: &i64| last < *at && *at < end;
        let middle = last + (end - last) / 2;
        let at = beside.next().filter(inside).unwrap_or(middle);
        if holds(float(at)) {
            last = at;
        } else {
            end = at;
        }
    }
    float(last)
}

impl<const N: usize, L: Lookup, const C: usize> Evaluate<C> for Curve<N, L, C> {
    fn evaluate(&self, depth: f32) -> [f32; C] {
        self.transmittances(depth)
    }
}

impl<const N: usize, L: Lookup, const C: usize> Accumulate<C> for Curve<N, L, C> {
    type Curve = Self;

    fn insert(&mut self, segment: &BlockerSegment<C>) {
        Curve::insert(self, segment);
    }

    fn finish(self) -> Self {
        self
    }
}

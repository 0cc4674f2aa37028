//! Curves from a working curve of more nodes than are kept.
//!
//! The paper removes down to `N` nodes after every blocker, and what it removes
//! early may turn out to have mattered. Here a working curve of up to `W × N`
//! nodes takes the blockers; each time it is full, the `3 N / 4` nodes that cost
//! least are removed, and at the end the best subset of at most `N` is found by
//! dynamic programming. Memory is fixed as before, and the error comes close to
//! that of the best subset of all nodes.

use std::marker::PhantomData;

use crate::insertion::insert;
use crate::lookup::{Exponential, Lookup};
use crate::metric::{Area, Metric};
use crate::node::Node;
use crate::removal::{MOST_NODES, remove};
use crate::selection::select;
use crate::{Accumulate, BlockerSegment, Curve};

/// Makes a [`Curve`] of `N` nodes from a stream of blockers in any order.
///
/// * `M`: [`Area`] for the least mean error, [`Maximum`](crate::Maximum) for the
///   least largest error;
/// * `L`: [`Exponential`] or [`Linear`](crate::Linear) curves;
/// * `C`: colour channels that share the nodes;
/// * `W`: the room, in multiples of `N`: from 2 to 256 / N.
///
/// ```
/// use transmittance::{Maximum, BlockerSegment, Stream};
///
/// let mut stream = Stream::<4, Maximum>::new();
/// for puff in 0..100 {
///     let centre = 0.5 * puff as f32;
///     stream.insert(&BlockerSegment::from_density(centre - 2.0, centre + 2.0, 0.01)?);
/// }
/// let curve = stream.finish();
/// let exact = (-2.0_f32).exp(); // half of the smoke
/// assert!((curve.transmittance(24.75) - exact).abs() <= curve.error_bound(24.75));
/// assert!(curve.max_error_bound() < 0.05);
/// # Ok::<(), transmittance::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Stream<const N: usize, M = Area, L = Exponential, const C: usize = 1, const W: usize = 4>
{
    nodes: [[Node<C>; N]; W],
    len: u32,
    insertions: u32,
    rules: PhantomData<(M, L)>,
}

impl<const N: usize, M: Metric, L: Lookup, const C: usize, const W: usize> Default
    for Stream<N, M, L, C, W>
{
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize, M: Metric, L: Lookup, const C: usize, const W: usize> Stream<N, M, L, C, W> {
    /// How many nodes are kept when the room is full. Removing `3 N / 4` at a time comes near
    /// the quality of removing one at a time at a third of the cost (tuned on smoke and hair,
    /// 8 and 16 nodes). A blocker needs room for two.
    const REFILL: usize = W * N - if N < 4 { 2 } else { 3 * N / 4 };

    /// A clear ray.
    #[must_use]
    pub fn new() -> Self {
        const {
            assert!(
                N >= 2 && W >= 2 && N * W <= MOST_NODES,
                "N and W are at least 2, N W at most 256"
            );
        }
        Self {
            nodes: [[Node::UNUSED; N]; W],
            len: 0,
            insertions: 0,
            rules: PhantomData,
        }
    }

    /// Adds a blocker. A clear one changes nothing.
    #[inline]
    pub fn insert(&mut self, segment: &BlockerSegment<C>) {
        if segment.is_clear() {
            return;
        }
        let mut len = self.len as usize;
        if len + 2 > W * N {
            len = remove::<L, M, C, N, W>(&mut self.nodes, W * N, len, Self::REFILL);
        }
        insert::<L, C>(self.nodes.as_flattened_mut(), &mut len, segment);
        self.len = len as u32;
        self.insertions = self.insertions.saturating_add(1);
    }

    /// The best curve of at most `N` nodes from what was kept.
    #[must_use]
    pub fn finish(mut self) -> Curve<N, L, C> {
        let len = remove::<L, M, C, N, W>(&mut self.nodes, W * N, self.len as usize, (W - 1) * N);
        let len = select::<L, M, C, N, W>(&mut self.nodes, len);
        Curve::from_nodes(&self.nodes[0][..len], self.insertions)
    }
}

impl<const N: usize, M: Metric, L: Lookup, const C: usize, const W: usize> Accumulate<C>
    for Stream<N, M, L, C, W>
{
    type Curve = Curve<N, L, C>;

    fn insert(&mut self, segment: &BlockerSegment<C>) {
        Stream::insert(self, segment);
    }

    fn finish(self) -> Self::Curve {
        Stream::finish(self)
    }
}

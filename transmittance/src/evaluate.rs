//! What every method offers: made from segments, asked at depths.

use crate::BlockerSegment;

/// Transmittance along one light ray, in `C` channels.
pub trait Evaluate<const C: usize = 1> {
    /// Share of the light that gets as far as `depth`, per channel, in [0, 1].
    ///
    /// What is exactly at `depth` casts no shadow on it. A depth of NaN counts
    /// as in front of everything.
    fn evaluate(&self, depth: f32) -> [f32; C];
}

/// Takes the segments along one light ray, in any order, and makes a curve.
pub trait Accumulate<const C: usize = 1> {
    /// What is made.
    type Curve: Evaluate<C>;

    /// Adds a blocker.
    fn insert(&mut self, segment: &BlockerSegment<C>);

    /// The curve of everything that was added.
    fn finish(self) -> Self::Curve;
}

/// Collects all segments and adds them from front to back: removes what is left
/// of the dependence on their order, for memory in proportion to their number.
///
/// Segments are ordered by entry, then exit, then optical depth, so that any
/// order of the same segments gives the same bits.
///
/// ```
/// use transmittance::{Accumulate, BlockerSegment, Sorted, Stream};
///
/// let mut sorted = Sorted::new(Stream::<8>::new());
/// for depth in [3.0, 1.0, 2.0] {
///     sorted.insert(&BlockerSegment::surface(depth, 0.5)?);
/// }
/// assert_eq!(sorted.finish().transmittance(2.5), 0.25);
/// # Ok::<(), transmittance::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Sorted<A, const C: usize = 1> {
    segments: Vec<BlockerSegment<C>>,
    accumulator: A,
}

impl<A, const C: usize> Sorted<A, C> {
    /// Hands the segments on to `accumulator` when all are there.
    pub fn new(accumulator: A) -> Self {
        Self {
            segments: Vec::new(),
            accumulator,
        }
    }
}

impl<const C: usize, A: Accumulate<C>> Accumulate<C> for Sorted<A, C> {
    type Curve = A::Curve;

    fn insert(&mut self, segment: &BlockerSegment<C>) {
        self.segments.push(*segment);
    }

    fn finish(mut self) -> A::Curve {
        self.segments.sort_by(|a, b| {
            let depths = a.entry().total_cmp(&b.entry());
            let depths = depths.then(a.exit().total_cmp(&b.exit()));
            let pairs = a.optical_depth().into_iter().zip(b.optical_depth());
            pairs.fold(depths, |order, (a, b)| order.then(a.total_cmp(&b)))
        });
        for segment in &self.segments {
            self.accumulator.insert(segment);
        }
        self.accumulator.finish()
    }
}

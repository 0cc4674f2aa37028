//! The values in nodes, and how a curve runs between two of them.

use std::fmt::Debug;

use wide::f32x4;

use crate::BlockerSegment;
use crate::node::Node;
use crate::numeric::{Number, mix};

/// How a curve runs between its nodes: [`Linear`] or [`Exponential`].
pub trait Lookup: Rules {}

/// Nodes hold transmittances, and transmittance is interpolated linearly: the
/// paper's first choice.
///
/// The product of two such curves is not one: each blocker that overlaps others
/// adds to the error, in an order-dependent way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Linear;

/// Nodes hold optical depths, which are interpolated linearly, so that
/// transmittance runs exponentially: the paper's second choice.
///
/// This is what a homogeneous blocker does. Sums of optical depths are exact,
/// so that only the removal of nodes costs accuracy; and where the paper's
/// transmittance of 0 makes everything in front of an opaque node black, up to
/// the node before it, an optical depth remembers what was there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Exponential;

impl Lookup for Linear {}
impl Lookup for Exponential {}

/// Half a unit in the last place of a number of size 1: the relative error of
/// one rounding to f32.
pub(crate) const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// Makes up for the roundings of a bound's own arithmetic in f32.
pub(crate) const INFLATE: f32 = 1.000_001;

/// The algebra behind [`Lookup`].
pub trait Rules: Debug + Clone + Copy + Default + PartialEq + Send + Sync + 'static {
    /// Value where nothing is in the way.
    const CLEAR: f32;

    /// Values from here on all count as opaque; infinite if none does.
    const DARK: f32;

    /// The same rules for shaders: of lookups, and of insertions.
    #[cfg(feature = "wgsl")]
    const WGSL: [&'static str; 2];

    /// Transmittance of a value.
    fn transmittance(value: f32) -> f32;

    /// [`Rules::transmittance`] of four values, with the same bits.
    fn transmittances(values: f32x4) -> f32x4;

    /// Value of a transmittance that is greater than 0.
    fn value(transmittance: f32) -> f32;

    /// A share of the way from one value to one behind it, and never beyond that.
    #[inline(always)]
    fn mix(from: f32, to: f32, fraction: f64) -> f32 {
        Self::first(mix(from, to, fraction), to)
    }

    /// Of two values the one that comes first along a curve.
    fn first(a: f32, b: f32) -> f32;

    /// Multiplies the curve by a segment. The first node is at its entry, the
    /// node `after` is at its exit.
    fn attenuate<const C: usize>(nodes: &mut [Node<C>], after: usize, segment: &BlockerSegment<C>);

    /// Multiplies a curve by another that has its nodes at the same depths.
    fn multiply<const C: usize>(nodes: &mut [Node<C>], other: &[Node<C>]);

    /// Area between the curve through three nodes and the curve through the
    /// outer two, from the lengths of the two stretches, and the values and the
    /// transmittances of the nodes.
    fn area<T: Number>(widths: [T; 2], values: [T; 3], transmittances: [T; 3]) -> T;

    /// Transmittances that the exact curve cannot leave on a stretch where it
    /// is within `below` and `above` of a value, as an error of transmittance.
    /// For choosing, not for certifying: nothing is rounded up.
    fn spread(transmittance: [f32; 2], below: f32, above: f32) -> f32;

    /// Bounds of the exact transmittance at a node of value `value` whose exact
    /// value is at most `below` less and `above` more, after `insertions`.
    fn range(value: f32, below: f64, above: f64, insertions: u32) -> [f64; 2];

    /// The largest error of the transmittance on a stretch. `values` are those
    /// that are interpolated at its two ends, `ends` the exact transmittances
    /// there as [`Rules::range`] gives them.
    fn error(values: [f64; 2], below: f32, above: f32, ends: [[f64; 2]; 2], insertions: u32)
    -> f64;
}

/// One over the length of a segment. In f64 neither can overflow; for a surface,
/// which has no inside, the result is of no use.
#[inline]
pub(crate) fn inverse_length<const C: usize>(segment: &BlockerSegment<C>) -> f64 {
    (f64::from(segment.exit()) - f64::from(segment.entry())).recip()
}

//! Which parts of text make a shader.

use super::constants::Sizes;
use crate::{Accumulate, Curve, Lookup, Metric, Packed, PackedHalf, Stored, Stream};

const NUMERIC: &str = include_str!("numeric.wgsl");
/// WGSL of a blocker. Needs the sizes.
pub(super) const SEGMENT: &str = include_str!("segment.wgsl");
const CURVE: &str = include_str!("curve.wgsl");
const LOOKUP: &str = include_str!("lookup.wgsl");
const FILTER: &str = include_str!("filter.wgsl");

/// A stored form of curves that shaders read and write.
pub trait WgslStored<const C: usize = 1>: Stored<C> {
    /// WGSL of `avsm_NODES` and `avsm_CHANNELS`.
    const SIZES: &'static str;

    /// WGSL of the rules of its [`Lookup`].
    const RULES: &'static str;

    /// WGSL that finds the numbers in the words.
    const LOAD: &'static str;

    /// WGSL that stores a curve, `avsm_store(texel, &curve)`.
    const STORE: &'static str;

    /// WGSL of `avsm_error_bounds`; nothing if bounds are not stored.
    const BOUNDS: &'static str = "";
}

impl<const N: usize, L: Lookup, const C: usize> WgslStored<C> for Curve<N, L, C> {
    const SIZES: &'static str = Sizes::<N, 0, C>::WGSL;
    const RULES: &'static str = L::WGSL[0];
    const LOAD: &'static str = include_str!("bounded.wgsl");
    const STORE: &'static str = include_str!("bounded_store.wgsl");
    const BOUNDS: &'static str = include_str!("certificate.wgsl");
}

impl<const N: usize, L: Lookup, const C: usize> WgslStored<C> for Packed<N, L, C> {
    const SIZES: &'static str = Sizes::<N, 0, C>::WGSL;
    const RULES: &'static str = L::WGSL[0];
    const LOAD: &'static str = include_str!("packed.wgsl");
    const STORE: &'static str = include_str!("packed_store.wgsl");
}

impl<const N: usize, L: Lookup, const C: usize> WgslStored<C> for PackedHalf<N, L, C> {
    const SIZES: &'static str = Sizes::<N, 0, C>::WGSL;
    const RULES: &'static str = L::WGSL[0];
    const LOAD: &'static str = include_str!("half.wgsl");
    const STORE: &'static str = include_str!("half_store.wgsl");
}

/// A rule by which shaders make curves.
pub trait WgslRule<const C: usize = 1>: Accumulate<C> {
    /// The capacity of a curve while it is made, in nodes.
    const CAPACITY: usize;

    /// WGSL of the sizes of a curve.
    const SIZES: &'static str;

    /// WGSL of the rules of its [`Lookup`], and of insertions by them.
    const RULES: [&'static str; 2];

    /// WGSL of what it costs to remove a node.
    const COST: &'static str;

    /// WGSL of `avsm_finish`.
    const FINISH: &'static str;

    /// Whether the end of a curve is so much work that it has a dispatch of its own.
    const FINISHES_APART: bool;
}

/// The paper's rule.
impl<const N: usize, L: Lookup, const C: usize> WgslRule<C> for Curve<N, L, C> {
    const CAPACITY: usize = Sizes::<N, 0, C>::CAPACITY;
    const SIZES: &'static str = Sizes::<N, 0, C>::WGSL;
    const RULES: [&'static str; 2] = L::WGSL;
    const COST: &'static str = include_str!("area.wgsl");
    const FINISH: &'static str = include_str!("finish.wgsl");
    const FINISHES_APART: bool = false;
}

/// Room for `W N` nodes, of which the best `N` are left at the end.
impl<const N: usize, M: Metric, L: Lookup, const C: usize, const W: usize> WgslRule<C>
    for Stream<N, M, L, C, W>
{
    const CAPACITY: usize = Sizes::<N, W, C>::CAPACITY;
    const SIZES: &'static str = Sizes::<N, W, C>::WGSL;
    const RULES: [&'static str; 2] = L::WGSL;
    const COST: &'static str = M::WGSL;
    const FINISH: &'static str = if Self::FINISHES_APART {
        include_str!("selection.wgsl")
    } else {
        include_str!("finish.wgsl")
    };
    // With a capacity of twice the nodes there is nothing left to choose from.
    const FINISHES_APART: bool = Sizes::<N, W, C>::CHOICE > N;
}

/// The parts of a shader that looks up curves stored as `P`, in the order in which they are
/// concatenated.
///
/// ```wgsl
/// fn avsm_transmittances(texel: u32, depth: f32) -> array<f32, avsm_CHANNELS>
/// ```
///
/// The share of the light that gets as far as a depth, from 0 to 1 and per channel, by the
/// curve of a texel, which is counted along the rows. What is exactly at the depth casts no
/// shadow on it. The error is [`LOOKUP_ERROR`](super::LOOKUP_ERROR) and that of the curve.
///
/// ```wgsl
/// fn avsm_filtered(
///     extent: vec2<u32>,
///     position: vec2<f32>,
///     depth: f32,
///     side: u32,
/// ) -> array<f32, avsm_CHANNELS>
/// ```
///
/// The same between texels of a map of `extent` texels, at least one: `position` is in
/// texels, whose centres are at 0.5, 1.5, …; beside the map the texel at its rim answers.
/// `side` is that of [`Filter`](crate::Filter): 0 asks the nearest texel, 1 the four around,
/// and k, at most 255, takes the mean over k × k texels, with (k + 1)² lookups.
/// Of a curve with one channel:
///
/// ```wgsl
/// let light = avsm_filtered(extent, position, depth, 1u)[0];
/// ```
///
/// ```wgsl
/// fn avsm_depth_at(texel: u32, transmittance: f32, channel: u32) -> f32
/// ```
///
/// How far at least a share of the light gets in a channel: `avsm_LARGEST`, which is
/// `f32::MAX`, if the curve never falls below it, `-avsm_LARGEST` for more than 1. To find
/// the lit parts of a ray there is no need of it: march the ray, or ask at both ends of a
/// step.
///
/// ```wgsl
/// fn avsm_error_bounds(texel: u32, depth: f32) -> array<f32, avsm_CHANNELS>
/// ```
///
/// A bound of the error of `avsm_transmittances`, of maps of [`Curve`]s alone.
///
/// Constants: `avsm_CHANNELS`, and `avsm_WORDS`, the words of a texel.
///
/// # To be written by the shader around it
///
/// ```wgsl
/// fn avsm_word(index: u32) -> u32
/// ```
///
/// A word of [`TransmittanceMap::words`](crate::TransmittanceMap::words), usually of a
/// storage buffer.
pub const fn lookup_parts<P: WgslStored<C>, const C: usize>() -> [&'static str; 7] {
    [
        P::SIZES,
        NUMERIC,
        P::RULES,
        P::LOAD,
        LOOKUP,
        FILTER,
        P::BOUNDS,
    ]
}

/// The parts of a shader that makes curves by the rule of `A` and stores them as
/// `P`, in the order in which they are concatenated.
///
/// ```wgsl
/// struct avsm_Segment {
///     entry: f32,
///     exit: f32,
///     optical_depth: array<f32, avsm_CHANNELS>,
/// }
/// ```
///
/// A blocker: between two depths, in any unit, with the optical depth of all of it. From
/// 1e30 on it is opaque. A surface has both depths at once.
///
/// ```wgsl
/// fn avsm_clear() -> avsm_Curve
/// fn avsm_insert(curve: ptr<function, avsm_Curve>, blocker: avsm_Segment)
/// fn avsm_finish(curve: ptr<function, avsm_Curve>)
/// fn avsm_store(texel: u32, curve: ptr<function, avsm_Curve>)
/// ```
///
/// An invocation makes the curve of a texel:
///
/// ```wgsl
/// var curve = avsm_clear();
/// for (var i = 0u; i < segments; i += 1u) {
///     avsm_insert(&curve, segment_of(texel, i));
/// }
/// avsm_finish(&curve);
/// avsm_store(texel, &curve);
/// ```
///
/// Blockers come in any order. What is no blocker changes nothing: depths that are not
/// finite or the wrong way round, optical depths that are negative or NaN. The error is
/// that of the rule on the CPU, and what the [module](crate::gpu#agreement-with-the-cpu)
/// says of roundings.
///
/// # To be written by the shader around it
///
/// ```wgsl
/// fn avsm_set_word(index: u32, word: u32)
/// fn avsm_word(index: u32) -> u32
/// ```
///
/// Set and read a word of [`TransmittanceMap::words`](crate::TransmittanceMap::words).
pub fn build_parts<A, P, const C: usize>() -> [&'static str; 10]
where
    A: WgslRule<C>,
    A::Curve: Into<P>,
    P: WgslStored<C>,
{
    [
        A::SIZES,
        SEGMENT,
        NUMERIC,
        A::RULES[0],
        A::RULES[1],
        A::COST,
        CURVE,
        A::FINISH,
        P::LOAD,
        P::STORE,
    ]
}

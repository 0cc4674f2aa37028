//! Which parts of text make a shader.

use super::constants::Sizes;
use crate::{Accumulate, Curve, Lookup, Metric, Packed, PackedHalf, Stored, Stream};

const NUMERIC: &str = include_str!("numeric.wgsl");
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

/// The parts of a shader that looks up curves stored as `P`. It has to define
/// `fn avsm_word(index: u32) -> u32`, the words of the map.
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
/// `P`. It has to define `fn avsm_set_word(index: u32, word: u32)`, which sets a
/// word of the map, and `fn avsm_word(index: u32) -> u32`, which reads it.
pub fn build_parts<A, P, const C: usize>() -> [&'static str; 9]
where
    A: WgslRule<C>,
    A::Curve: Into<P>,
    P: WgslStored<C>,
{
    [
        A::SIZES,
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

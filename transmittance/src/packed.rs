//! Curves as a map stores them.
//!
//! A lookup takes 15 cycles with linear curves of 8 nodes and 40 with exponential
//! ones. A chain of about 140 cycles binds it (the place, a division in f64, the
//! exponential): as many lookups are under way at a time as the processor can hold.

use std::fmt::Debug;
use std::marker::PhantomData;

use half::f16;

use crate::lookup::{Exponential, Lookup};
use crate::node::count_in_front;
use crate::numeric::fraction;
use crate::{Curve, Evaluate};

/// The nodes of a [`Curve`] in `4 N (1 + C)` bytes, without its error bounds.
///
/// Gives the same results as the curve, bit for bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Packed<const N: usize, L = Exponential, const C: usize = 1> {
    pub(crate) depth: [f32; N],
    pub(crate) value: [[f32; N]; C],
    lookup: PhantomData<L>,
}

impl<const N: usize, L: Lookup, const C: usize> Packed<N, L, C> {
    pub(crate) fn from_parts(depth: [f32; N], value: [[f32; N]; C]) -> Self {
        Self {
            depth,
            value,
            lookup: PhantomData,
        }
    }
}

impl<const N: usize, L: Lookup, const C: usize> From<Curve<N, L, C>> for Packed<N, L, C> {
    fn from(curve: Curve<N, L, C>) -> Self {
        // Unused entries repeat the last node: no depth lies between them, and behind them its
        // value holds.
        let nodes = curve.nodes();
        let node = |index: usize| nodes.get(index).or(nodes.last());
        Self::from_parts(
            std::array::from_fn(|index| node(index).map_or(0.0, |node| node.depth)),
            std::array::from_fn(|c| {
                std::array::from_fn(|index| node(index).map_or(L::CLEAR, |node| node.value[c]))
            }),
        )
    }
}

impl<const N: usize, L: Lookup, const C: usize> Evaluate<C> for Packed<N, L, C> {
    #[inline]
    fn evaluate(&self, depth: f32) -> [f32; C] {
        let next = count_in_front(|index| self.depth[index], N, depth);
        // As in a curve, the ends take no branch: the first value is that of a clear ray.
        let (from, to) = (next.saturating_sub(1), next.min(N - 1));
        let fraction = fraction(self.depth[from], self.depth[to], depth);
        std::array::from_fn(|c| {
            L::transmittance(L::mix(self.value[c][from], self.value[c][to], fraction))
        })
    }
}

/// The nodes of a [`Curve`] in `8 + 2 N (1 + C)` bytes: values in f16, depths in
/// 16 bits between the first and the last node.
///
/// With `T` the curve, its result at depth `z` lies between
///
/// ```text
/// T(z + δ) − ε   and   T(z − δ) + ε
/// ```
///
/// `ε` = 2.5e-4 is the rounding of f16: 2⁻¹² of a transmittance, or 2⁻¹¹ of an
/// optical depth τ, which is 2⁻¹¹ τ exp(−τ) < 1.8e-4 of transmittance. `δ` is
/// 2⁻¹⁶ of the distance from the first to the last node (and an ULP of the
/// depth) as long as optical depths are below 65504, the largest f16. Beyond,
/// where a stretch is darker than that, it is 2⁻¹²: over this share of its
/// length an optical depth of 65504 leaves 1e-7. Curves stay monotone and in
/// `[0, 1]`, and steps stay steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PackedHalf<const N: usize, L = Exponential, const C: usize = 1> {
    pub(crate) ends: [f32; 2],
    pub(crate) depth: [u16; N],
    pub(crate) value: [[f16; N]; C],
    lookup: PhantomData<L>,
}

impl<const N: usize, L: Lookup, const C: usize> PackedHalf<N, L, C> {
    pub(crate) fn from_parts(ends: [f32; 2], depth: [u16; N], value: [[f16; N]; C]) -> Self {
        Self {
            ends,
            depth,
            value,
            lookup: PhantomData,
        }
    }
}

/// The largest 16-bit depth: the last node's.
const LAST: f64 = u16::MAX as f64;

impl<const N: usize, L: Lookup, const C: usize> From<Curve<N, L, C>> for PackedHalf<N, L, C> {
    fn from(curve: Curve<N, L, C>) -> Self {
        let nodes = curve.nodes();
        let ends = match nodes {
            [] => [0.0; 2],
            nodes => [nodes[0].depth, nodes[nodes.len() - 1].depth],
        };
        let node = |index: usize| nodes.get(index).or(nodes.last());
        Self::from_parts(
            ends,
            std::array::from_fn(|index| {
                let share = node(index).map_or(0.0, |node| fraction(ends[0], ends[1], node.depth));
                (share * LAST).round() as u16
            }),
            std::array::from_fn(|c| {
                std::array::from_fn(|index| {
                    let value = node(index).map_or(L::CLEAR, |node| node.value[c]);
                    // An optical depth beyond the range of f16 is opaque either way.
                    f16::from_f32(value.min(f16::MAX.to_f32()))
                })
            }),
        )
    }
}

impl<const N: usize, L: Lookup, const C: usize> Evaluate<C> for PackedHalf<N, L, C> {
    #[inline]
    fn evaluate(&self, depth: f32) -> [f32; C] {
        let [first, last] = self.ends;
        // A blocker casts no shadow at its own depth, also at that of the first node.
        if !(depth > first) {
            return [1.0; C];
        }
        let at = |index: usize, c: usize| self.value[c][index].to_f32();
        if depth > last {
            return std::array::from_fn(|c| L::transmittance(at(N - 1, c)));
        }
        let place = fraction(first, last, depth) * LAST;
        let next = (0..N)
            .filter(|&index| f64::from(self.depth[index]) < place)
            .count();
        // In front of all 16-bit depths only if the first 2⁻¹⁶ is asked for.
        let next = next.clamp(1, N - 1);
        let (from, to) = (self.depth[next - 1], self.depth[next]);
        let way = f64::from(to) - f64::from(from);
        let fraction = if way > 0.0 {
            ((place - f64::from(from)) / way).clamp(0.0, 1.0)
        } else {
            1.0
        };
        std::array::from_fn(|c| L::transmittance(L::mix(at(next - 1, c), at(next, c), fraction)))
    }
}

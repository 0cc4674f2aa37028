//! Curves as the words of a buffer.

use half::f16;

use crate::lookup::Lookup;
use crate::node::Node;
use crate::{Curve, Evaluate, Packed, PackedHalf};

/// A curve that is a fixed number of 32-bit words, so that maps of it can live
/// in the buffers of any backend.
///
/// Shaders read and write the same words; their layout is given with each type.
pub trait Stored<const C: usize = 1>: Evaluate<C> + Sized + Send + Sync + 'static {
    /// Words of a curve.
    const WORDS: usize;

    /// A clear ray.
    fn clear() -> Self;

    /// Writes the curve into [`Stored::WORDS`] words.
    fn write(&self, words: &mut [u32]);

    /// The curve of [`Stored::WORDS`] words. Words that no curve has written give
    /// a curve without meaning.
    fn read(words: &[u32]) -> Self;
}

/// The number of nodes and of insertions, and then, `N` words each, depths and,
/// channel by channel, values, and the bounds above and below.
impl<const N: usize, L: Lookup, const C: usize> Stored<C> for Curve<N, L, C> {
    const WORDS: usize = 2 + N * (1 + 3 * C);

    fn clear() -> Self {
        Self::new()
    }

    fn write(&self, words: &mut [u32]) {
        let nodes = self.nodes();
        words[0] = nodes.len() as u32;
        words[1] = self.insertions();
        words[2..].fill(0);
        for (i, node) in nodes.iter().enumerate() {
            let rows = [node.depth]
                .into_iter()
                .chain(node.value)
                .chain(node.above)
                .chain(node.below);
            for (row, number) in rows.enumerate() {
                words[2 + row * N + i] = number.to_bits();
            }
        }
    }

    fn read(words: &[u32]) -> Self {
        let number = |row: usize, i: usize| f32::from_bits(words[2 + row * N + i]);
        let nodes: [Node<C>; N] = std::array::from_fn(|i| Node {
            depth: number(0, i),
            value: std::array::from_fn(|c| number(1 + c, i)),
            above: std::array::from_fn(|c| number(1 + C + c, i)),
            below: std::array::from_fn(|c| number(1 + 2 * C + c, i)),
        });
        Self::from_nodes(&nodes[..N.min(words[0] as usize)], words[1])
    }
}

/// `N` words each: depths and, channel by channel, values. Entries left over
/// repeat the last node.
impl<const N: usize, L: Lookup, const C: usize> Stored<C> for Packed<N, L, C> {
    const WORDS: usize = N * (1 + C);

    fn clear() -> Self {
        Curve::new().into()
    }

    fn write(&self, words: &mut [u32]) {
        let numbers = self.depth.iter().chain(self.value.as_flattened());
        for (word, number) in words.iter_mut().zip(numbers) {
            *word = number.to_bits();
        }
    }

    fn read(words: &[u32]) -> Self {
        let number = |index: usize| f32::from_bits(words[index]);
        Self::from_parts(
            std::array::from_fn(number),
            std::array::from_fn(|c| std::array::from_fn(|i| number((1 + c) * N + i))),
        )
    }
}

/// First and last depth, and then pairs of 16 bits, the first in the low half:
/// depths and, channel by channel, values; each begins a word.
impl<const N: usize, L: Lookup, const C: usize> Stored<C> for PackedHalf<N, L, C> {
    const WORDS: usize = 2 + N.div_ceil(2) * (1 + C);

    fn clear() -> Self {
        Curve::new().into()
    }

    fn write(&self, words: &mut [u32]) {
        let (ends, pairs) = words.split_at_mut(2);
        for (word, end) in ends.iter_mut().zip(self.ends) {
            *word = end.to_bits();
        }
        let values = self.value.iter().map(|row| row.map(f16::to_bits));
        let rows = [self.depth].into_iter().chain(values);
        for (words, row) in pairs.chunks_mut(N.div_ceil(2)).zip(rows) {
            for (word, pair) in words.iter_mut().zip(row.chunks(2)) {
                let high = pair.get(1).copied().unwrap_or(0);
                *word = u32::from(pair[0]) | u32::from(high) << 16;
            }
        }
    }

    fn read(words: &[u32]) -> Self {
        let half = |row: usize, i: usize| {
            (words[2 + row * N.div_ceil(2) + i / 2] >> (16 * (i % 2))) as u16
        };
        Self::from_parts(
            [f32::from_bits(words[0]), f32::from_bits(words[1])],
            std::array::from_fn(|i| half(0, i)),
            std::array::from_fn(|c| std::array::from_fn(|i| f16::from_bits(half(1 + c, i)))),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BlockerSegment, Exponential, Linear};

    fn comes_back<T: Stored<2> + PartialEq + std::fmt::Debug>(stored: T) {
        let mut words = vec![u32::MAX; T::WORDS];
        stored.write(&mut words);
        assert_eq!(T::read(&words), stored);
    }

    fn all_forms<L: Lookup>(curve: Curve<5, L, 2>) {
        comes_back(curve);
        comes_back(Packed::from(curve));
        comes_back(PackedHalf::from(curve));
    }

    #[test]
    fn curves_come_back_as_they_went() {
        let (mut linear, mut exponential) = (Curve::<5, Linear, 2>::new(), Curve::new());
        all_forms::<Linear>(linear);
        all_forms::<Exponential>(exponential);
        for at in 0..7_u8 {
            let entry = f32::from(at);
            let segment =
                BlockerSegment::with_optical_depths(entry, entry + 2.5, [0.25, 0.5]).unwrap();
            linear.insert(&segment);
            exponential.insert(&segment);
            all_forms(linear);
            all_forms(exponential);
        }
        comes_back(Packed::<5, Linear, 2>::clear());
    }
}

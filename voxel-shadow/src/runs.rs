//! Runs of equal bits along φ.

use bytemuck::{Pod, Zeroable};

/// Consecutive voxels along φ that are equally visible from the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// Position along φ where it begins, in voxels.
    pub start: f32,
    /// Position where it ends.
    pub end: f32,
    /// In (0, 1]: the share of the light that arrives.
    pub visibility: f32,
}

/// A part of an eye ray that the light reaches.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LitInterval {
    /// Distance from the eye at which it begins, metres.
    pub start: f32,
    /// Distance at which it ends.
    pub end: f32,
    /// In (0, 1]: the share of the light that arrives.
    pub visibility: f32,
}

/// Two texels side by side along θ, and the share of the second.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair<'a> {
    pub(crate) first: &'a [u32],
    pub(crate) second: &'a [u32],
    pub(crate) share: f32,
}

impl Pair<'_> {
    /// The visibility of a bit: 1 minus the interpolated shadow.
    #[inline]
    pub(crate) fn visibility(&self, bit: u32) -> f32 {
        let lit = |texel: &[u32]| (!texel[(bit / 32) as usize] >> (bit % 32)) & 1;
        blend(lit(self.first), lit(self.second), self.share)
    }

    /// The visibility of the bit at a position.
    #[inline]
    pub(crate) fn visibility_at(&self, position: f32) -> f32 {
        let highest = (32 * self.first.len() - 1) as f32;
        self.visibility(position.clamp(0.0, highest) as u32)
    }

    /// The integral of the visibility between two positions along φ; the bit of a position
    /// is that of [`Runs::new`]. Exactly `to − from` if all bits are lit.
    #[inline]
    pub(crate) fn lit_length(&self, bias: f32, from: f32, to: f32) -> f32 {
        let highest = (32 * self.first.len() - 1) as f32;
        let ends = [from + bias, to + bias];
        let [first, last] = ends.map(|end| end.clamp(0.0, highest) as u32);
        if first == last {
            return self.visibility(first) * (to - from);
        }
        // The shares of the first and the last bit, and the number of lit bits between them.
        let before = (first + 1) as f32 - ends[0];
        let after = ends[1] - last as f32;
        let whole = [self.first, self.second].map(|texel| lit_bits(texel, first + 1, last));
        let between = blend(whole[0], whole[1], self.share);
        let [at_first, at_last] = [first, last].map(|bit| self.visibility(bit));
        // The three lengths add up to `to − from` only up to rounding.
        if at_first == 1.0 && at_last == 1.0 && between == (last - first - 1) as f32 {
            return to - from;
        }
        at_first * before + between + at_last * after
    }

    /// The bits of a word at which one of the two texels changes: those that differ from the
    /// bit before them, which may be in the word before. Bit 0 of the texels never counts.
    #[inline]
    fn changes(&self, word: usize) -> u32 {
        let changes = |texel: &[u32]| {
            let before = match word.checked_sub(1) {
                Some(before) => texel[before] >> 31,
                None => texel[0] & 1,
            };
            texel[word] ^ (texel[word] << 1 | before)
        };
        changes(self.first) | changes(self.second)
    }
}

/// How many of the bits from `start` to before `end` are lit.
#[inline]
fn lit_bits(texel: &[u32], start: u32, end: u32) -> u32 {
    let words = (start / 32) as usize..end.div_ceil(32) as usize;
    let mut lit = 0;
    for (word, first) in texel[words].iter().zip((start & !31..).step_by(32)) {
        let skipped = u32::MAX << start.saturating_sub(first);
        let kept = u32::MAX >> (first + 32).saturating_sub(end).min(31);
        lit += (!word & skipped & kept).count_ones();
    }
    lit
}

#[inline(always)]
pub(crate) fn blend(first: u32, second: u32, share: f32) -> f32 {
    let (first, second) = (first as f32, second as f32);
    // In this form it is exactly 1 if both are lit.
    first + share * (second - first)
}

/// The runs of a pair of texels along an eye ray, those in full shadow left out.
///
/// In order; neighbours differ in visibility. A ray that ends where it begins
/// has one run of length 0, if it is lit.
///
/// All changes of a word are found at once, and then read off one by one. The branch at the end
/// of each run, which is hard to predict, takes most of the time.
#[derive(Debug, Clone)]
pub struct Runs<'a> {
    texels: Pair<'a>,
    /// The bit at position 0 and all before it is `bit`.
    bias: f32,
    /// The position where the ray ends.
    end: f32,
    /// The first bit of the next run, and the last bit of the ray.
    bit: u32,
    last: u32,
    /// A word, and those of its changes that come after `bit`.
    word: u32,
    changes: u32,
    /// Where the next run begins.
    start: f32,
    done: bool,
}

impl<'a> Runs<'a> {
    /// The bit at position `p` is that at `p + bias`.
    #[inline]
    pub(crate) fn new(texels: Pair<'a>, bias: f32, end: f32) -> Self {
        let highest = (32 * texels.first.len() - 1) as f32;
        let bit_at = |position: f32| (position + bias).clamp(0.0, highest) as u32;
        let bit = bit_at(0.0);
        let word = bit / 32;
        Self {
            texels,
            bias,
            end,
            bit,
            last: bit_at(end),
            word,
            changes: texels.changes(word as usize) & (!1 << (bit % 32)),
            start: 0.0,
            done: false,
        }
    }

    /// The next bit at which one of the texels changes, `None` if it is beyond the ray.
    #[inline]
    fn next_change(&mut self) -> Option<u32> {
        while self.changes == 0 {
            if self.word >= self.last / 32 {
                return None;
            }
            self.word += 1;
            self.changes = self.texels.changes(self.word as usize);
        }
        let bit = 32 * self.word + self.changes.trailing_zeros();
        self.changes &= self.changes - 1;
        (bit <= self.last).then_some(bit)
    }
}

impl Iterator for Runs<'_> {
    type Item = Run;

    #[inline]
    fn next(&mut self) -> Option<Run> {
        while !self.done {
            let visibility = self.texels.visibility(self.bit);
            let start = self.start;
            match self.next_change() {
                Some(bit) => {
                    self.bit = bit;
                    self.start = (bit as f32 - self.bias).min(self.end);
                }
                None => {
                    self.done = true;
                    self.start = self.end;
                }
            }
            if visibility > 0.0 && (start < self.start || self.end == 0.0) {
                return Some(Run {
                    start,
                    end: self.start,
                    visibility,
                });
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn word() -> impl Strategy<Value = u32> {
        prop_oneof![
            Just(0),
            Just(u32::MAX),
            any::<u32>(),
            (0..32_u32).prop_map(|bit| 1 << bit),
            (0..32_u32).prop_map(|bit| u32::MAX << bit),
        ]
    }

    fn texels() -> impl Strategy<Value = (Vec<u32>, Vec<u32>)> {
        (1..5_usize).prop_flat_map(|n| {
            (
                prop::collection::vec(word(), n),
                prop::collection::vec(word(), n),
            )
        })
    }

    proptest! {
        #![proptest_config(reference::property::cases(3000))]
        #[test]
        fn runs_are_what_asking_bit_by_bit_gives(
            (first, second) in texels(),
            share in prop_oneof![Just(0.0_f32), Just(1.0), 0.0_f32..1.0],
            bias in prop_oneof![Just(0.0_f32), Just(-1.0), -40.0_f32..40.0],
            end in 0.0_f32..1.0,
        ) {
            let bits = 32 * first.len();
            let end = end * bits as f32;
            let texels = Pair { first: &first, second: &second, share };
            let runs: Vec<Run> = Runs::new(texels, bias, end).collect();
            let mut last = 0.0;
            for run in &runs {
                prop_assert!(last <= run.start && run.start < run.end && run.end <= end);
                prop_assert!(run.visibility > 0.0 && run.visibility <= 1.0);
                last = run.end;
            }
            // Away from the borders of voxels, which are rounded.
            for i in 0..bits * 4 {
                let position = (i as f32 + 0.5) / 4.0;
                let shifted = position + bias;
                if position >= end || (shifted - shifted.round()).abs() < 1e-3 {
                    continue;
                }
                let bit = shifted.clamp(0.0, (bits - 1) as f32) as u32;
                let expected = texels.visibility(bit);
                let found = runs
                    .iter()
                    .find(|run| run.start <= position && position < run.end)
                    .map_or(0.0, |run| run.visibility);
                prop_assert_eq!(found, expected);
            }
        }
    }

    proptest! {
        #![proptest_config(reference::property::cases(3000))]
        #[test]
        fn lit_lengths_are_the_sum_of_the_runs(
            (first, second) in texels(),
            share in prop_oneof![Just(0.0_f32), Just(1.0), 0.0_f32..1.0],
            bias in prop_oneof![Just(0.0_f32), Just(-1.0), -40.0_f32..40.0],
            ends in [0.0_f32..1.0, 0.0_f32..1.0],
        ) {
            let bits = 32 * first.len();
            let ends = ends.map(|end| end * bits as f32);
            let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            let texels = Pair { first: &first, second: &second, share };
            let expected: f32 = Runs::new(texels, bias, to)
                .map(|run| run.visibility * (run.end - run.start.max(from)).max(0.0))
                .sum();
            let found = texels.lit_length(bias, from, to);
            let is_lit = |bit| texels.visibility(bit) == 1.0;
            let passed = [from, to].map(|end| (end + bias).clamp(0.0, (bits - 1) as f32) as u32);
            if (passed[0]..=passed[1]).all(is_lit) {
                prop_assert_eq!(found, to - from);
            }
            prop_assert!((found - expected).abs() <= 1e-5 * bits as f32, "{found} {expected}");
        }
    }

    #[test]
    fn a_ray_without_length_has_one_run_if_it_is_lit() {
        for (word, expected) in [(0_u32, 1), (1, 0), (2, 1)] {
            let texels = Pair {
                first: &[word],
                second: &[word],
                share: 0.25,
            };
            let runs: Vec<Run> = Runs::new(texels, 0.0, 0.0).collect();
            assert_eq!(runs.len(), expected, "{word}");
            assert!(
                runs.iter()
                    .all(|run| run.end == 0.0 && run.visibility == 1.0)
            );
        }
    }
}

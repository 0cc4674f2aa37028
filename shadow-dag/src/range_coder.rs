//! Bits at the cost of what was known about them.
//!
//! A binary range coder with carries, as in LZMA: every bit narrows a range in
//! proportion to how probable it was, and a model of its own learns that.
//!
//! Based on: Martin, Range encoding, 1979, in the form of Pavlov's LZMA.

/// How probable a bit is to be 1, in 65,536ths: the mean of one that learns fast
/// and one that learns slowly.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bit {
    fast: u16,
    slow: u16,
}

impl Default for Bit {
    fn default() -> Self {
        Self {
            fast: 1 << 15,
            slow: 1 << 15,
        }
    }
}

/// Steps by which the two learn, as shifts.
const FAST: u32 = 4;
const SLOW: u32 = 7;
/// The least probability of either bit.
const LEAST: u32 = 1 << 5;

impl Bit {
    fn probability(self) -> u32 {
        ((u32::from(self.fast) + u32::from(self.slow)) / 2).clamp(LEAST, (1 << 16) - LEAST)
    }

    fn learn(&mut self, bit: bool) {
        let towards = |at: u16, shift: u32| match bit {
            true => at + ((u16::MAX - at) >> shift),
            false => at - (at >> shift),
        };
        self.fast = towards(self.fast, FAST);
        self.slow = towards(self.slow, SLOW);
    }
}

/// Writes bits, or reads them. A reader ignores the bits that it is given and returns those that
/// were written, so that one walk through a model serves both.
pub(crate) trait Coder {
    fn bit(&mut self, model: &mut Bit, bit: bool) -> bool;

    /// The lowest `width` bits of a number of which nothing is known.
    fn raw(&mut self, value: u32, width: u32) -> u32;
}

/// A range is widened once it is below this.
const NARROW: u32 = 1 << 24;

#[derive(Debug)]
pub(crate) struct Encoder {
    low: u64,
    range: u32,
    /// The last byte, which a carry may change, and how many there are with those
    /// of 0xff behind it. There is a 0 in front of the first.
    held: u8,
    held_count: u64,
    bytes: Vec<u8>,
}

impl Encoder {
    pub(crate) fn new() -> Self {
        Self {
            low: 0,
            range: u32::MAX,
            held: 0,
            held_count: 1,
            bytes: Vec::new(),
        }
    }

    fn shift(&mut self) {
        let carry = (self.low >> 32) as u8;
        if self.low < 0xff00_0000 || carry != 0 {
            self.bytes.push(self.held.wrapping_add(carry));
            let rest = (1..self.held_count).map(|_| 0xff_u8.wrapping_add(carry));
            self.bytes.extend(rest);
            self.held = (self.low >> 24) as u8;
            self.held_count = 0;
        }
        self.held_count += 1;
        self.low = (self.low & 0x00ff_ffff) << 8;
    }

    pub(crate) fn finish(mut self) -> Vec<u8> {
        for _ in 0..5 {
            self.shift();
        }
        // Zeros at the end need not be written, because they are read behind the end anyway.
        while self.bytes.last() == Some(&0) {
            self.bytes.pop();
        }
        self.bytes
    }
}

impl Coder for Encoder {
    fn bit(&mut self, model: &mut Bit, bit: bool) -> bool {
        let bound = (self.range >> 16) * model.probability();
        if bit {
            self.range = bound;
        } else {
            self.low += u64::from(bound);
            self.range -= bound;
        }
        model.learn(bit);
        while self.range < NARROW {
            self.range <<= 8;
            self.shift();
        }
        bit
    }

    fn raw(&mut self, value: u32, width: u32) -> u32 {
        for at in (0..width).rev() {
            self.range >>= 1;
            if value >> at & 1 == 1 {
                self.low += u64::from(self.range);
            }
            while self.range < NARROW {
                self.range <<= 8;
                self.shift();
            }
        }
        value
    }
}

/// Reads what [`Encoder`] wrote; any other bytes give some bits as well, and
/// zeros follow the last.
#[derive(Debug)]
pub(crate) struct Decoder<'a> {
    rest: &'a [u8],
    range: u32,
    /// By how much what was written is above the low end of the range.
    above: u32,
}

impl<'a> Decoder<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        let mut decoder = Self {
            rest: bytes,
            range: u32::MAX,
            above: 0,
        };
        for _ in 0..5 {
            decoder.next();
        }
        decoder
    }

    fn next(&mut self) {
        let byte = match self.rest.split_first() {
            Some((first, rest)) => {
                self.rest = rest;
                *first
            }
            None => 0,
        };
        self.above = self.above << 8 | u32::from(byte);
    }

    fn widen(&mut self) {
        while self.range < NARROW {
            self.range <<= 8;
            self.next();
        }
    }
}

impl Coder for Decoder<'_> {
    fn bit(&mut self, model: &mut Bit, _: bool) -> bool {
        let bound = (self.range >> 16) * model.probability();
        let bit = self.above < bound;
        if bit {
            self.range = bound;
        } else {
            self.above -= bound;
            self.range -= bound;
        }
        model.learn(bit);
        self.widen();
        bit
    }

    fn raw(&mut self, _: u32, width: u32) -> u32 {
        let mut value = 0;
        for _ in 0..width {
            self.range >>= 1;
            let bit = self.above >= self.range;
            if bit {
                self.above -= self.range;
            }
            value = value << 1 | u32::from(bit);
            self.widen();
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn code<C: Coder>(coder: &mut C, bits: &[(usize, bool)], numbers: &[u32]) -> Vec<u32> {
        let mut models = [Bit::default(); 4];
        let coded: Vec<u32> = bits
            .iter()
            .map(|&(model, bit)| u32::from(coder.bit(&mut models[model], bit)))
            .collect();
        let numbers = numbers.iter().map(|&number| coder.raw(number, 32));
        coded.into_iter().chain(numbers).collect()
    }

    proptest! {
        #![proptest_config(reference::property::cases(256))]

        #[test]
        fn bits_come_back(
            // Long stretches of one bit make carries run.
            runs in proptest::collection::vec((0..4_usize, any::<bool>(), 1..400_usize), 0..40),
            numbers in proptest::collection::vec(prop_oneof![Just(u32::MAX), Just(0), any::<u32>()], 0..40),
        ) {
            let bits: Vec<(usize, bool)> = runs
                .iter()
                .flat_map(|&(model, bit, count)| std::iter::repeat_n((model, bit), count))
                .collect();
            let mut encoder = Encoder::new();
            let written = code(&mut encoder, &bits, &numbers);
            let bytes = encoder.finish();
            let nothing: Vec<_> = bits.iter().map(|&(model, _)| (model, false)).collect();
            let mut decoder = Decoder::new(&bytes);
            prop_assert_eq!(code(&mut decoder, &nothing, &vec![0; numbers.len()]), written);
        }
    }
}

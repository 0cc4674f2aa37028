//! Little-endian numbers out of bytes of any alignment.
//!
//! Reads behind the end give 0. Data that has been checked never causes any;
//! but bytes that change while somebody else has them mapped must not cause a
//! panic either.

pub(crate) fn load_u32(bytes: &[u8], at: usize) -> u32 {
    match bytes.get(at..).and_then(<[u8]>::first_chunk) {
        Some(chunk) => u32::from_le_bytes(*chunk),
        None => 0,
    }
}

pub(crate) fn load_u64(bytes: &[u8], at: usize) -> u64 {
    match bytes.get(at..).and_then(<[u8]>::first_chunk) {
        Some(chunk) => u64::from_le_bytes(*chunk),
        None => 0,
    }
}

/// Bytes that must follow the last bit that [`load_bits`] is to find.
pub(crate) const BIT_PADDING: usize = 8;

/// `width` ≤ 32 bits from bit `at` on; the first is the lowest.
pub(crate) fn load_bits(bytes: &[u8], at: u64, width: u32) -> u32 {
    let word = load_u64(bytes, (at >> 3) as usize) >> (at & 7);
    (word & ((1 << width) - 1)) as u32
}

/// Appends numbers of any width.
#[derive(Debug, Default)]
pub(crate) struct BitWriter {
    bytes: Vec<u8>,
    pending: u64,
    used: u32,
}

impl BitWriter {
    pub(crate) fn push(&mut self, value: u32, width: u32) {
        self.pending |= u64::from(value) << self.used;
        self.used += width;
        while self.used >= 8 {
            self.bytes.push(self.pending as u8);
            self.pending >>= 8;
            self.used -= 8;
        }
    }

    /// The bytes, the last filled up with zeros.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        if self.used > 0 {
            self.bytes.push(self.pending as u8);
        }
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(reference::property::cases(256))]

        #[test]
        fn numbers_of_any_width_come_back(
            numbers in proptest::collection::vec((0_u32.., 0_u32..=32), 0..100)
        ) {
            let cut = |value: u32, width: u32| value & ((1_u64 << width) - 1) as u32;
            let mut writer = BitWriter::default();
            for &(value, width) in &numbers {
                writer.push(cut(value, width), width);
            }
            let mut bytes = writer.finish();
            bytes.extend([0xff; BIT_PADDING]);
            let mut at = 0;
            for &(value, width) in &numbers {
                prop_assert_eq!(load_bits(&bytes, at, width), cut(value, width));
                at += u64::from(width);
            }
        }
    }
}

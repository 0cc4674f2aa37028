//! Numbers out of the bytes that a fuzzer changes.

use glam::Vec3;

/// Bytes that are read from front to back; behind their end all are 0.
#[derive(Debug, Clone)]
pub struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    /// Reads these.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Whether all have been read.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What has not been read.
    pub fn rest(self) -> &'a [u8] {
        self.0
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let [byte] = self.array();
        byte
    }

    fn array<const N: usize>(&mut self) -> [u8; N] {
        let mut array = [0; N];
        let (read, rest) = self.0.split_at(N.min(self.0.len()));
        array[..read.len()].copy_from_slice(read);
        self.0 = rest;
        array
    }

    /// Of two bytes.
    pub fn short(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    /// Of four bytes.
    pub fn word(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    /// Any number of single precision at all, of four bytes.
    pub fn any(&mut self) -> f32 {
        f32::from_bits(self.word())
    }

    /// 0 … `count` − 1, of one byte; `count` is from 1 to 256.
    pub fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) * count / 256
    }

    /// One of these, of one byte.
    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    /// Whether the lowest bit of the next byte is set.
    pub fn flag(&mut self) -> bool {
        self.byte() & 1 == 1
    }

    /// From 0 to 1 in steps of 1/65535, of two bytes.
    pub fn unit(&mut self) -> f32 {
        f32::from(self.short()) / 65_535.0
    }

    /// From `low` to `high`, of two bytes.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Of any magnitude from 2^`low` to 2^`high`, of two bytes.
    pub fn magnitude(&mut self, low: f32, high: f32) -> f32 {
        self.between(low, high).exp2()
    }

    /// Within the cube ±`size`, of six bytes.
    pub fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::from([(); 3].map(|()| self.between(-size, size)))
    }

    /// A unit vector, one of the axes' if the bytes say nothing else.
    pub fn direction(&mut self) -> Vec3 {
        match self.below(8) {
            axis @ 0..3 => Vec3::AXES[axis],
            _ => self.vector(1.0).normalize_or(Vec3::NEG_Z),
        }
    }
}

/// The checksum CRC-32.
pub(super) fn crc32(bytes: &[u8]) -> u32 {
    let mut sum = u32::MAX;
    for byte in bytes {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = sum >> 1 ^ (0xEDB8_8320 * (sum & 1));
        }
    }
    !sum
}

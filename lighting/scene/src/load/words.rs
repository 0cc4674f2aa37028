//! Little-endian numbers one after the other.

use super::LoadError;

/// Reads a binary file from its front.
#[derive(Debug, Clone)]
pub(super) struct Words<'a> {
    rest: &'a [u8],
}

impl<'a> Words<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Bytes that have not been read.
    pub(super) fn available(&self) -> usize {
        self.rest.len()
    }

    /// The next `count` items of `N` bytes.
    pub(super) fn items<const N: usize>(
        &mut self,
        what: &str,
        count: u64,
    ) -> Result<impl ExactSizeIterator<Item = [u8; N]> + use<'a, N>, LoadError> {
        let needed = count.saturating_mul(N as u64);
        if needed > self.rest.len() as u64 {
            return Err(LoadError::truncated(what, needed, self.rest.len()));
        }
        let (items, rest) = self.rest.split_at(needed as usize);
        self.rest = rest;
        let (items, _) = items.as_chunks::<N>();
        Ok(items.iter().copied())
    }

    /// The next item.
    pub(super) fn item<const N: usize>(&mut self, what: &str) -> Result<[u8; N], LoadError> {
        // One item was asked for, and one is there.
        Ok(self.items(what, 1)?.next().unwrap_or([0; N]))
    }

    pub(super) fn u32(&mut self, what: &str) -> Result<u32, LoadError> {
        Ok(u32::from_le_bytes(self.item(what)?))
    }

    /// Whether the bytes that have not been read start with these.
    #[cfg(feature = "nvdb")]
    pub(super) fn starts_with(&self, start: &[u8]) -> bool {
        self.rest.starts_with(start)
    }

    /// The next `length` bytes.
    #[cfg(any(feature = "nvdb", feature = "vdb"))]
    pub(super) fn bytes(&mut self, what: &str, length: u64) -> Result<&'a [u8], LoadError> {
        if length > self.rest.len() as u64 {
            return Err(LoadError::truncated(what, length, self.rest.len()));
        }
        let (bytes, rest) = self.rest.split_at(length as usize);
        self.rest = rest;
        Ok(bytes)
    }

    /// Passes over some bytes.
    #[cfg(feature = "hair")]
    pub(super) fn skip(&mut self, what: &str, bytes: u64) -> Result<(), LoadError> {
        self.items::<1>(what, bytes).map(drop)
    }
}

/// Three numbers from their bytes.
#[cfg(any(feature = "hair", feature = "vol"))]
pub(super) fn vec3(bytes: [u8; 12]) -> glam::Vec3 {
    let (numbers, _) = bytes.as_chunks::<4>();
    let number = |axis: usize| f32::from_le_bytes(numbers[axis]);
    glam::Vec3::new(number(0), number(1), number(2))
}

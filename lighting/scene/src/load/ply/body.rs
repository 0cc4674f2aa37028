//! The numbers in the body of a PLY file.

use super::header::{Encoding, Scalar};
use crate::load::LoadError;

/// Reads one number after the other.
#[derive(Debug)]
pub(super) struct Body<'a> {
    rest: &'a [u8],
    encoding: Encoding,
}

impl<'a> Body<'a> {
    pub(super) fn new(bytes: &'a [u8], encoding: Encoding) -> Self {
        Self {
            rest: bytes,
            encoding,
        }
    }

    /// Bytes that have not been read.
    pub(super) fn available(&self) -> usize {
        self.rest.len()
    }

    /// The next number, whatever its type.
    pub(super) fn number(&mut self, scalar: Scalar) -> Result<f64, LoadError> {
        if self.encoding == Encoding::Ascii {
            let word = self.word()?;
            return word.parse().map_err(|_| {
                LoadError::not_understood("a PLY value", word.as_bytes(), "a number")
            });
        }
        Ok(match scalar {
            Scalar::F32 => f64::from(f32::from_bits(self.bits::<4>()? as u32)),
            Scalar::F64 => f64::from_bits(self.bits::<8>()?),
            // At most 32 bits: exact.
            _ => self.binary_integer(scalar)? as f64,
        })
    }

    /// The next number, of an integer type.
    pub(super) fn integer(&mut self, scalar: Scalar) -> Result<i64, LoadError> {
        if self.encoding == Encoding::Ascii {
            let word = self.word()?;
            return word.parse().map_err(|_| match word.parse::<f64>() {
                Ok(number) => LoadError::bad_value("a PLY value", number, "an integer"),
                Err(_) => LoadError::not_understood("a PLY value", word.as_bytes(), "an integer"),
            });
        }
        self.binary_integer(scalar)
    }

    /// The length of a list.
    pub(super) fn list_length(&mut self, length: Scalar, item: Scalar) -> Result<u64, LoadError> {
        let value = self.integer(length)?;
        let count = u64::try_from(value).map_err(|_| {
            LoadError::bad_value("the length of a PLY list", value, "a number from 0 up")
        })?;
        let needed = match self.encoding {
            Encoding::Ascii => count.saturating_mul(2).saturating_sub(1),
            _ => count.saturating_mul(item.size() as u64),
        };
        if needed > self.available() as u64 {
            return Err(LoadError::truncated(
                format!("a PLY list of {count} items"),
                needed,
                self.available(),
            ));
        }
        Ok(count)
    }

    fn binary_integer(&mut self, scalar: Scalar) -> Result<i64, LoadError> {
        Ok(match scalar {
            Scalar::I8 => i64::from(self.bits::<1>()? as i8),
            Scalar::U8 => i64::from(self.bits::<1>()? as u8),
            Scalar::I16 => i64::from(self.bits::<2>()? as i16),
            Scalar::U16 => i64::from(self.bits::<2>()? as u16),
            Scalar::I32 => i64::from(self.bits::<4>()? as i32),
            Scalar::U32 | Scalar::F32 => i64::from(self.bits::<4>()? as u32),
            Scalar::F64 => self.bits::<8>()? as i64,
        })
    }

    /// The next `N` bytes as the low bits of an integer.
    fn bits<const N: usize>(&mut self) -> Result<u64, LoadError> {
        let Some((bytes, rest)) = self.rest.split_first_chunk::<N>() else {
            return Err(self.at_the_end(N as u64));
        };
        self.rest = rest;
        let append = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
        Ok(match self.encoding {
            Encoding::BigEndian => bytes.iter().fold(0, append),
            _ => bytes.iter().rev().fold(0, append),
        })
    }

    fn word(&mut self) -> Result<&'a str, LoadError> {
        let rest = self.rest.trim_ascii_start();
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        if length == 0 {
            return Err(self.at_the_end(1));
        }
        let (word, rest) = rest.split_at(length);
        self.rest = rest;
        std::str::from_utf8(word)
            .map_err(|_| LoadError::not_understood("a PLY value", word, "a number"))
    }

    fn at_the_end(&self, needed: u64) -> LoadError {
        LoadError::truncated("the next PLY value", needed, self.available())
    }
}

//! Values of a node as they are packed in a file.

use std::borrow::Cow;

use half::f16;

use super::{blosc, zip};
use crate::load::LoadError;
use crate::load::words::Words;

const WHAT: &str = "the values of an OpenVDB node";

/// Bits of a grid's compression.
const ZIP: u32 = 1;
const ACTIVE_MASK: u32 = 2;
const BLOSC: u32 = 4;

/// How the values of a grid are packed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Packing {
    flags: u32,
    /// Values are stored as half floats.
    is_half: bool,
}

impl Packing {
    pub(super) fn new(flags: u32, is_half: bool) -> Result<Self, LoadError> {
        if flags & !(ZIP | ACTIVE_MASK | BLOSC) != 0 {
            let what = "the compression of an OpenVDB grid";
            return Err(LoadError::bad_value(what, flags, "0 to 7"));
        }
        Ok(Self { flags, is_half })
    }

    /// Reads the values of a node, one for each bit of the mask that tells which are
    /// active, into `values`.
    pub(super) fn read(
        self,
        words: &mut Words<'_>,
        mask: &[u8],
        background: f32,
        values: &mut Vec<f32>,
    ) -> Result<(), LoadError> {
        let [kind] = words.item(WHAT)?;
        let inactive = Inactive::read(words, kind, mask.len(), background)?;
        let count = 8 * mask.len();
        let active: usize = mask.iter().map(|byte| byte.count_ones() as usize).sum();
        let inactive = inactive.filter(|_| self.flags & ACTIVE_MASK != 0);
        let stored = if inactive.is_some() { active } else { count };
        values.clear();
        if self.is_half {
            // What is nothing has not even a length.
            if stored > 0 {
                let bytes = self.bytes(words, 2 * stored)?;
                let (halves, _) = bytes.as_chunks::<2>();
                values.extend(halves.iter().map(|&half| f16::from_le_bytes(half).to_f32()));
            }
        } else {
            let bytes = self.bytes(words, 4 * stored)?;
            let (floats, _) = bytes.as_chunks::<4>();
            values.extend(floats.iter().map(|&float| f32::from_le_bytes(float)));
        }
        if let Some(inactive) = inactive {
            // From the back, where nothing is overwritten that is still to be moved.
            values.resize(count, 0.0);
            let mut next = active;
            for index in (0..count).rev() {
                values[index] = if is_on(mask, index) {
                    next -= 1;
                    values[next]
                } else {
                    inactive.value(index)
                };
            }
        }
        Ok(())
    }

    /// The next `length` bytes, once they are unpacked.
    fn bytes<'a>(self, words: &mut Words<'a>, length: usize) -> Result<Cow<'a, [u8]>, LoadError> {
        if self.flags & (ZIP | BLOSC) == 0 {
            return words.bytes(WHAT, length as u64).map(Cow::Borrowed);
        }
        let packed = i64::from_le_bytes(words.item(WHAT)?);
        if packed <= 0 {
            // They got no shorter.
            if packed.unsigned_abs() != length as u64 {
                let expected = "the length of the node's values";
                return Err(LoadError::bad_value(
                    WHAT,
                    format!("{packed} bytes"),
                    expected,
                ));
            }
            return words.bytes(WHAT, length as u64).map(Cow::Borrowed);
        }
        let packed = words.bytes(WHAT, packed.unsigned_abs())?;
        match self.flags & BLOSC {
            0 => zip::unpacked(WHAT, packed, length).map(Cow::Owned),
            _ => blosc::unpacked(packed, length),
        }
    }
}

/// Whether a bit of a mask is set.
pub(super) fn is_on(mask: &[u8], index: usize) -> bool {
    mask[index / 8] >> (index % 8) & 1 == 1
}

/// The values that are not active where those are not stored.
#[derive(Debug)]
struct Inactive<'a> {
    /// Where the mask is not set, and where it is.
    values: [f32; 2],
    mask: Option<&'a [u8]>,
}

impl<'a> Inactive<'a> {
    /// Reads what a node's kind says of them; `None` if all are stored.
    fn read(
        words: &mut Words<'a>,
        kind: u8,
        mask_bytes: usize,
        background: f32,
    ) -> Result<Option<Self>, LoadError> {
        let mut value = || words.item(WHAT).map(f32::from_le_bytes);
        let values = match kind {
            0 => [background; 2],
            1 | 3 => [-background, background],
            2 | 4 => [value()?, background],
            5 => [value()?, value()?],
            6 => return Ok(None),
            _ => {
                let what = "the kind of inactive values of an OpenVDB node";
                return Err(LoadError::bad_value(what, kind, "0 to 6"));
            }
        };
        let mask = match kind {
            3..=5 => Some(words.bytes(WHAT, mask_bytes as u64)?),
            _ => None,
        };
        Ok(Some(Self { values, mask }))
    }

    fn value(&self, index: usize) -> f32 {
        let is_second = self.mask.is_some_and(|mask| is_on(mask, index));
        self.values[usize::from(is_second)]
    }
}

//! How fine the grid of voxels is.

use crate::Error;

/// Number of voxels along each side of the cubic grid: a power of two from 8
/// to 2²⁰.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Resolution {
    log2: u8,
}

/// The smallest grid is one 8×8×8 node.
pub(crate) const MIN_LOG2: u8 = 3;
/// The most that a depth in f32 can tell apart with four bits to spare.
pub(crate) const MAX_LOG2: u8 = 20;

impl Resolution {
    /// A grid of `side` voxels along each axis.
    ///
    /// # Errors
    /// [`Error::Resolution`] if `side` is not a power of two from 8 to 2²⁰.
    pub fn new(side: u32) -> Result<Self, Error> {
        if side.is_power_of_two() {
            Self::from_log2(side.trailing_zeros()).ok_or(Error::Resolution(u64::from(side)))
        } else {
            Err(Error::Resolution(u64::from(side)))
        }
    }

    /// The grid with `2^log2` voxels along each axis; none if that is out of
    /// range.
    pub(crate) fn from_log2(log2: u32) -> Option<Self> {
        let log2 = u8::try_from(log2).ok()?;
        (MIN_LOG2..=MAX_LOG2)
            .contains(&log2)
            .then_some(Self { log2 })
    }

    /// Voxels along each axis.
    pub fn side(self) -> u32 {
        1 << self.log2
    }

    /// Logarithm of [`Self::side`] to base 2.
    pub fn log2(self) -> u32 {
        u32::from(self.log2)
    }

    /// The level of the root: nodes of level `l` are `8 · 2^l` voxels wide.
    pub(crate) fn root_level(self) -> usize {
        usize::from(self.log2 - MIN_LOG2)
    }
}

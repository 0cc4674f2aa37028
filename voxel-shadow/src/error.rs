//! What can go wrong.

use epipolar::Resolution;

/// Why a step or a query could not be carried out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Things that belong together have different numbers of voxels.
    #[error("{what} has the resolution {actual:?}, expected {expected:?}")]
    Resolution {
        /// What does not fit.
        what: &'static str,
        /// The resolution that it should have.
        expected: Resolution,
        /// The resolution that it has.
        actual: Resolution,
    },
    /// A number outside of its range.
    #[error("{what} is {value}, expected {expected}")]
    BadValue {
        /// Which number.
        what: &'static str,
        /// As it was given.
        value: f64,
        /// What would have been right.
        expected: &'static str,
    },
    /// An atlas has too few tiles.
    #[error("an atlas of {tiles} tiles was given, expected at least {needed}")]
    Tile {
        /// How many it should have.
        needed: usize,
        /// How many it has.
        tiles: usize,
    },
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] gpu_backend::Error),
}

pub(crate) fn same_resolution(
    what: &'static str,
    expected: Resolution,
    actual: Resolution,
) -> Result<(), Error> {
    if expected == actual {
        return Ok(());
    }
    Err(Error::Resolution {
        what,
        expected,
        actual,
    })
}

pub(crate) fn same_length(what: &'static str, expected: usize, actual: usize) -> Result<(), Error> {
    if expected == actual {
        return Ok(());
    }
    Err(Error::Backend(gpu_backend::Error::LengthMismatch {
        what,
        expected,
        actual,
    }))
}

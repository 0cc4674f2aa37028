//! What can go wrong.

/// Why something could not be made or a step not be carried out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A part of a blocker that is not a number in its range.
    #[error("{what} of the segment from {entry} to {exit} is {value}, expected {expected}")]
    BadSegment {
        /// Depth at which the segment was said to start.
        entry: f32,
        /// Depth at which it was said to end.
        exit: f32,
        /// Which of its numbers is wrong.
        what: &'static str,
        /// That number.
        value: f32,
        /// What would have been right.
        expected: &'static str,
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
    /// Two things that belong together differ in length.
    #[error("{what} has {actual} elements, but {expected} were expected")]
    LengthMismatch {
        /// Which one is wrong.
        what: &'static str,
        /// Elements it should have.
        expected: usize,
        /// Elements it has.
        actual: usize,
    },
    /// Lists that do not start where the one before them ends.
    #[error("the segments of texel {texel} run from {start} to {end} of {available}")]
    BadOffsets {
        /// Which texel, counted along the rows.
        texel: usize,
        /// Where its list is said to start.
        start: u32,
        /// Where its list is said to end.
        end: u32,
        /// How many segments there are.
        available: usize,
    },
    /// A map of more texels than memory can hold.
    #[error("a map of {width} by {height} texels needs {requested} bytes, which cannot be had")]
    TooLarge {
        /// Texels along a row.
        width: usize,
        /// Rows.
        height: usize,
        /// Bytes asked for; `u64::MAX` if the number itself overflowed.
        requested: u64,
    },
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] gpu_backend::Error),
}

pub(crate) fn same_length(what: &'static str, expected: usize, actual: usize) -> Result<(), Error> {
    if expected == actual {
        return Ok(());
    }
    Err(Error::LengthMismatch {
        what,
        expected,
        actual,
    })
}

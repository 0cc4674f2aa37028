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
    /// A map of more texels than the backend can hold, or bind.
    #[error(
        "a map of {width} by {height} texels needs {requested} bytes, but the limit is {limit} bytes: {} by {} texels would fit",
        .fits[0], .fits[1]
    )]
    DoesNotFit {
        /// Texels along a row.
        width: usize,
        /// Rows.
        height: usize,
        /// Bytes asked for.
        requested: u64,
        /// The largest number of bytes that would have been accepted.
        limit: u64,
        /// Width and height of a map of that shape that would fit.
        fits: [usize; 2],
    },
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] gpu_backend::Error),
}

/// What a backend says of a buffer, said of a map with so many bytes per texel.
pub(crate) fn does_not_fit(
    [width, height]: [usize; 2],
    texel: usize,
) -> impl Fn(gpu_backend::Error) -> Error {
    move |error| match error {
        gpu_backend::Error::TooLarge {
            requested, limit, ..
        } => {
            let most = limit / texel as u64;
            let share = (most as f64 / (width as f64 * height as f64)).sqrt();
            let columns = ((width as f64 * share) as usize).max(1);
            let rows = (most as usize / columns).min(height);
            Error::DoesNotFit {
                width,
                height,
                requested,
                limit,
                fits: [columns, rows],
            }
        }
        other => Error::Backend(other),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_that_is_too_large_is_named_with_one_that_would_fit() {
        let error = does_not_fit([4096, 2048], 64)(gpu_backend::Error::TooLarge {
            what: "a buffer",
            requested: 512 << 20,
            limit: 128 << 20,
        });
        assert_eq!(
            error.to_string(),
            "a map of 4096 by 2048 texels needs 536870912 bytes, but the limit is 134217728 \
             bytes: 2048 by 1024 texels would fit"
        );
    }
}

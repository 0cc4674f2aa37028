//! What constructors turn away.

/// A value that an evaluator cannot be made from.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
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
}

impl Error {
    pub(crate) fn bad_value(
        what: &'static str,
        value: impl Into<f64>,
        expected: &'static str,
    ) -> Self {
        Self::BadValue {
            what,
            value: value.into(),
            expected,
        }
    }
}

//! What constructors turn away.

/// A value that an evaluator cannot be made from.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number outside of its range.
    #[error("{what} is {}, expected {expected}", shown(*value))]
    BadValue {
        /// Which number.
        what: &'static str,
        /// As it was given.
        value: f64,
        /// The values that are accepted.
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

/// The shortest text that means this number: most were given as f32.
fn shown(value: f64) -> String {
    let single = value as f32;
    if f64::from(single) == value {
        single.to_string()
    } else {
        value.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_shown_as_they_were_given() {
        let message = |value: f64| Error::bad_value("g", value, "less").to_string();
        assert_eq!(message(1.1_f32.into()), "g is 1.1, expected less");
        assert_eq!(message(1.1), "g is 1.1, expected less");
        assert_eq!(message(f64::NAN), "g is NaN, expected less");
    }
}

//! What ends the program early.

use std::error::Error;
use std::fmt;

/// A message for the user, in one line or a few: what is wrong, and with what.
///
/// Made from any error by `?`; its causes are appended unless the message says
/// them already.
pub(crate) struct Failure {
    message: String,
}

impl Failure {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
        }
    }

    /// The same, saying that it concerns the scene `name`.
    #[must_use]
    pub(crate) fn about(self, name: &str) -> Self {
        if self.message.contains(name) {
            self
        } else {
            Self::new(format!("{name}: {self}"))
        }
    }
}

impl<E: Error> From<E> for Failure {
    fn from(error: E) -> Self {
        let mut message = error.to_string();
        let mut cause = error.source();
        while let Some(error) = cause {
            let text = error.to_string();
            if !message.contains(&text) {
                message = format!("{message}: {text}");
            }
            cause = error.source();
        }
        Self { message }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl fmt::Debug for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

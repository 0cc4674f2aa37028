//! Failures, which end the program early.

use std::error::Error;
use std::fmt;

/// A message for the user, in one line or a few: what is wrong, and with what.
///
/// Made from any error by `?`; its causes are appended unless the message says
/// them already.
pub(crate) struct Failure {
    message: String,
    code: u8,
}

/// The exit code for anything that the user can set right; clap returns the same for a wrong
/// command line.
pub(crate) const USER_ERROR: u8 = 2;

/// The exit code if there is a result, and nothing in it.
const NOTHING: u8 = 1;

impl Failure {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            code: USER_ERROR,
        }
    }

    /// Everything went well and led to nothing.
    pub(crate) fn nothing(message: impl Into<String>) -> Self {
        Self {
            code: NOTHING,
            ..Self::new(message)
        }
    }

    /// The exit code.
    pub(crate) fn code(&self) -> u8 {
        self.code
    }

    /// The same, saying that it concerns the scene `name`.
    #[must_use]
    pub(crate) fn about(self, name: &str) -> Self {
        if self.message.contains(name) {
            self
        } else {
            Self {
                message: format!("{name}: {self}"),
                ..self
            }
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
        Self::new(message)
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

//! Why a scene file cannot be used.

use std::io;
use std::path::PathBuf;

use crate::SceneError;

/// Why a scene file cannot be used. Every message names what is at fault and
/// its value; none names the scene file itself, which the caller knows.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// A file cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The scene file, or one it refers to.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Something is longer than the bytes that are there.
    #[error("{what} needs {needed} bytes, but there are only {available}")]
    Truncated {
        /// The part of the file.
        what: String,
        /// Bytes it needs, as far as is known.
        needed: u64,
        /// Bytes that are there.
        available: u64,
    },
    /// The file uses something that is not read here.
    #[error("{0} is not supported")]
    Unsupported(String),
    /// The text is not JSON, or not a glTF document.
    #[error("malformed glTF document: {0}")]
    Json(String),
    /// A value outside its domain.
    #[error("{what} is {value}, expected {expected}")]
    BadValue {
        /// Which value.
        what: String,
        /// The value as text.
        value: String,
        /// Its domain in words.
        expected: &'static str,
    },
    /// The file can be read, but its scene cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// More data than a scene may have.
    #[error("{what} needs {bytes} bytes, more than the limit of {limit}")]
    TooLarge {
        /// The part of the scene.
        what: String,
        /// Bytes it needs.
        bytes: u64,
        /// Bytes that are allowed.
        limit: u64,
    },
}

impl LoadError {
    pub(crate) fn bad_value(
        what: impl Into<String>,
        value: impl ToString,
        expected: &'static str,
    ) -> Self {
        // Values are text from the file: a page of it helps nobody.
        let mut value = value.to_string();
        if value.chars().count() > 80 {
            value = value.chars().take(80).chain("…".chars()).collect();
        }
        Self::BadValue {
            what: what.into(),
            value,
            expected,
        }
    }

    pub(crate) fn truncated(what: impl Into<String>, needed: u64, available: usize) -> Self {
        Self::Truncated {
            what: what.into(),
            needed,
            available: available as u64,
        }
    }
}

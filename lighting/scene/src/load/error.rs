//! Why a scene file cannot be used.

use std::io;
use std::path::PathBuf;

use crate::SceneError;

/// Why a scene file cannot be used. Every message names what is at fault; none
/// names the scene file itself, which the caller knows. Numbers and names that
/// were understood as such may be repeated, text that was not is only counted:
/// the file may be one that was never meant to be read aloud.
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

/// A name from a file as it may be shown: at most 60 characters, none of which
/// controls a terminal.
pub fn printable(name: &str) -> String {
    let shown = |c: char| if c.is_control() { '?' } else { c };
    name.chars().take(60).map(shown).collect()
}

impl LoadError {
    pub(crate) fn bad_value(
        what: impl Into<String>,
        value: impl ToString,
        expected: &'static str,
    ) -> Self {
        // A page of numbers helps nobody.
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

    /// Text that cannot be understood; none of it is repeated.
    pub(crate) fn not_understood(
        what: impl Into<String>,
        text: &[u8],
        expected: &'static str,
    ) -> Self {
        let bytes = text.len();
        let value = if text.is_ascii() {
            format!("{bytes} other characters")
        } else {
            format!("{bytes} other bytes")
        };
        Self::bad_value(what, value, expected)
    }

    pub(crate) fn truncated(what: impl Into<String>, needed: u64, available: usize) -> Self {
        Self::Truncated {
            what: what.into(),
            needed,
            available: available as u64,
        }
    }
}

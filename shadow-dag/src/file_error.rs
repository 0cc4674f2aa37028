//! What can be wrong with a file of shadows.

/// What a file begins with.
pub(crate) const MAGIC: [u8; 8] = *b"CPVSDAG\0";

/// Why bytes are no shadows.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// They do not begin like a file of this kind.
    #[error("not a file of shadows: it does not begin with {MAGIC:?}")]
    Magic,
    /// They are a set of grids, or the six grids around a lamp in an earlier form.
    #[error(
        "a file of the grids of {lights} light(s): read it with ShadowSet::from_bytes, or ShadowSet::read if it may be compressed"
    )]
    Set {
        /// How many lights it says it has.
        lights: u32,
    },
    /// They are what an unfinished bake left, or a part of one.
    #[error(
        "a checkpoint or a part of a bake, not its shadows; resume the bake or merge its parts first"
    )]
    Unfinished,
    /// Another version wrote them.
    #[error("version {0} of the format, expected 1")]
    Version(u32),
    /// They are compressed, which no question can be asked of.
    #[error("a compressed file: decode it with ShadowDag::read or ShadowSet::read")]
    Compressed,
    /// Compressed nodes that cannot be: more of them than such a file can have,
    /// or not the masks that its head announces.
    #[error("the compressed nodes are damaged, or more than a file of this length can hold")]
    Code,
    /// The end is missing.
    #[error("{given} bytes, expected at least {expected}: the file is cut off")]
    Truncated {
        /// Bytes that there are.
        given: u64,
        /// Bytes that there must be.
        expected: u64,
    },
    /// There is something behind the end.
    #[error("{given} bytes, expected {expected}")]
    TooLong {
        /// Bytes that there are.
        given: u64,
        /// Bytes that there should be.
        expected: u64,
    },
    /// A number of the head that makes no sense.
    #[error("{what} cannot be {value}")]
    Header {
        /// Which number.
        what: &'static str,
        /// As it was read.
        value: u64,
    },
    /// The space of the light cannot be one.
    #[error("the space of the light is singular, not finite or has no depth")]
    Light,
    /// The numbers that describe a level make no sense.
    #[error("the sizes of level {level} do not fit together")]
    Level {
        /// The level, 0 for the finest.
        level: u32,
    },
    /// The content was changed.
    #[error("the checksum is {found:#010x}, expected {expected:#010x}: the file is damaged")]
    Checksum {
        /// Of the content.
        found: u32,
        /// As the file says.
        expected: u32,
    },
    /// A node that cannot be.
    #[error("the node at {at} of level {level} refers to something that is not there")]
    Node {
        /// The level, 0 for the finest.
        level: u32,
        /// Its number, or its first word in the plain form.
        at: u32,
    },
}

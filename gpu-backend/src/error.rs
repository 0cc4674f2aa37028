/// What can go wrong on any backend.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A buffer would be larger than the device or the machine can hold.
    #[error("{what} needs {requested} bytes, but the limit is {limit} bytes")]
    TooLarge {
        /// What the memory was for.
        what: &'static str,
        /// Bytes asked for; `u64::MAX` if the number itself overflowed.
        requested: u64,
        /// The largest number of bytes that would have been accepted.
        limit: u64,
    },
    /// Two buffers that belong together differ in length.
    #[error("{what} has {actual} elements, but {expected} were expected")]
    LengthMismatch {
        /// Which buffer is wrong.
        what: &'static str,
        /// Elements it should have.
        expected: usize,
        /// Elements it has.
        actual: usize,
    },
    /// The operating system refused to start worker threads.
    #[error("cannot start {threads} worker threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// The system's own words.
        reason: String,
    },
}

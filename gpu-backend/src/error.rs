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
    /// There is nothing to run shaders on.
    #[error("no GPU adapter: {reason}")]
    NoAdapter {
        /// What was looked for and what there was.
        reason: String,
    },
    /// The device has gone: removed, reset by the driver, or destroyed. All
    /// buffers on it are gone too; only a new device helps.
    #[error("the device was lost: {reason}")]
    DeviceLost {
        /// What the driver said.
        reason: String,
    },
    /// The device refused an allocation that is within its limits.
    #[error("the device ran out of memory for {what}")]
    OutOfMemory {
        /// What the memory was for.
        what: String,
    },
    /// A count exceeds what the device supports.
    #[error("{what} needs {requested} {unit}, but the device's limit is {limit}")]
    Limit {
        /// Which step.
        what: &'static str,
        /// What is counted.
        unit: &'static str,
        /// How many are needed.
        requested: u64,
        /// How many there may be.
        limit: u64,
    },
    /// A buffer of the caller's cannot be used as it was made.
    #[error("a buffer of {bytes} bytes with usage {usage} was given, expected {expected}")]
    UnsuitableBuffer {
        /// Its size.
        bytes: u64,
        /// What it may be used for.
        usage: String,
        /// What it should have been.
        expected: String,
    },
    /// A step was asked to read what it writes.
    #[error("{what} was given one buffer twice, and writes to it")]
    Aliased {
        /// Which step.
        what: &'static str,
    },
    /// The device's own checks found a mistake, in a shader for example.
    #[error("{what} was rejected: {reason}")]
    Rejected {
        /// Which step or object.
        what: String,
        /// The driver's words.
        reason: String,
    },
}

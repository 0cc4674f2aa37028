//! What can go wrong while shadows are built.

/// Why no shadows could be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A resolution that is no power of two, too small or too large.
    #[error("a resolution of {0}, expected a power of two from 8 to 1048576")]
    Resolution(u64),
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
    /// A depth that is not a number.
    #[error("the {map} depth of texel ({x}, {y}) is not a number")]
    NotANumber {
        /// Which of the two maps.
        map: &'static str,
        /// Column of the texel.
        x: u32,
        /// Row of the texel.
        y: u32,
    },
    /// A slice of the wrong length.
    #[error("{what}: {given} elements, expected {expected}")]
    Length {
        /// What the slice holds.
        what: &'static str,
        /// Elements given.
        given: usize,
        /// Elements expected.
        expected: usize,
    },
    /// A vertex that is nowhere.
    #[error("vertex {vertex} is at {position:?}, expected finite coordinates")]
    NotFinite {
        /// Which vertex.
        vertex: usize,
        /// Its coordinates.
        position: [f32; 3],
    },
    /// A triangle that names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex}, but there are {vertices}")]
    NoSuchVertex {
        /// Which triangle.
        triangle: usize,
        /// The vertex that it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// The result has more nodes on one level than a reference can name.
    #[error("more than {limit} nodes on one level; a lower resolution is needed")]
    TooManyNodes {
        /// The most there can be.
        limit: u32,
    },
    /// A bake was told to stop before its last tile.
    #[error("stopped after {finished} of {tiles} tiles")]
    Cancelled {
        /// Tiles that are finished.
        finished: usize,
        /// All tiles.
        tiles: usize,
    },
    /// A rebuild that does not follow the grid as it is.
    #[error("the rebuild was begun before another one was put in place")]
    Outdated,
    /// The source of depths failed.
    #[error("the depths of the tile at ({x}, {y}) could not be read")]
    Source {
        /// First column of the tile.
        x: u32,
        /// First row of the tile.
        y: u32,
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A problem of memory or threads.
    #[error(transparent)]
    Backend(#[from] gpu_backend::Error),
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

/// # Errors
/// [`Error::Length`] unless both are the same.
pub(crate) fn same_length(what: &'static str, expected: usize, given: usize) -> Result<(), Error> {
    if expected == given {
        return Ok(());
    }
    Err(Error::Length {
        what,
        given,
        expected,
    })
}

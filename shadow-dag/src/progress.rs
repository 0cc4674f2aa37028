//! How far work is that is done tile by tile.

use crate::Error;

/// How far a bake is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Tiles that are finished.
    pub finished: usize,
    /// All tiles. They take different times, those without casters none.
    pub tiles: usize,
}

impl Progress {
    /// True if no tile is missing.
    pub fn is_complete(self) -> bool {
        self.finished == self.tiles
    }

    pub(crate) fn cancelled(self) -> Error {
        Error::Cancelled {
            finished: self.finished,
            tiles: self.tiles,
        }
    }
}

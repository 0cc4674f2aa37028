//! Files that are read as a whole.

use std::io;
use std::path::Path;

use lighting::scene::load::read_regular;

/// No file that the program reads is longer: 64 GiB, what a bake of the largest grids may
/// leave unfinished.
const MAX_BYTES: u64 = 1 << 36;

/// The contents of a regular file. Pipes and devices may never end.
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    read_regular(path, MAX_BYTES)
}

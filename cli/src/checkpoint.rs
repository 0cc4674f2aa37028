//! What an interrupted bake leaves: the grids that are finished, and the tiles
//! of the one that is not.
//!
//! A head, the number of grids and the length of each as little-endian numbers
//! of 64 bits, the grids, and what `Bake::save` writes. Both of those bring
//! checks of their own.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use shadow_dag::{Bake, ShadowDag};

use crate::failure::Failure;
use crate::output::PendingFile;

const MAGIC: [u8; 8] = *b"CPVSGRID";

/// Where the checkpoint of `output` is.
pub(crate) fn path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".part");
    PathBuf::from(name)
}

/// Replaces the checkpoint at `path`.
pub(crate) fn save(path: &Path, grids: &[ShadowDag], bake: &Bake<'_>) -> Result<(), Failure> {
    PendingFile::create(path)?.finish_with(|out| {
        out.write_all(&MAGIC)?;
        out.write_all(&(grids.len() as u64).to_le_bytes())?;
        for grid in grids {
            out.write_all(&(grid.as_bytes().len() as u64).to_le_bytes())?;
        }
        for grid in grids {
            out.write_all(grid.as_bytes())?;
        }
        bake.save(out)
    })
}

/// The bytes of a checkpoint, if there is one at `path`.
pub(crate) fn read(path: &Path) -> Result<Option<Vec<u8>>, Failure> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(about(path, error)),
    }
}

/// The grids of a checkpoint, and the tiles of the next.
pub(crate) fn load(bytes: &[u8]) -> Result<(Vec<ShadowDag>, &[u8]), Failure> {
    let damaged = || Failure::new("it is no checkpoint of a bake, or damaged");
    let rest = bytes.strip_prefix(&MAGIC).ok_or_else(damaged)?;
    let (count, mut rest) = rest.split_first_chunk().ok_or_else(damaged)?;
    // A light has at most six grids, so five can be finished before the last.
    let count = u64::from_le_bytes(*count);
    if count > 5 {
        return Err(damaged());
    }
    let mut lengths = Vec::new();
    for _ in 0..count {
        let (length, after) = rest.split_first_chunk().ok_or_else(damaged)?;
        lengths.push(usize::try_from(u64::from_le_bytes(*length))?);
        rest = after;
    }
    let mut grids = Vec::new();
    for length in lengths {
        let (grid, after) = rest.split_at_checked(length).ok_or_else(damaged)?;
        grids.push(ShadowDag::from_bytes(grid.to_vec())?);
        rest = after;
    }
    Ok((grids, rest))
}

/// Removes a checkpoint that is not needed any more.
pub(crate) fn remove(path: &Path) -> Result<(), Failure> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(about(path, error)),
        _ => Ok(()),
    }
}

fn about(path: &Path, error: io::Error) -> Failure {
    Failure::from(error).about(&path.display().to_string())
}

//! The file beside the output in which an interrupted bake leaves its finished tiles.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use shadow_dag::SetBake;

use crate::failure::Failure;
use crate::file;
use crate::output::PendingFile;

/// The path of the checkpoint of `output`.
pub(crate) fn path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".part");
    PathBuf::from(name)
}

/// Replaces the checkpoint at `path`.
pub(crate) fn save(path: &Path, bake: &SetBake<'_>) -> Result<(), Failure> {
    PendingFile::create(path)?
        .finish_with(|out| bake.save(out))
        .map(|_| ())
}

/// The bytes of a checkpoint, if there is one at `path`.
pub(crate) fn read(path: &Path) -> Result<Option<Vec<u8>>, Failure> {
    match file::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(about(path, error)),
    }
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

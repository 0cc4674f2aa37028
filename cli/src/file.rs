//! Files that are read as a whole.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// No file that the program reads is longer: 4 GiB.
const MAX_BYTES: u64 = 1 << 32;

/// The contents of a regular file. Pipes and devices may never end.
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    let found = std::fs::metadata(path)?;
    if !found.is_file() {
        let kind = if found.is_dir() {
            "it is a folder"
        } else {
            "it is no regular file"
        };
        return Err(io::Error::other(kind));
    }
    let too_long = || io::Error::other(format!("it has more than {MAX_BYTES} bytes"));
    if found.len() > MAX_BYTES {
        return Err(too_long());
    }
    let mut bytes = Vec::with_capacity(found.len() as usize);
    // The file may grow while it is read.
    File::open(path)?
        .take(MAX_BYTES + 1)
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(too_long());
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_read() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a");
        std::fs::write(&path, "content").unwrap();
        assert_eq!(read(&path).unwrap(), b"content");
        let error = read(place.path()).unwrap_err().to_string();
        assert!(error.contains("folder"), "{error}");
        assert!(read(&place.path().join("b")).is_err());
        if cfg!(target_os = "linux") {
            let error = read(Path::new("/dev/zero")).unwrap_err().to_string();
            assert!(error.contains("no regular file"), "{error}");
        }
    }
}

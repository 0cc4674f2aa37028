//! Files and decoded data of bounded size, and notes of bounded number.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use super::LoadError;

/// Scene files and the files they refer to are at most this long, bytes.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// What is decoded from a file takes at most this much memory, bytes. Without
/// a limit a small file could ask for any amount by using its data repeatedly.
pub const MAX_DECODED_BYTES: u64 = 4 << 30;

/// More notes than this help nobody.
const MAX_NOTES: usize = 50;

/// The contents of a scene file, or of one it refers to.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, LoadError> {
    read_regular(path, MAX_FILE_BYTES).map_err(|source| LoadError::Io {
        path: path.to_path_buf(),
        source,
    })
}

/// The contents of a regular file of at most `limit` bytes. Pipes and devices may
/// never end.
///
/// # Errors
/// What the system says; [`io::ErrorKind::FileTooLarge`] beyond the limit, and
/// [`io::ErrorKind::Other`] for what is no regular file.
pub fn read_regular(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let found = std::fs::metadata(path)?;
    if !found.is_file() {
        let kind = match found.is_dir() {
            true => "it is a folder",
            false => "it is no regular file",
        };
        return Err(io::Error::other(kind));
    }
    let too_large = || {
        let why = format!("it has more than {limit} bytes");
        io::Error::new(io::ErrorKind::FileTooLarge, why)
    };
    if found.len() > limit {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    let length = usize::try_from(found.len()).map_err(|_| too_large())?;
    bytes
        .try_reserve_exact(length)
        .map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    // The file may grow while it is read.
    let file = File::open(path)?;
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(too_large());
    }
    Ok(bytes)
}

/// The folder of a scene file, and another one that it may take files from.
#[derive(Debug)]
pub(super) struct Folder {
    own: PathBuf,
    assets: Option<PathBuf>,
}

impl Folder {
    pub(super) fn of(file: &Path, assets: Option<&Path>) -> Self {
        let own = match file.parent() {
            Some(parent) if parent != Path::new("") => parent.to_path_buf(),
            _ => PathBuf::from("."),
        };
        Self {
            own,
            assets: assets.map(Path::to_path_buf),
        }
    }

    /// The contents of a file, given its path relative to the scene file. It
    /// has to be inside one of the two folders, symbolic links followed.
    pub(super) fn read(&self, path: &str) -> Result<Vec<u8>, LoadError> {
        let outside = || {
            LoadError::bad_value(
                "a file that the scene refers to",
                format!("{} levels up", path.matches("..").count().max(1)),
                "a file in the folder of the scene, or below the folder for assets",
            )
        };
        let relative = Path::new(path);
        let goes_up = relative
            .components()
            .any(|part| part == Component::ParentDir);
        let is_rooted = relative
            .components()
            .any(|part| matches!(part, Component::RootDir | Component::Prefix(_)));
        // Whether a file outside is there is none of the scene's business.
        if is_rooted || (goes_up && self.assets.is_none()) {
            return Err(outside());
        }
        let joined = self.own.join(relative);
        let resolve = |path: &Path| {
            std::fs::canonicalize(path).map_err(|source| LoadError::Io {
                path: path.to_path_buf(),
                source,
            })
        };
        let mut folders = vec![resolve(&self.own)?];
        if let Some(assets) = &self.assets {
            folders.push(resolve(assets)?);
        }
        let found = match resolve(&joined) {
            Ok(found) => found,
            Err(_) if goes_up => return Err(outside()),
            Err(error) => return Err(error),
        };
        if !folders.iter().any(|folder| found.starts_with(folder)) {
            return Err(outside());
        }
        read_file(&found).map_err(|error| match error {
            LoadError::Io { source, .. } => LoadError::Io {
                path: joined,
                source,
            },
            other => other,
        })
    }
}

/// Memory that decoded data may still take.
#[derive(Debug)]
pub(super) struct Budget {
    limit: u64,
    left: u64,
}

impl Budget {
    pub(super) fn new(limit: u64) -> Self {
        Self { limit, left: limit }
    }

    /// How much is left, bytes.
    #[cfg(feature = "gltf")]
    pub(super) fn left(&self) -> u64 {
        self.left
    }

    /// Sets `count` items of `size` bytes aside, before they are allocated.
    pub(super) fn take(&mut self, what: &str, count: u64, size: usize) -> Result<(), LoadError> {
        let bytes = count.saturating_mul(size as u64);
        match self.left.checked_sub(bytes) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err(LoadError::TooLarge {
                what: format!("the decoded scene, at {what},"),
                bytes: bytes.saturating_add(self.limit - self.left),
                limit: self.limit,
            }),
        }
    }
}

/// Sentences for the user, each only once.
#[derive(Debug, Default)]
pub(super) struct Notes {
    notes: Vec<String>,
    left_out: u64,
}

impl Notes {
    pub(super) fn add(&mut self, note: impl Into<String>) {
        let note = note.into();
        if self.notes.contains(&note) {
            return;
        }
        if self.notes.len() < MAX_NOTES {
            self.notes.push(note);
        } else {
            self.left_out += 1;
        }
    }

    pub(super) fn into_vec(mut self) -> Vec<String> {
        if self.left_out > 0 {
            self.notes
                .push(format!("{} more notes of this kind", self.left_out));
        }
        self.notes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_budget_is_spent_once() {
        let mut budget = Budget::new(80);
        assert!(budget.take("half", 10, 4).is_ok());
        assert!(budget.take("everything", u64::MAX, 16).is_err());
        assert!(budget.take("half", 10, 4).is_ok());
        let error = budget.take("meshes", 1, 1).unwrap_err();
        assert!(error.to_string().contains("at meshes"), "{error}");
    }

    #[test]
    fn notes_are_not_repeated_and_not_endless() {
        let mut notes = Notes::default();
        for i in 0..100 {
            notes.add(format!("{i}"));
            notes.add("0");
        }
        let notes = notes.into_vec();
        assert_eq!(notes.len(), MAX_NOTES + 1);
        assert!(notes[MAX_NOTES].starts_with("50 more"));
    }

    #[test]
    fn files_outside_of_the_folders_are_not_read() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        for folder in ["scene/sub", "assets/sub", "secret"] {
            std::fs::create_dir_all(at(folder)).unwrap();
        }
        for file in ["scene/sub/a", "assets/sub/a", "secret/a"] {
            std::fs::write(at(file), file).unwrap();
        }
        let scene = at("scene/scene.gltf");
        let read = |assets: Option<&Path>, path: &str| {
            let contents = Folder::of(&scene, assets).read(path);
            contents.map(|bytes| String::from_utf8(bytes).unwrap())
        };
        let assets = at("assets");
        assert_eq!(read(None, "sub/a").unwrap(), "scene/sub/a");
        assert_eq!(
            read(Some(&assets), "../assets/sub/a").unwrap(),
            "assets/sub/a"
        );
        for (assets, path) in [
            (None, "../secret/a"),
            (None, "../secret/none"),
            (None, "../assets/sub/a"),
            (None, "/etc/passwd"),
            (Some(&*assets), "../secret/a"),
            (Some(&*assets), "../secret/none"),
            (Some(&*assets), "/etc/passwd"),
        ] {
            let error = read(assets, path).unwrap_err().to_string();
            assert!(
                error.contains("in the folder of the scene"),
                "{path}: {error}"
            );
        }
        let error = read(None, "none").unwrap_err().to_string();
        assert!(error.contains("none"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_out_of_the_folder_is_not_followed() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("scene");
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(root.path().join("secret"), "secret").unwrap();
        std::os::unix::fs::symlink("../secret", folder.join("link")).unwrap();
        let error = Folder::of(&folder.join("scene.gltf"), None).read("link");
        assert!(error.unwrap_err().to_string().contains("in the folder"));
    }

    #[test]
    fn only_regular_files_are_read() {
        let error = read_file(&std::env::temp_dir()).unwrap_err();
        assert!(error.to_string().contains("folder"), "{error}");
        let error = read_file(Path::new("no/such/file.glb")).unwrap_err();
        assert!(error.to_string().contains("file.glb"), "{error}");
    }
}

//! Files and folders that appear whole or not at all.
//!
//! Everything is written under a temporary name beside its place and renamed
//! at the end. The temporary name is taken before the long work, so that a
//! place that cannot be written is found out at once.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempDir};

use crate::failure::Failure;

/// A file that will replace `path` when it is complete.
pub(crate) struct PendingFile {
    path: PathBuf,
    file: NamedTempFile,
}

impl PendingFile {
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        if path.is_dir() {
            return Err(cannot_write(path, "it is a folder"));
        }
        let mut builder = Builder::new();
        builder.prefix(".crepuscular-");
        #[cfg(unix)]
        let builder = {
            use std::os::unix::fs::PermissionsExt;
            // As any new file: the umask takes away what it must.
            builder.permissions(fs::Permissions::from_mode(0o666))
        };
        let file = builder
            .tempfile_in(parent(path))
            .map_err(|error| cannot_write(path, reason(&error)))?;
        Ok(Self {
            path: path.into(),
            file,
        })
    }

    pub(crate) fn finish(self, content: &[u8]) -> Result<(), Failure> {
        self.finish_with(|out| out.write_all(content))
    }

    /// The same, for content that need not be in memory as a whole.
    pub(crate) fn finish_with(
        mut self,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        write(&mut self.file)
            .and_then(|()| self.file.flush())
            .map_err(|error| cannot_write(&self.path, reason(&error)))?;
        match self.file.persist(&self.path) {
            Ok(_) => Ok(()),
            Err(error) => Err(cannot_write(&self.path, reason(&error.error))),
        }
    }
}

/// A folder of files that will replace `path` when it is complete.
pub(crate) struct PendingFolder {
    /// As the user wrote it.
    given: PathBuf,
    /// Where it leads to.
    path: PathBuf,
    folder: TempDir,
    earlier: Earlier,
}

/// What tells an earlier folder, which may be replaced, from others.
#[derive(Clone, Copy)]
struct Earlier {
    /// Whether a file of it may have that name.
    is_ours: fn(&str) -> bool,
    /// The file whose beginning must contain `mark`.
    marked: &'static str,
    mark: &'static str,
}

impl PendingFolder {
    /// Only a folder that holds nothing but files whose names `is_ours` accepts may
    /// be replaced, and the one called `marked` must contain `mark`.
    pub(crate) fn create(
        path: &Path,
        is_ours: fn(&str) -> bool,
        marked: &'static str,
        mark: &'static str,
    ) -> Result<Self, Failure> {
        let given = path.to_owned();
        let earlier = Earlier {
            is_ours,
            marked,
            mark,
        };
        // A link or a path such as `..` stands for the folder it leads to.
        let path = if path.exists() {
            check_replaceable(path, earlier)?;
            path.canonicalize()
                .map_err(|error| cannot_write(path, reason(&error)))?
        } else if path.symlink_metadata().is_ok() {
            return Err(cannot_write(path, "it is a link that leads nowhere"));
        } else {
            path.into()
        };
        let name = path
            .file_name()
            .ok_or_else(|| cannot_write(&path, "it does not name a folder"))?;
        let mut prefix = name.to_os_string();
        prefix.push(".tmp-");
        let mut builder = Builder::new();
        builder.prefix(&prefix);
        #[cfg(unix)]
        let builder = {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o777))
        };
        let folder = builder
            .tempdir_in(parent(&path))
            .map_err(|error| cannot_write(&path, reason(&error)))?;
        Ok(Self {
            given,
            path,
            folder,
            earlier,
        })
    }

    pub(crate) fn write(&self, name: &str, content: &[u8]) -> Result<(), Failure> {
        fs::write(self.folder.path().join(name), content)
            .map_err(|error| cannot_write(&self.path, reason(&error)))
    }

    /// Puts the folder in its place and returns that as the user wrote it. If
    /// something else has come to lie there in the meantime, that stays, and so
    /// does the new folder under its temporary name.
    pub(crate) fn finish(self) -> Result<PathBuf, Failure> {
        let fail = |error: std::io::Error| cannot_write(&self.path, reason(&error));
        // The previous report moves into a folder that removes itself.
        let mut retired = None;
        if self.path.exists() {
            if let Err(failure) = check_replaceable(&self.path, self.earlier) {
                let kept = self.folder.keep();
                return Err(Failure::new(format!(
                    "{failure}; the new report is in {}",
                    kept.display()
                )));
            }
            let folder = Builder::new()
                .prefix(".crepuscular-old-")
                .tempdir_in(parent(&self.path))
                .map_err(fail)?;
            fs::rename(&self.path, folder.path().join("report")).map_err(fail)?;
            retired = Some(folder);
        }
        if let Err(error) = fs::rename(self.folder.path(), &self.path) {
            if let Some(folder) = &retired {
                fs::rename(folder.path().join("report"), &self.path).map_err(fail)?;
            }
            return Err(fail(error));
        }
        // Nothing is left under the temporary name.
        let _ = self.folder.keep();
        Ok(self.given)
    }
}

fn check_replaceable(path: &Path, earlier: Earlier) -> Result<(), Failure> {
    if !path.is_dir() {
        return Err(cannot_write(path, "it exists and is not a folder"));
    }
    let mut names = Vec::new();
    for entry in fs::read_dir(path).map_err(|error| cannot_write(path, reason(&error)))? {
        let entry = entry.map_err(|error| cannot_write(path, reason(&error)))?;
        names.push(entry.file_name());
    }
    if names.is_empty() {
        return Ok(());
    }
    let only_ours = names
        .iter()
        .all(|name| name.to_str().is_some_and(earlier.is_ours));
    let marked = fs::read(path.join(earlier.marked)).is_ok_and(|content| {
        let head = String::from_utf8_lossy(&content[..content.len().min(1000)]).into_owned();
        head.contains(earlier.mark)
    });
    if only_ours && marked {
        return Ok(());
    }
    Err(cannot_write(
        path,
        "it holds something that is not an earlier report; choose another folder or remove it",
    ))
}

/// The folder in which `path` lies.
fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

fn cannot_write(path: &Path, why: impl std::fmt::Display) -> Failure {
    Failure::new(format!("cannot write {}: {why}", path.display()))
}

/// The system's reason without the temporary name it may mention.
fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "its folder does not exist".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        std::io::ErrorKind::NotADirectory => "a part of the path is not a folder".into(),
        _ => match error.raw_os_error() {
            Some(code) => std::io::Error::from_raw_os_error(code).to_string(),
            None => error.to_string(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn create(path: &Path) -> Result<PendingFolder, Failure> {
        let is_ours = |name: &str| ["index.html", "results.csv"].contains(&name);
        PendingFolder::create(path, is_ours, "index.html", "marked")
    }

    fn report(path: &Path, text: &str) -> Result<PathBuf, Failure> {
        let folder = create(path)?;
        folder.write("index.html", format!("marked {text}").as_bytes())?;
        folder.finish()
    }

    #[test]
    fn a_file_appears_only_when_finished() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.png");
        let pending = PendingFile::create(&path).unwrap();
        assert!(!path.exists());
        drop(pending);
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0, "no remains");
        PendingFile::create(&path).unwrap().finish(b"x").unwrap();
        PendingFile::create(&path).unwrap().finish(b"yz").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"yz");
        assert!(PendingFile::create(place.path()).is_err(), "a folder");
        assert!(PendingFile::create(&path.join("b")).is_err());
        let error = PendingFile::create(&place.path().join("no/b"))
            .err()
            .unwrap();
        assert!(
            error.to_string().contains("folder does not exist"),
            "{error}"
        );
    }

    #[test]
    fn an_earlier_report_is_replaced_and_nothing_else_is() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out");
        report(&path, "first").unwrap();
        fs::write(path.join("results.csv"), "old").unwrap();
        report(&path, "second").unwrap();
        let text = fs::read_to_string(path.join("index.html")).unwrap();
        assert_eq!(text, "marked second");
        assert!(!path.join("results.csv").exists(), "all of it is new");
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1, "no remains");

        fs::write(path.join("thesis.tex"), "dear").unwrap();
        assert!(report(&path, "third").is_err());
        assert!(path.join("thesis.tex").exists());
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1, "no remains");

        fs::remove_file(path.join("thesis.tex")).unwrap();
        let pending = create(&path).unwrap();
        pending.write("index.html", b"marked fourth").unwrap();
        fs::write(path.join("notes.txt"), "written during the run").unwrap();
        let error = pending.finish().unwrap_err().to_string();
        assert!(path.join("notes.txt").exists());
        assert!(error.contains("the new report is in"), "{error}");
        let kept = PathBuf::from(error.rsplit("is in ").next().unwrap());
        assert!(kept.join("index.html").exists(), "measured in vain");

        let unmarked = place.path().join("site");
        fs::create_dir(&unmarked).unwrap();
        report(&unmarked, "into an empty folder").unwrap();
        fs::write(unmarked.join("index.html"), "somebody's page").unwrap();
        assert!(report(&unmarked, "no").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_to_their_folder_or_are_refused() {
        let place = tempfile::tempdir().unwrap();
        let (target, link) = (place.path().join("target"), place.path().join("link"));
        std::os::unix::fs::symlink(&target, &link).unwrap();
        let error = report(&link, "nowhere").unwrap_err().to_string();
        assert!(error.contains("leads nowhere"), "{error}");
        fs::create_dir(&target).unwrap();
        assert_eq!(report(&link, "there").unwrap(), link, "as it was written");
        assert!(target.join("index.html").exists());
    }
}

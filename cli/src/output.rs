//! Files and folders that appear whole or not at all.
//!
//! Everything is written under a temporary name beside its place and renamed
//! at the end. The temporary name is taken before the long work, so that a
//! place that cannot be written is found out at once. A link stands for what it
//! leads to. Pipes and devices are written into as they are.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempDir};

use crate::failure::Failure;
use crate::interrupt::{self, Temporary};
use crate::print;

/// A file that will be at `path` when it is complete.
pub(crate) struct PendingFile {
    /// As the user wrote it.
    given: PathBuf,
    target: Target,
}

/// A file that is complete.
#[must_use]
#[derive(Debug, Clone, Copy)]
pub(crate) struct Written {
    is_regular: bool,
}

impl Written {
    /// Prints a summary on standard output, unless that may be the pipe or the device that was
    /// written into.
    pub(crate) fn summarise(self, text: &str) -> Result<(), Failure> {
        if self.is_regular {
            return print::summarise(&format!("{text}\n"));
        }
        print::note(&[text.into()]);
        Ok(())
    }
}

/// Where the contents of a file go.
enum Target {
    /// A temporary file that will replace the one at `path`.
    Replace {
        path: PathBuf,
        file: NamedTempFile,
        temporary: Temporary,
    },
    /// A pipe or a device.
    Into(File),
}

impl PendingFile {
    /// A file that must not replace any of `inputs`.
    pub(crate) fn beside(path: &Path, inputs: &[&Path]) -> Result<Self, Failure> {
        let is_input = |input: &&Path| match (path.canonicalize(), input.canonicalize()) {
            (Ok(output), Ok(input)) => output == input && input.is_file(),
            _ => false,
        };
        if inputs.iter().any(is_input) {
            return Err(cannot_write(path, "it would replace what is read"));
        }
        Self::create(path)
    }

    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        let fail = |error: io::Error| cannot_write(path, reason(&error));
        let target = match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(cannot_write(path, "it is a folder")),
            Ok(found) if found.is_file() => {
                Target::replace(path, path.canonicalize().map_err(fail)?)?
            }
            Ok(found) => Target::Into(open_special(path, found.file_type())?),
            Err(_) => Target::replace(path, end_of_links(path)?)?,
        };
        Ok(Self {
            given: path.into(),
            target,
        })
    }

    /// False for a pipe or a device, beside which nothing else belongs.
    pub(crate) fn is_regular(&self) -> bool {
        matches!(self.target, Target::Replace { .. })
    }

    pub(crate) fn finish(self, content: &[u8]) -> Result<Written, Failure> {
        self.finish_with(|out| out.write_all(content))
    }

    /// The same, for content that need not be in memory as a whole.
    pub(crate) fn finish_with(
        self,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<Written, Failure> {
        let fail = |error: io::Error| cannot_write(&self.given, reason(&error));
        let is_regular = self.is_regular();
        let result = match self.target {
            Target::Into(mut file) => write(&mut file).and_then(|()| file.flush()).map_err(fail),
            Target::Replace {
                path,
                mut file,
                temporary,
            } => {
                // Some file systems find out that they are full only here.
                write(file.as_file_mut())
                    .and_then(|()| file.as_file().sync_all())
                    .map_err(fail)?;
                let undisturbed = interrupt::undisturbed();
                let moved = file.persist(&path);
                drop(undisturbed);
                drop(temporary);
                moved.map(drop).map_err(|error| fail(error.error))
            }
        };
        result.map(|()| Written { is_regular })
    }
}

impl Target {
    /// `given` is how the user calls the file at `path`.
    fn replace(given: &Path, path: PathBuf) -> Result<Self, Failure> {
        let mut builder = Builder::new();
        builder.prefix(".crepuscular-");
        #[cfg(unix)]
        let builder = {
            use std::os::unix::fs::PermissionsExt;
            // It gets the permissions of any new file, less those that the umask takes away.
            builder.permissions(fs::Permissions::from_mode(0o666))
        };
        let make = || builder.tempfile_in(parent(&path));
        let (file, temporary) = Temporary::made(make, NamedTempFile::path)
            .map_err(|error| cannot_write(given, reason(&error)))?;
        Ok(Self::Replace {
            path,
            file,
            temporary,
        })
    }
}

/// Opens a pipe or a device, if it takes bytes without harm.
fn open_special(path: &Path, kind: fs::FileType) -> Result<File, Failure> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_block_device() {
            return Err(cannot_write(path, "it is a disk"));
        }
        if kind.is_socket() {
            return Err(cannot_write(path, "it is a socket"));
        }
    }
    let _ = kind;
    let opened = File::options().write(true).open(path);
    opened.map_err(|error| cannot_write(path, reason(&error)))
}

/// Where the links at `path` lead to, although nothing is there yet.
fn end_of_links(path: &Path) -> Result<PathBuf, Failure> {
    /// Systems follow this many links.
    const LINKS: usize = 40;
    let mut end = path.to_path_buf();
    for _ in 0..LINKS {
        match fs::read_link(&end) {
            Ok(next) => end = parent(&end).join(next),
            Err(_) => return Ok(end),
        }
    }
    Err(cannot_write(path, "it is a link that leads to itself"))
}

/// A folder of files that will replace `path` when it is complete.
pub(crate) struct PendingFolder {
    /// As the user wrote it.
    given: PathBuf,
    /// Where it leads to.
    path: PathBuf,
    folder: TempDir,
    temporary: Temporary,
    earlier: Earlier,
}

/// The marks of an earlier folder of ours, which may be replaced.
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
        } else {
            end_of_links(path)?
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
        let make = || builder.tempdir_in(parent(&path));
        let (folder, temporary) = Temporary::made(make, TempDir::path)
            .map_err(|error| cannot_write(&path, reason(&error)))?;
        Ok(Self {
            given,
            path,
            folder,
            temporary,
            earlier,
        })
    }

    pub(crate) fn write(&self, name: &str, content: &[u8]) -> Result<(), Failure> {
        let write = || {
            let mut file = File::create(self.folder.path().join(name))?;
            file.write_all(content)?;
            // Some file systems find out that they are full only here.
            file.sync_all()
        };
        write().map_err(|error| cannot_write(&self.path, reason(&error)))
    }

    /// Puts the folder in its place and returns its path as the user wrote it. If something else
    /// has come to lie there in the meantime, it stays, and so does the new folder under its
    /// temporary name.
    pub(crate) fn finish(self) -> Result<PathBuf, Failure> {
        let fail = |error: io::Error| cannot_write(&self.path, reason(&error));
        let undisturbed = interrupt::undisturbed();
        // The previous report moves into a folder that removes itself.
        let mut retired = None;
        if self.path.exists() {
            if let Err(failure) = check_replaceable(&self.path, self.earlier) {
                let kept = self.folder.keep();
                drop(undisturbed);
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
            if let Some(folder) = retired
                && fs::rename(folder.path().join("report"), &self.path).is_err()
            {
                let kept = folder.keep().join("report");
                return Err(Failure::new(format!(
                    "{}; the earlier report is in {}",
                    fail(error),
                    kept.display()
                )));
            }
            return Err(fail(error));
        }
        drop(retired);
        // Nothing is left under the temporary name.
        let _ = self.folder.keep();
        drop(undisturbed);
        drop(self.temporary);
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
fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "its folder does not exist".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::NotADirectory => "part of the path is not a folder".into(),
        kind => match error.raw_os_error() {
            Some(code) => io::Error::from_raw_os_error(code).to_string(),
            None if kind == io::ErrorKind::Other => error.to_string(),
            None => kind.to_string(),
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
        let write = |content: &[u8]| PendingFile::create(&path).unwrap().finish(content);
        assert!(write(b"x").unwrap().is_regular);
        assert!(write(b"yz").unwrap().is_regular);
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
    fn a_link_is_written_through_even_if_nothing_is_there_yet() {
        use std::os::unix::fs::symlink;

        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name);
        fs::create_dir(at("deep")).unwrap();
        symlink("deep/a", at("b")).unwrap();
        symlink("b", at("c")).unwrap();
        for content in ["first", "second"] {
            let pending = PendingFile::create(&at("c")).unwrap();
            assert!(pending.is_regular());
            assert!(pending.finish(content.as_bytes()).unwrap().is_regular);
            assert_eq!(fs::read_to_string(at("deep/a")).unwrap(), content);
            assert!(at("c").is_symlink() && at("b").is_symlink());
        }
        symlink("e", at("d")).unwrap();
        symlink("d", at("e")).unwrap();
        let error = PendingFile::create(&at("d")).err().unwrap().to_string();
        assert!(error.contains("leads to itself"), "{error}");
    }

    #[test]
    fn reasons_have_no_temporary_name() {
        let wrapped = io::Error::new(io::ErrorKind::StorageFull, "no space at .crepuscular-x");
        assert!(!reason(&wrapped).contains(".crepuscular"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn devices_are_written_into_and_sockets_refused() {
        let pending = PendingFile::create(Path::new("/dev/null")).unwrap();
        assert!(!pending.is_regular());
        assert!(!pending.finish(b"gone").unwrap().is_regular);
        let full = PendingFile::create(Path::new("/dev/full")).unwrap();
        let error = full.finish(b"much").unwrap_err().to_string();
        assert!(error.contains("/dev/full: No space"), "{error}");

        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("socket");
        let _socket = std::os::unix::net::UnixListener::bind(&path).unwrap();
        let error = PendingFile::create(&path).err().unwrap().to_string();
        assert!(error.contains("it is a socket"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_to_their_folder_even_if_there_is_none_yet() {
        let place = tempfile::tempdir().unwrap();
        let (target, link) = (place.path().join("target"), place.path().join("link"));
        std::os::unix::fs::symlink(&target, &link).unwrap();
        for content in ["new", "again"] {
            assert_eq!(report(&link, content).unwrap(), link, "as it was written");
            let page = fs::read_to_string(target.join("index.html")).unwrap();
            assert_eq!(page, format!("marked {content}"));
        }
    }
}

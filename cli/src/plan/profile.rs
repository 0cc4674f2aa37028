//! The file of what methods cost on a machine.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use lighting::prediction::{Costs, Profile};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::file;
use crate::output::PendingFile;

/// The words by which such a file is recognised.
const FORMAT: &str = "crepuscular machine profile";

/// The version of the format that is read and written.
const VERSION: u64 = 1;

/// The usual place of the profile; `None` without a home.
pub(super) fn usual_place() -> Option<PathBuf> {
    let folder = |variable: &str| std::env::var_os(variable).filter(|value| !value.is_empty());
    let cache = folder("XDG_CACHE_HOME")
        .map(PathBuf::from)
        .filter(|path| path.is_absolute())
        .or_else(|| folder("HOME").map(|home| PathBuf::from(home).join(".cache")))
        .or_else(|| folder("LOCALAPPDATA").map(PathBuf::from))?;
    Some(cache.join("crepuscular").join("profile.json"))
}

/// The profile at `given`, which must be there, or at the usual place, where it need not.
pub(super) fn read(given: Option<&Path>) -> Result<Profile, Failure> {
    let (path, must_be) = match (given, usual_place()) {
        (Some(path), _) => (path.to_owned(), true),
        (None, Some(path)) => (path, false),
        (None, None) => return Ok(Profile::new()),
    };
    match file::read(&path) {
        Ok(bytes) => parse(&bytes).map_err(|why| damaged(&path, &why)),
        Err(error) if error.kind() == ErrorKind::NotFound && !must_be => Ok(Profile::new()),
        Err(error) => Err(Failure::from(error).about(&path.display().to_string())),
    }
}

/// A place for a profile that can be written.
pub(super) struct Pending {
    path: PathBuf,
    file: PendingFile,
}

/// Returns an error if no profile can be written to `given` or to the usual place. It may replace
/// an earlier profile, but nothing else.
pub(super) fn open(given: Option<&Path>) -> Result<Pending, Failure> {
    let path = match given {
        Some(path) => path.to_owned(),
        None => {
            let path = usual_place().ok_or_else(|| {
                Failure::new("no cache folder was found; name a file with --profile")
            })?;
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder)
                    .map_err(|error| Failure::from(error).about(&folder.display().to_string()))?;
            }
            path
        }
    };
    match file::read(&path) {
        Ok(bytes) if !is_ours(&bytes) => {
            return Err(Failure::new(format!(
                "{} is no machine profile, and is not overwritten; choose another file with \
                 --profile",
                path.display()
            )));
        }
        Err(error) if error.kind() != ErrorKind::NotFound => {
            return Err(Failure::from(error).about(&path.display().to_string()));
        }
        _ => {}
    }
    let file = PendingFile::create(&path)?;
    Ok(Pending { path, file })
}

impl Pending {
    /// Writes a profile and returns its path.
    pub(super) fn write(self, profile: &Profile) -> Result<PathBuf, Failure> {
        let _ = (self.file).finish(format!("{:#}\n", of(profile)).as_bytes())?;
        Ok(self.path)
    }
}

fn damaged(path: &Path, why: &str) -> Failure {
    Failure::new(format!(
        "{} is not a valid machine profile: {why}; write a new one with plan --calibrate, or delete it",
        path.display()
    ))
}

/// Whether a file says that it is a profile, sound or not.
fn is_ours(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    text.trim_start().starts_with('{') && text.contains(FORMAT)
}

fn of(profile: &Profile) -> Value {
    json!({
        "format": FORMAT,
        "version": VERSION,
        "methods": profile.all().map(|(backend, method, costs)| json!({
            "backend": backend,
            "method": method,
            "seconds_once_per_unit": costs.once,
            "seconds_frame_per_unit": costs.frame,
        })).collect::<Vec<_>>(),
        "starts": profile.starts().map(|(backend, seconds)| json!({
            "backend": backend,
            "seconds": seconds,
        })).collect::<Vec<_>>(),
    })
}

fn parse(bytes: &[u8]) -> Result<Profile, String> {
    let value: Value = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
    if value["format"] != FORMAT {
        return Err(format!(
            "its format is {}, expected \"{FORMAT}\"",
            value["format"]
        ));
    }
    if value["version"] != VERSION {
        return Err(format!(
            "its version is {}, expected {VERSION}",
            value["version"]
        ));
    }
    let methods = value["methods"]
        .as_array()
        .ok_or("it has no list of methods")?;
    let mut profile = Profile::new();
    for index in 0..methods.len() {
        let item = Item(&value, "methods", index);
        let costs = Costs {
            once: item.seconds("seconds_once_per_unit")?,
            frame: item.seconds("seconds_frame_per_unit")?,
        };
        profile.insert(item.name("backend")?, item.name("method")?, costs);
    }
    // A profile from before starts were measured has no list of them.
    let starts = value["starts"].as_array().map_or(0, Vec::len);
    for index in 0..starts {
        let item = Item(&value, "starts", index);
        profile.insert_start(item.name("backend")?, item.seconds("seconds")?);
    }
    Ok(profile)
}

/// A part of a profile: the one of this index in a list of this name.
struct Item<'a>(&'a Value, &'static str, usize);

impl<'a> Item<'a> {
    fn name(&self, key: &str) -> Result<&'a str, String> {
        let Self(all, list, index) = *self;
        let value = &all[list][index][key];
        value
            .as_str()
            .ok_or_else(|| format!("{list}[{index}].{key} is {value}, expected a name"))
    }

    fn seconds(&self, key: &str) -> Result<f64, String> {
        let Self(all, list, index) = *self;
        let value = &all[list][index][key];
        let number = value.as_f64().filter(|x| x.is_finite() && *x > 0.0);
        number.ok_or_else(|| {
            format!("{list}[{index}].{key} is {value}, expected a number of seconds above 0")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What makes a sound profile unsound.
    type Change = dyn Fn(&mut Value);

    fn write(path: &Path, profile: &Profile) -> Result<PathBuf, Failure> {
        open(Some(path))?.write(profile)
    }

    fn example() -> Profile {
        let mut profile = Profile::new();
        let costs = Costs {
            once: 1e-8,
            frame: 2.5e-9,
        };
        profile.insert("cpu", "march x midpoint", costs);
        profile.insert_start("gpu (any)", 0.5);
        profile
    }

    #[test]
    fn a_profile_is_read_as_it_was_written() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("profile.json");
        let written = write(&path, &example()).unwrap();
        assert_eq!(read(Some(&written)).unwrap(), example());
        // Another one takes its place.
        write(&path, &Profile::new()).unwrap();
        assert!(read(Some(&path)).unwrap().is_empty());
    }

    #[test]
    fn what_is_no_profile_is_not_overwritten() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("notes.json");
        for content in ["{}", "", "crepuscular machine profile", "a text"] {
            std::fs::write(&path, content).unwrap();
            let failure = write(&path, &example()).unwrap_err().to_string();
            assert!(failure.contains("is not overwritten"), "{failure}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), content);
        }
        // One that is damaged is.
        std::fs::write(&path, format!("{{\"format\": \"{FORMAT}\", ")).unwrap();
        write(&path, &example()).unwrap();
    }

    #[test]
    fn what_is_wrong_with_a_profile_is_said() {
        let mut sound = of(&example());
        assert!(parse(sound.to_string().as_bytes()).is_ok());
        let mut older = sound.clone();
        older.as_object_mut().unwrap().remove("starts");
        let older = parse(older.to_string().as_bytes()).unwrap();
        assert_eq!(older.starts().count(), 0);
        let wrong = |change: &dyn Fn(&mut Value)| {
            let mut value = sound.clone();
            change(&mut value);
            parse(value.to_string().as_bytes()).unwrap_err()
        };
        let cases: [(&Change, &str); 6] = [
            (
                &|v| v["format"] = json!("a table"),
                "its format is \"a table\"",
            ),
            (&|v| v["version"] = json!(2), "its version is 2, expected 1"),
            (&|v| v["methods"] = json!(1), "no list of methods"),
            (
                &|v| v["methods"][0]["method"] = json!(1),
                "methods[0].method is 1, expected a name",
            ),
            (
                &|v| v["methods"][0]["seconds_once_per_unit"] = json!(-1.0),
                "methods[0].seconds_once_per_unit is -1.0, expected a number of seconds above 0",
            ),
            (
                &|v| v["starts"][0]["seconds"] = json!("long"),
                "starts[0].seconds is \"long\", expected a number of seconds above 0",
            ),
        ];
        for (change, why) in cases {
            let found = wrong(change);
            assert!(found.contains(why), "{found}");
        }
        sound = json!(null);
        assert!(parse(sound.to_string().as_bytes()).is_err());
        let missing = read(Some(Path::new("no such profile"))).unwrap_err();
        assert!(missing.to_string().contains("no such profile"));
    }
}

//! Signals end the program without leaving anything half-made behind.
//!
//! A thread waits for SIGINT, SIGTERM and SIGHUP, which all other threads hold
//! back. Temporary files and folders are known here from the moment they exist
//! until they are gone or in their place.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use crate::failure::Failure;

/// Everything that a signal has to take care of.
#[derive(Debug, Default)]
struct State {
    /// Temporary files and folders.
    temporary: Vec<PathBuf>,
    /// The flags by which the first signal asks work to come to an end.
    asked: Option<Arc<AtomicBool>>,
}

static STATE: Mutex<State> = Mutex::new(State {
    temporary: Vec::new(),
    asked: None,
});

/// The number of the first signal; 0 before.
static SIGNAL: AtomicU8 = AtomicU8::new(0);

fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Begins to listen, once. Threads that run already do not hold signals back, so this has to be
/// called before any is started.
pub(crate) fn listen() -> Result<(), Failure> {
    static BEGUN: OnceLock<Result<(), String>> = OnceLock::new();
    let begun = BEGUN.get_or_init(|| begin().map_err(|failure| failure.to_string()));
    begun.clone().map_err(Failure::new)
}

#[cfg(unix)]
fn begin() -> Result<(), Failure> {
    use nix::sys::signal::{SigSet, Signal};

    let mut signals = SigSet::empty();
    signals.add(Signal::SIGINT);
    signals.add(Signal::SIGTERM);
    // `nohup` asks for it to be ignored.
    if ignored() >> (Signal::SIGHUP as u32 - 1) & 1 == 0 {
        signals.add(Signal::SIGHUP);
    }
    signals.thread_block()?;
    std::thread::Builder::new()
        .name("signals".into())
        .spawn(move || {
            while let Ok(signal) = signals.wait() {
                heard(signal as u8);
            }
        })?;
    Ok(())
}

/// The signals that this process was told to ignore, as bits; none where the
/// system does not say.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mut lines = status.lines();
    let mask = lines.find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

#[cfg(not(unix))]
fn begin() -> Result<(), Failure> {
    const CTRL_C: u8 = 2;
    Ok(ctrlc::set_handler(|| heard(CTRL_C))?)
}

/// The first signal is a request if somebody listens to requests. Every other
/// ends the program.
fn heard(signal: u8) {
    let is_first =
        (SIGNAL.compare_exchange(0, signal, Ordering::Relaxed, Ordering::Relaxed)).is_ok();
    let mut state = state();
    if let (true, Some(asked)) = (is_first, &state.asked) {
        asked.store(true, Ordering::Relaxed);
        return;
    }
    for path in state.temporary.drain(..) {
        remove(&path);
    }
    // Threads that want to make or move something wait for the state until the program ends.
    std::process::exit(code(signal).into());
}

/// Removes a file or a folder in which somebody may be writing.
fn remove(path: &Path) {
    const TRIES: usize = 3;
    for _ in 0..TRIES {
        let removed = match path.symlink_metadata() {
            Ok(found) if found.is_dir() => std::fs::remove_dir_all(path),
            Ok(_) => std::fs::remove_file(path),
            Err(_) => return,
        };
        if removed.is_ok() {
            return;
        }
    }
}

/// The exit code that a shell expects of a program that a signal ended.
fn code(signal: u8) -> u8 {
    128 + signal
}

/// The exit code of a program that a signal has told to end.
pub(crate) fn exit_code() -> Option<u8> {
    let signal = SIGNAL.load(Ordering::Relaxed);
    (signal != 0).then(|| code(signal))
}

/// A flag that the first signal sets. The second ends the program at once.
pub(crate) fn flag() -> Result<Arc<AtomicBool>, Failure> {
    listen()?;
    let stop = Arc::new(AtomicBool::new(false));
    state().asked = Some(Arc::clone(&stop));
    Ok(stop)
}

/// While it lives, no signal ends the program.
#[derive(Debug)]
pub(crate) struct Undisturbed {
    _state: MutexGuard<'static, State>,
}

/// Such a guard, for moving something that must not be lost half-way.
pub(crate) fn undisturbed() -> Undisturbed {
    Undisturbed { _state: state() }
}

/// A file or a folder that a signal removes as long as this lives.
#[derive(Debug)]
pub(crate) struct Temporary {
    path: PathBuf,
}

impl Temporary {
    /// Calls `make` and takes care of the file or folder that it makes. No signal comes in
    /// between.
    pub(crate) fn made<T, E>(
        make: impl FnOnce() -> Result<T, E>,
        path: impl FnOnce(&T) -> &Path,
    ) -> Result<(T, Self), E> {
        let mut state = state();
        let made = make()?;
        let path = path(&made).to_path_buf();
        state.temporary.push(path.clone());
        Ok((made, Self { path }))
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        state().temporary.retain(|path| *path != self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_temporary_is_known_as_long_as_it_is_held() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a");
        let make = || std::fs::write(&path, "a").map(|()| path.clone());
        let (_, temporary) = Temporary::made(make, PathBuf::as_path).unwrap();
        assert!(state().temporary.contains(&path));
        drop(temporary);
        assert!(!state().temporary.contains(&path));
    }

    #[test]
    fn files_and_folders_are_removed_and_nothing_is_no_error() {
        let place = tempfile::tempdir().unwrap();
        let (file, folder) = (place.path().join("a"), place.path().join("b"));
        std::fs::write(&file, "a").unwrap();
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("c"), "c").unwrap();
        for path in [&file, &folder, &folder] {
            remove(path);
            assert!(!path.exists());
        }
    }
}

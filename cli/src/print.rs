//! Text: results go to standard output, and everything else goes to standard error.

use std::collections::BTreeSet;
use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::failure::Failure;

/// Whether only errors, warnings and results are printed.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Chooses whether only errors, warnings and results are printed from now on, or notes and
/// progress as well.
pub(crate) fn set_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// True if only errors, warnings and results are printed.
pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Writes `text` to standard output. A reader that has gone away, such as
/// `head`, wants no more and is no failure; a full disk is one.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    written(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// The same for a summary of work whose result is elsewhere.
pub(crate) fn summarise(text: &str) -> Result<(), Failure> {
    if is_quiet() { Ok(()) } else { print(text) }
}

/// The outcome of writing to standard output.
pub(crate) fn written(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::new(format!(
            "cannot write to standard output: {error}"
        ))),
        _ => Ok(()),
    }
}

/// Writes notes to standard error, a line each.
pub(crate) fn note(notes: &[String]) {
    if !is_quiet() {
        for note in notes {
            complain(&format!("note: {note}"));
        }
    }
}

/// Writes a note to standard error, unless it has been written before.
pub(crate) fn note_once(what: &str) {
    static WRITTEN: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let mut written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
    if written.insert(what.into()) {
        note(&[what.into()]);
    }
}

/// Writes a line to standard error, if that can be written.
pub(crate) fn complain(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

//! Progress: a bar on a terminal, a line now and then where there is none.

use std::io::IsTerminal;
use std::sync::{Mutex, Once, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle, WeakProgressBar};

use crate::format::seconds;
use crate::print::{complain, is_quiet};

/// Time between two lines.
const PAUSE: Duration = Duration::from_secs(10);

/// A bar of `length` steps on standard error, if the work is not over at once.
pub(crate) fn bar(what: &'static str, length: u64) -> ProgressBar {
    let bar = shown(ProgressBar::new(length), what);
    if let Ok(style) =
        ProgressStyle::with_template("{msg:24} [{bar:32}] {percent:>3} %  {elapsed} < {eta}")
    {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}

/// A spinner for work of unknown length.
pub(crate) fn spinner(what: &'static str) -> ProgressBar {
    shown(ProgressBar::new_spinner(), what)
}

fn shown(bar: ProgressBar, what: &'static str) -> ProgressBar {
    let bar = bar.with_message(what);
    if is_quiet() {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    } else if std::io::stderr().is_terminal() {
        bar.enable_steady_tick(Duration::from_millis(250));
    } else {
        tell_of(what, &bar);
    }
    bar
}

/// The work that lines report.
struct Work {
    what: &'static str,
    bar: WeakProgressBar,
}

static WORK: Mutex<Vec<Work>> = Mutex::new(Vec::new());

/// Lets a thread write a line about the latest work every ten seconds.
fn tell_of(what: &'static str, bar: &ProgressBar) {
    static TELLER: Once = Once::new();
    let mut work = WORK.lock().unwrap_or_else(PoisonError::into_inner);
    work.retain(is_under_way);
    work.push(Work {
        what,
        bar: bar.downgrade(),
    });
    TELLER.call_once(|| {
        let tell = || {
            loop {
                std::thread::sleep(PAUSE);
                if let Some(line) = latest() {
                    complain(&line);
                }
            }
        };
        // Without a thread there are no lines.
        let _ = std::thread::Builder::new()
            .name("progress".into())
            .spawn(tell);
    });
}

fn is_under_way(work: &Work) -> bool {
    work.bar.upgrade().is_some_and(|bar| !bar.is_finished())
}

fn latest() -> Option<String> {
    let mut work = WORK.lock().unwrap_or_else(PoisonError::into_inner);
    work.retain(is_under_way);
    let Work { what, bar } = work.last()?;
    bar.upgrade().map(|bar| line(what, &bar))
}

fn line(what: &str, bar: &ProgressBar) -> String {
    let elapsed = seconds(bar.elapsed().as_secs().max(1) as f64);
    match bar.length() {
        Some(length) if length > 0 => {
            let percent = 100 * bar.position().min(length) / length;
            format!("{what}: {percent} % after {elapsed}")
        }
        _ => format!("{what}: {elapsed} so far"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_tell_what_is_done_of_how_much() {
        let bar = ProgressBar::hidden();
        bar.set_length(8);
        bar.set_position(2);
        assert_eq!(line("bake", &bar), "bake: 25 % after 1 s");
        bar.set_position(99);
        assert_eq!(line("bake", &bar), "bake: 100 % after 1 s");
        assert_eq!(line("load", &ProgressBar::no_length()), "load: 1 s so far");
    }

    #[test]
    fn work_that_is_over_is_not_told_of() {
        let bar = ProgressBar::hidden();
        let work = Work {
            what: "bake",
            bar: bar.downgrade(),
        };
        assert!(is_under_way(&work));
        bar.finish_and_clear();
        assert!(!is_under_way(&work));
        drop(bar);
        assert!(!is_under_way(&work));
    }
}

//! How long lights may be prepared, and messages meanwhile.

use std::time::Instant;

use indicatif::ProgressBar;
use lighting::Watch;

use crate::print::note_once;
use crate::progress;

/// Goes on as long as all lights are expected to be done within `seconds`, going by the time of
/// the first ones.
pub(super) struct Patience {
    start: Instant,
    seconds: f64,
    bar: ProgressBar,
}

impl Patience {
    pub(super) fn new(seconds: f64) -> Self {
        Self {
            start: Instant::now(),
            seconds,
            bar: progress::bar("preparing", 0),
        }
    }
}

impl Watch for Patience {
    fn told(&self, what: &str) {
        note_once(what);
    }

    fn goes_on(&self, done: usize, total: usize) -> bool {
        self.bar.set_length(total as u64);
        self.bar.set_position(done as u64);
        let so_far = self.start.elapsed().as_secs_f64();
        done == 0 || so_far / done as f64 * total as f64 <= self.seconds
    }
}

impl Drop for Patience {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

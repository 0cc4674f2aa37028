//! How much time there is.

use std::time::{Duration, Instant};

/// Share of the time that is used for measuring; the rest is for the report.
const USED: f64 = 0.95;

/// The clock of a comparison.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Budget {
    start: Instant,
    total: Duration,
}

impl Budget {
    /// Starts now.
    pub(crate) fn new(seconds: f64) -> Self {
        Self {
            start: Instant::now(),
            total: Duration::from_secs_f64(seconds),
        }
    }

    /// Seconds since the start.
    pub(crate) fn elapsed(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// A budget that ends when the given share of what is left is used up.
    pub(crate) fn share(&self, share: f64) -> Self {
        let end = self.elapsed() + self.left() * share;
        Self {
            start: self.start,
            total: Duration::from_secs_f64(end / USED),
        }
    }

    /// All seconds there are.
    pub(crate) fn total(&self) -> f64 {
        self.total.as_secs_f64()
    }

    /// Seconds left for measuring, not below 0.
    pub(crate) fn left(&self) -> f64 {
        (USED * self.total() - self.elapsed()).max(0.0)
    }
}

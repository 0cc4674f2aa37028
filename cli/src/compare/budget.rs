//! How much time there is.

use std::time::Instant;

/// Share of the time that is used for measuring; the rest is for the report.
const USED: f64 = 0.92;

/// The clock of a comparison.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Budget {
    start: Instant,
    /// Seconds, infinite if everything is to be measured.
    total: f64,
}

impl Budget {
    /// A clock that starts now.
    pub(crate) fn new(seconds: f64) -> Self {
        Self {
            start: Instant::now(),
            total: seconds,
        }
    }

    /// A clock without an end.
    pub(crate) fn unlimited() -> Self {
        Self::new(f64::INFINITY)
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
            total: end / USED,
        }
    }

    /// All seconds there are.
    pub(crate) fn total(&self) -> f64 {
        self.total
    }

    /// Seconds left for measuring, not below 0.
    pub(crate) fn left(&self) -> f64 {
        (USED * self.total - self.elapsed()).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_unlimited_time_is_unlimited() {
        let budget = Budget::unlimited().share(0.25);
        assert_eq!(budget.left(), f64::INFINITY);
        let quarter = Budget::new(1e6).share(0.25);
        assert!((quarter.left() / (0.25 * USED * 1e6) - 1.0).abs() < 1e-3);
        assert_eq!(Budget::new(0.0).left(), 0.0);
    }
}

//! Repeated measurements of one duration.

/// The median of several durations, with the fastest and the slowest, in
/// seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Times {
    pub(crate) median: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) repetitions: usize,
}

impl Times {
    /// From at least one duration, in any order.
    pub(crate) fn of(seconds: &[f64]) -> Self {
        let mut sorted = seconds.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        assert!(n > 0, "a time is measured at least once");
        Self {
            median: 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
            low: sorted[0],
            high: sorted[n - 1],
            repetitions: n,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        let times = Times::of(&[3.0, 1.0, 2.0, 10.0]);
        assert_eq!((times.median, times.low, times.high), (2.5, 1.0, 10.0));
        assert_eq!(Times::of(&[7.0]).median, 7.0);
    }
}

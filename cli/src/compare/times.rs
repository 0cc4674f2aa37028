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
    /// The times of at least one duration, in any order.
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

    /// True if neither is faster than the other as far as the repetitions tell: some
    /// frame of the one took as long as some of the other.
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        let [a, b] = [self.spread(), other.spread()];
        a[0] <= b[1] && b[0] <= a[1]
    }

    /// The fastest and the slowest; a time that was taken once may be off by
    /// [`SINGLE`] either way.
    fn spread(&self) -> [f64; 2] {
        if self.repetitions > 1 {
            [self.low, self.high]
        } else {
            [self.low / SINGLE, self.high * SINGLE]
        }
    }
}

/// The factor by which a single frame may be off. It says nothing of its own
/// spread; a frame beside another busy process may well take half as long again.
const SINGLE: f64 = 1.5;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        let times = Times::of(&[3.0, 1.0, 2.0, 10.0]);
        assert_eq!((times.median, times.low, times.high), (2.5, 1.0, 10.0));
        assert_eq!(Times::of(&[7.0]).median, 7.0);
    }

    #[test]
    fn times_are_told_apart_only_where_their_spreads_are() {
        let of = Times::of;
        let (a, b, c) = (of(&[1.0, 1.2]), of(&[1.2, 1.3]), of(&[1.21, 1.3]));
        assert!(a.overlaps(&a) && a.overlaps(&b) && b.overlaps(&a));
        assert!(!a.overlaps(&c) && !c.overlaps(&a));
        assert!(of(&[1.0]).overlaps(&of(&[2.0])), "single frames");
        assert!(!of(&[1.0]).overlaps(&of(&[4.0])));
    }
}

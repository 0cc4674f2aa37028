//! How large a picture the time allows.

use std::time::{Duration, Instant};

use crate::parse::Size;

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

/// The shortest side that a picture is reduced to.
const SMALLEST: u32 = 16;

/// `size`, or a smaller one of about the same shape in which something that
/// takes `seconds_per_pixel` takes at most `seconds`.
pub(crate) fn affordable_size(size: Size, seconds_per_pixel: f64, seconds: f64) -> Size {
    let pixels = seconds / seconds_per_pixel.max(f64::MIN_POSITIVE);
    let shrink = (pixels / size.pixels() as f64).sqrt();
    // The estimate is not good enough to reduce a picture by a few percent.
    if shrink >= 0.95 || !shrink.is_finite() {
        return size;
    }
    let side = |length: u32| {
        let smallest = SMALLEST.min(length);
        ((f64::from(length) * shrink).round() as u32).max(smallest)
    };
    Size {
        width: side(size.width),
        height: side(size.height),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_shrink_to_what_can_be_paid_and_never_grow() {
        let size = Size {
            width: 320,
            height: 180,
        };
        assert_eq!(affordable_size(size, 1e-6, 1.0), size);
        let half = affordable_size(size, 1e-4, 1.44);
        assert_eq!((half.width, half.height), (160, 90));
        let least = affordable_size(size, 1.0, 0.0);
        assert_eq!((least.width, least.height), (16, 16));
        let tiny = Size {
            width: 1,
            height: 3,
        };
        assert_eq!(affordable_size(tiny, 1.0, 0.0), tiny);
        assert_eq!(
            affordable_size(size, 0.0, 0.0),
            affordable_size(size, 1.0, 0.0)
        );
    }
}

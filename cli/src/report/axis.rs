//! A logarithmic axis.

/// Maps positive values to pixels, and knows where to put its ticks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LogAxis {
    /// log10 of the values at the two ends.
    low: f64,
    high: f64,
    /// Pixels of the two ends.
    start: f64,
    end: f64,
}

/// A line of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tick {
    pub(crate) value: f64,
    pub(crate) position: f64,
    /// Wants a number beside it.
    pub(crate) labelled: bool,
}

impl LogAxis {
    /// An axis with some air around the given values, from pixel `start` to
    /// `end`. Values that are not positive and finite are ignored; `None` if
    /// there are no others.
    pub(crate) fn around(values: impl Iterator<Item = f64>, start: f64, end: f64) -> Option<Self> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|value| *value > 0.0 && value.is_finite()) {
            low = low.min(value.log10());
            high = high.max(value.log10());
        }
        if low > high {
            return None;
        }
        let air = (0.07 * (high - low)).max(0.1);
        Some(Self {
            low: low - air,
            high: high + air,
            start,
            end,
        })
    }

    /// The pixel of a positive value; values outside are held at the ends.
    pub(crate) fn position(&self, value: f64) -> f64 {
        let log = value.max(f64::MIN_POSITIVE).log10();
        let t = (log.clamp(self.low, self.high) - self.low) / (self.high - self.low);
        self.start + t * (self.end - self.start)
    }

    /// Powers of ten with labels, and their multiples without; the 2 and the 5
    /// have labels too where there would be fewer than three.
    pub(crate) fn ticks(&self) -> Vec<Tick> {
        let first = self.low.floor() as i32;
        let last = self.high.ceil() as i32;
        let inside = |value: f64| {
            let log = value.log10();
            self.low - 1e-9 <= log && log <= self.high + 1e-9
        };
        let decades: Vec<i32> = (first..=last)
            .filter(|exponent| inside(10_f64.powi(*exponent)))
            .collect();
        // At most about eight labels.
        let every = decades.len().div_ceil(8).max(1);
        let mut ticks = Vec::new();
        for exponent in first..=last {
            for mantissa in 1..10 {
                let value = f64::from(mantissa) * 10_f64.powi(exponent);
                if !inside(value) || (mantissa > 1 && decades.len() > 6) {
                    continue;
                }
                let labelled = match mantissa {
                    1 => (exponent.unsigned_abs() as usize).is_multiple_of(every),
                    2 | 5 => decades.len() < 3,
                    _ => false,
                };
                ticks.push(Tick {
                    value,
                    position: self.position(value),
                    labelled,
                });
            }
        }
        if ticks.iter().filter(|tick| tick.labelled).count() < 2 {
            for tick in &mut ticks {
                tick.labelled = true;
            }
        }
        ticks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(values: &[f64]) -> Vec<f64> {
        let axis = LogAxis::around(values.iter().copied(), 0.0, 100.0).unwrap();
        let ticks = axis.ticks();
        assert!(ticks.iter().all(|t| (0.0..=100.0).contains(&t.position)));
        let labelled = ticks.iter().filter(|tick| tick.labelled);
        labelled.map(|tick| tick.value).collect()
    }

    #[test]
    fn ticks_are_round_and_neither_few_nor_many() {
        assert_eq!(labels(&[1e-3, 1e-1, 1.0]), [1e-3, 1e-2, 1e-1, 1.0]);
        assert_eq!(labels(&[3.0, 30.0]), [5.0, 10.0, 20.0]);
        for (low, high) in [
            (1e-12, 1e12),
            (1.0, 1.001),
            (0.9, 40.0),
            (3.0, 3.1),
            (1e-300, 1e300),
        ] {
            let found = labels(&[low, high]);
            assert!((1..=10).contains(&found.len()), "{low} {high}: {found:?}");
        }
    }

    #[test]
    fn an_axis_takes_only_positive_values() {
        let odd = [0.0, -1.0, f64::NAN, f64::INFINITY];
        assert!(LogAxis::around(odd.into_iter(), 0.0, 1.0).is_none());
        let axis = LogAxis::around([0.0, 5.0].into_iter(), 10.0, 20.0).unwrap();
        assert!((axis.position(5.0) - 15.0).abs() < 1e-9);
        assert_eq!(axis.position(0.0), 10.0);
        assert_eq!(axis.position(f64::INFINITY), 20.0);
    }
}

//! Axes of charts.

use crate::compare::study::Scale;

/// An axis of either kind.
#[derive(Debug, Clone, Copy)]
pub(super) enum Ruler {
    Log(LogAxis),
    Even(EvenAxis),
}

impl Ruler {
    /// An axis for the given values, from pixel `start` to `end`, with about
    /// `parts` parts between ticks if it is even. Values that are not finite
    /// are ignored; `None` if the others leave nothing to show.
    pub(super) fn new(
        scale: Scale,
        values: impl Iterator<Item = f64>,
        (start, end): (f64, f64),
        parts: u32,
    ) -> Option<Self> {
        let (low, high) = match scale {
            Scale::Log => return LogAxis::around(values, start, end).map(Self::Log),
            Scale::Between(low, high) => (low, high),
            Scale::Linear => values
                .filter(|value| value.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                    (low.min(value), high.max(value))
                }),
        };
        let even = EvenAxis {
            low,
            high,
            start,
            end,
            parts,
        };
        (low < high).then_some(Self::Even(even))
    }

    /// The pixel of a value; values outside are held at the ends.
    pub(super) fn position(&self, value: f64) -> f64 {
        match self {
            Self::Log(axis) => axis.position(value),
            Self::Even(axis) => axis.position(value),
        }
    }

    pub(super) fn ticks(&self) -> Vec<Tick> {
        match self {
            Self::Log(axis) => axis.ticks(),
            Self::Even(axis) => axis.ticks(),
        }
    }
}

/// Maps values to pixels evenly.
#[derive(Debug, Clone, Copy)]
pub(super) struct EvenAxis {
    /// The values at the two ends.
    low: f64,
    high: f64,
    /// Pixels of the two ends.
    start: f64,
    end: f64,
    /// Parts between ticks, about.
    parts: u32,
}

impl EvenAxis {
    fn position(&self, value: f64) -> f64 {
        let t = (value.clamp(self.low, self.high) - self.low) / (self.high - self.low);
        self.start + t * (self.end - self.start)
    }

    /// Round values between the ends, all of them with labels.
    fn ticks(&self) -> Vec<Tick> {
        let rough = (self.high - self.low) / f64::from(self.parts);
        let decade = 10_f64.powf(rough.log10().floor());
        let fits = [1.0, 2.0, 2.5, 5.0, 10.0].map(|multiple| multiple * decade);
        let step = fits.into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * decade);
        let first = (self.low / step).ceil();
        (0..2 * self.parts)
            .map(|i| (first + f64::from(i)) * step)
            .take_while(|value| *value <= self.high)
            .map(|value| Tick {
                value,
                position: self.position(value),
                labelled: true,
            })
            .collect()
    }
}

/// Maps positive values to pixels, and knows where to put its ticks.
#[derive(Debug, Clone, Copy)]
pub(super) struct LogAxis {
    /// log10 of the values at the two ends.
    low: f64,
    high: f64,
    /// Pixels of the two ends.
    start: f64,
    end: f64,
}

/// A line of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tick {
    pub(super) value: f64,
    pub(super) position: f64,
    /// Wants a number beside it.
    pub(super) labelled: bool,
}

impl LogAxis {
    /// An axis with some air around the given values, from pixel `start` to
    /// `end`. Values that are not positive and finite are ignored; `None` if
    /// there are no others.
    pub(super) fn around(values: impl Iterator<Item = f64>, start: f64, end: f64) -> Option<Self> {
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
    pub(super) fn position(&self, value: f64) -> f64 {
        let log = value.max(f64::MIN_POSITIVE).log10();
        let t = (log.clamp(self.low, self.high) - self.low) / (self.high - self.low);
        self.start + t * (self.end - self.start)
    }

    /// Powers of ten with labels, and their multiples without; the 2 and the 5
    /// have labels too where there would be fewer than three.
    pub(super) fn ticks(&self) -> Vec<Tick> {
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

    #[test]
    fn even_ticks_are_round_and_inside() {
        let ticks = |low: f64, high: f64| -> Vec<f64> {
            let values = [low, f64::NAN, high, f64::INFINITY];
            let ruler = Ruler::new(Scale::Linear, values.into_iter(), (0.0, 100.0), 6);
            let ticks = ruler.unwrap().ticks();
            assert!(ticks.iter().all(|t| (0.0..=100.0).contains(&t.position)));
            ticks.into_iter().map(|tick| tick.value).collect()
        };
        assert_eq!(ticks(0.0, 6.0), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        for (low, high) in [(-3.2, 8.9), (1e6, 1e6 + 3.0), (-1e-9, 1e-9), (1e30, 3e30)] {
            let ticks = ticks(low, high);
            assert!((2..=8).contains(&ticks.len()), "{low} {high}: {ticks:?}");
            assert!(ticks.iter().all(|tick| low <= *tick && *tick <= high));
        }
        let unit = Ruler::new(Scale::Between(0.0, 1.0), [].into_iter(), (1.0, 0.0), 4);
        let values = unit.unwrap().ticks().into_iter().map(|tick| tick.value);
        assert_eq!(values.collect::<Vec<_>>(), [0.0, 0.25, 0.5, 0.75, 1.0]);
    }

    #[test]
    fn an_even_axis_of_nothing_or_of_one_value_is_none() {
        for values in [&[][..], &[1.0, 1.0], &[f64::NAN, f64::INFINITY, 2.0]] {
            let values = values.iter().copied();
            assert!(Ruler::new(Scale::Linear, values, (0.0, 1.0), 6).is_none());
        }
    }

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

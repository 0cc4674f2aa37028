//! Forecasts beside the measurements that they are about.

use std::time::Instant;

use lighting::prediction::Prediction;

use super::Foreseen;
use crate::compare::budget::Budget;
use crate::compare::measure::{Job, Truth, measure};
use crate::compare::results::Measurement;
use crate::compare::selection::Candidate;
use crate::compare::truth;
use crate::failure::Failure;
use crate::format::{count, significant};

/// Errors below this count as this.
pub(super) const LEAST_ERROR: f64 = 1e-5;

/// The spread of the time of a copy beyond which times are not compared.
pub(super) const QUIET: f64 = 0.2;

/// A row of a forecast with its measurement.
pub(super) struct Pair {
    pub(super) expected: Prediction,
    pub(super) actual: Measurement,
}

/// All rows, and how quiet the machine was.
pub(super) struct Analysis {
    pub(super) pairs: Vec<Pair>,
    /// How much longer the slowest of a few groups of copies took than the fastest: 0.1 is
    /// 10 %.
    pub(super) copy_spread: f64,
}

/// Measures, as a comparison does, everything that was foreseen.
pub(super) fn analyze(job: Job<'_>, forecasts: &[Foreseen<'_>]) -> Result<Analysis, Failure> {
    let (reference, _) = truth::converge(&job, job.view.rays(), 1e-6, false);
    let truth = Truth::new(job.size, &reference);
    let mut probe = Copies::new();
    let mut copies = vec![probe.seconds()];
    let mut pairs = Vec::new();
    for (device, candidates, forecast) in forecasts {
        let measured: Vec<Candidate> = candidates.iter().map(|c| (*c).clone()).collect();
        let budget = Budget::unlimited();
        let outcome = match measure(device, job, &measured, &truth, budget, None) {
            Ok(outcome) => outcome,
            Err(failure) => {
                device.excuse(failure)?;
                continue;
            }
        };
        copies.push(probe.seconds());
        for row in &forecast.rows {
            let candidate = candidates[row.setting];
            let is_it =
                |m: &&Measurement| (m.method, m.quality) == (candidate.method, candidate.quality);
            if let Some(actual) = outcome.measurements.iter().find(is_it) {
                pairs.push(Pair {
                    expected: row.clone(),
                    actual: actual.clone(),
                });
            }
        }
    }
    copies.push(probe.seconds());
    let [least, most] = [f64::min, f64::max].map(|pick| copies.iter().copied().reduce(pick));
    Ok(Analysis {
        pairs,
        copy_spread: most
            .zip(least)
            .map_or(0.0, |(most, least)| most / least - 1.0),
    })
}

/// A copy of 32 MiB, always between the same pages: what others of another size or place take
/// says nothing about how quiet the machine is.
struct Copies {
    from: Vec<u8>,
    to: Vec<u8>,
}

impl Copies {
    fn new() -> Self {
        let bytes = 1 << 25;
        Self {
            from: vec![1; bytes],
            to: vec![0; bytes],
        }
    }

    /// The shortest time of a few copies.
    fn seconds(&mut self) -> f64 {
        let times = (0..8).map(|_| {
            let clock = Instant::now();
            self.to.copy_from_slice(std::hint::black_box(&self.from));
            std::hint::black_box(&mut self.to);
            clock.elapsed().as_secs_f64()
        });
        times.fold(f64::INFINITY, f64::min)
    }
}

impl Pair {
    /// The q-error of the time of a frame.
    pub(super) fn time(&self) -> f64 {
        ratio(self.expected.frame, self.actual.frame.low)
    }

    /// The q-error of the RMSE.
    pub(super) fn error(&self) -> f64 {
        let least = |x: f64| x.max(LEAST_ERROR);
        ratio(least(self.expected.rmse), least(self.actual.error.rmse))
    }
}

/// How many times one is the other, from 1.
fn ratio(a: f64, b: f64) -> f64 {
    (a / b).max(b / a)
}

impl Analysis {
    /// A table and its summary.
    pub(super) fn describe(&self) -> String {
        let width = self
            .pairs
            .iter()
            .map(|pair| pair.expected.method.len())
            .max();
        let width = width.unwrap_or(0).max(6);
        let mut text = format!(
            "\n{:width$}  {:>7}  {:>10} {:>10} {:>6}  {:>10} {:>10}  {:>9} {:>9} {:>6}\n",
            "method",
            "quality",
            "frame ms",
            "actual",
            "q",
            "once ms",
            "actual",
            "RMSE %",
            "actual",
            "q",
        );
        for pair in &self.pairs {
            let Pair { expected, actual } = pair;
            text += &format!(
                "{:width$}  {:>7}  {:>10.3} {:>10.3} {:>6.2}  {:>10.3} {:>10.3}  {:>9.4} {:>9.4} {:>6.2}\n",
                expected.method,
                expected.quality,
                1e3 * expected.frame,
                1e3 * actual.frame.low,
                pair.time(),
                1e3 * expected.once,
                1e3 * actual.seconds_build,
                100.0 * expected.rmse,
                100.0 * actual.error.rmse,
                pair.error(),
            );
        }
        let [time, error] = [Pair::time, Pair::error].map(|of| {
            let all: Vec<f64> = self.pairs.iter().map(of).collect();
            [quantile(&all, 0.5), quantile(&all, 0.95)].map(significant)
        });
        text += &format!(
            "{}: q-errors of time, median {} and 95th percentile {}; of RMSE, {} and {}\n",
            count(self.pairs.len(), "row"),
            time[0],
            time[1],
            error[0],
            error[1],
        );
        if self.copy_spread > QUIET {
            text += &format!(
                "the times are not to be judged: copies of memory took up to {:.0} % longer than \
                 the fastest\n",
                100.0 * self.copy_spread
            );
        }
        text
    }
}

/// The value that a share of all does not exceed.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = (share * sorted.len() as f64).ceil() as usize;
    let place = place.clamp(1, sorted.len().max(1)) - 1;
    sorted.get(place).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_of_the_list() {
        let values: Vec<f64> = (1..=20).rev().map(f64::from).collect();
        assert_eq!(quantile(&values, 0.5), 10.0);
        assert_eq!(quantile(&values, 0.95), 19.0);
        assert_eq!(quantile(&[3.0], 0.95), 3.0);
        assert!(quantile(&[], 0.5).is_nan());
        assert_eq!(ratio(2.0, 1.0), 2.0);
        assert_eq!(ratio(1.0, 4.0), 4.0);
    }
}

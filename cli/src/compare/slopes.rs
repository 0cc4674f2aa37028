//! How fast errors fall: the slope of each curve of the plot.

use reference::metrics::log_slope;

use super::results::Measurement;

/// The slope of the error of one method on one backend, by least squares over all
/// its qualities.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slope {
    /// Index of the method.
    pub(crate) method: usize,
    pub(crate) backend: String,
    /// Log error over log quality: minus the order of convergence. `None` with
    /// fewer than two qualities or errors that are not positive.
    pub(crate) over_quality: Option<f64>,
    /// Log error over log frame time.
    pub(crate) over_time: Option<f64>,
}

/// The slopes of everything that was measured, in the order of the measurements.
pub(crate) fn slopes(measurements: &[Measurement]) -> Vec<Slope> {
    let mut all: Vec<Slope> = Vec::new();
    for first in measurements {
        let is_same =
            |method: usize, backend: &str| method == first.method && backend == first.backend;
        if all
            .iter()
            .any(|slope| is_same(slope.method, &slope.backend))
        {
            continue;
        }
        let own = measurements
            .iter()
            .filter(|m| is_same(m.method, &m.backend));
        let slope = |x: fn(&Measurement) -> f64| {
            let points: Vec<_> = own.clone().map(|m| (x(m), m.error.rmse)).collect();
            Some(log_slope(&points)).filter(|slope| slope.is_finite())
        };
        all.push(Slope {
            method: first.method,
            backend: first.backend.clone(),
            over_quality: slope(|m| f64::from(m.quality)),
            over_time: slope(|m| m.frame.median),
        });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::example;

    #[test]
    fn a_curve_of_second_order_has_the_slope_minus_two() {
        let results = example();
        let all = slopes(&results.measurements);
        assert_eq!(all.len(), results.methods.len());
        // Errors of the example are quality^-1 and quality^-2 in turn, its times
        // proportional to quality.
        for slope in &all {
            let expected = match slope.method {
                // Of one quality.
                0 => None,
                method => Some(-1.0 - (method % 2) as f64),
            };
            for found in [slope.over_quality, slope.over_time] {
                match (found, expected) {
                    (Some(found), Some(expected)) => assert!((found - expected).abs() < 1e-9),
                    both => assert_eq!(both, (None, None), "{slope:?}"),
                }
            }
        }
    }
}

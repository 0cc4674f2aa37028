//! Settings whose forecast does not say whether they are within a time.

use super::{Forecast, Known, Prediction, Target};

/// Forecasts of times are rarely off by more than this factor.
const DOUBT: f64 = 1.3;

/// How often a setting is run that is in doubt.
pub(super) const FRAMES: usize = 3;

impl Forecast {
    /// Measures the settings in doubt that a choice for `target` depends on. These are the ones
    /// that are expected to take between 1/1.3 and 1.3 times the time of the target, and whose
    /// error is below that of each setting that takes less: if such a setting is within the time
    /// it is the best. They are measured in the order of their errors until one is.
    ///
    /// `measure` gives the seconds of a frame of the whole picture; `None` if the setting fails,
    /// whose row is taken out then. Measurements that would take more than `seconds` together
    /// are not made; the forecast decides there. Times are those of [`Forecast::choose`] for
    /// as many frames. A target for the error needs no measurements.
    ///
    /// # Errors
    /// Those of `measure`.
    pub fn settle<E>(
        &mut self,
        target: Target,
        frames: f64,
        mut seconds: f64,
        mut measure: impl FnMut(&Prediction) -> Result<Option<f64>, E>,
    ) -> Result<(), E> {
        let Target::Time(limit) = target else {
            return Ok(());
        };
        let mut order: Vec<usize> = (0..self.rows.len()).collect();
        order.retain(|row| self.rows[*row].rmse.is_finite());
        order.sort_by(|a, b| self.rows[*a].rmse.total_cmp(&self.rows[*b].rmse));
        let mut failed = Vec::new();
        for index in order {
            let row = &mut self.rows[index];
            let expected = row.seconds(frames);
            if expected > DOUBT * limit {
                continue;
            }
            if DOUBT * expected <= limit {
                break;
            }
            let takes = row.trial();
            if takes > seconds {
                continue;
            }
            seconds -= takes;
            let Some(frame) = measure(row)? else {
                failed.push(index);
                continue;
            };
            (row.frame, row.known) = (frame, Known::Timed);
            if row.seconds(frames) <= limit {
                break;
            }
        }
        let mut index = 0;
        self.rows.retain(|_| {
            index += 1;
            !failed.contains(&(index - 1))
        });
        Ok(())
    }
}

impl Prediction {
    /// Seconds that it is expected to take to measure the time of a frame.
    fn trial(&self) -> f64 {
        let made = match self.known {
            // What it needs is there.
            Known::Probed | Known::Tried | Known::Timed => 0.0,
            Known::Interpolated => self.once,
        };
        made + FRAMES as f64 * self.frame
    }
}

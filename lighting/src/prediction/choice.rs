//! The choice of a setting that meets a target.

use std::fmt;

use super::{Forecast, Prediction};

/// What is asked of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Its relative RMSE is at most this.
    Error(f64),
    /// It takes at most so many seconds.
    Time(f64),
}

/// No setting meets a target.
#[derive(Debug, Clone, PartialEq)]
pub struct Unmet {
    /// What was asked for.
    pub target: Target,
    /// The setting that comes nearest, if there is any forecast.
    pub nearest: Option<Prediction>,
}

impl Forecast {
    /// The setting that meets a target: the fastest within an error, or the most accurate
    /// within a time. The time is [`Prediction::seconds`] for so many frames, the start of the
    /// backend included. Of equal settings the first is taken.
    ///
    /// # Errors
    /// [`Unmet`] if no setting meets the target.
    pub fn choose(&self, target: Target, frames: f64) -> Result<&Prediction, Box<Unmet>> {
        let of_error = |row: &Prediction| row.rmse;
        let of_time = |row: &Prediction| row.seconds(frames);
        let (limit, within, least): (f64, &Measure<'_>, &Measure<'_>) = match target {
            Target::Error(limit) => (limit, &of_error, &of_time),
            Target::Time(limit) => (limit, &of_time, &of_error),
        };
        let rows = self.rows.iter().filter(|row| row.rmse.is_finite());
        let meeting = rows.clone().filter(|row| within(row) <= limit);
        meeting
            .min_by(|a, b| least(a).total_cmp(&least(b)))
            .ok_or_else(|| {
                let nearest = rows.min_by(|a, b| within(a).total_cmp(&within(b)));
                Box::new(Unmet {
                    target,
                    nearest: nearest.cloned(),
                })
            })
    }
}

/// The time or the error of a row.
type Measure<'a> = dyn Fn(&Prediction) -> f64 + 'a;

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Error(error) => write!(f, "an error of {:.3} %", 100.0 * error),
            Self::Time(seconds) => write!(f, "a time of {:.3} ms", 1e3 * seconds),
        }
    }
}

impl fmt::Display for Unmet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "nothing is expected to meet {}", self.target)?;
        match &self.nearest {
            Some(row) => write!(f, "; the nearest is {row}"),
            None => f.write_str(": no method is foreseen"),
        }
    }
}

impl std::error::Error for Unmet {}

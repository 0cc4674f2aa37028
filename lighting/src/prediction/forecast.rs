//! The result of a probe.

use std::fmt;

/// What is expected of a setting on a backend.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Index of the setting in the list that was probed.
    pub setting: usize,
    /// The name of the method.
    pub method: String,
    /// The backend.
    pub backend: String,
    /// The quality.
    pub quality: u32,
    /// The unit of the quality.
    pub unit: &'static str,
    /// Seconds that the backend takes to start: until its device is ready, and what the first
    /// frame takes longer than later ones. 0 if it runs already.
    pub start: f64,
    /// Seconds before the first frame, after the start.
    pub once: f64,
    /// Seconds per frame.
    pub frame: f64,
    /// Memory that is kept between frames, bytes.
    pub bytes: u64,
    /// Root mean square error over the mean radiance.
    pub rmse: f64,
    /// Its standard error; if this quality was not probed, that of the nearest one that was.
    pub rmse_spread: f64,
    /// How time and error were found.
    pub known: Known,
    /// Counted work before the first frame, and per frame.
    pub counted: [f64; 2],
}

/// How the time and the error of a setting were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Known {
    /// Both were measured on the sample.
    Probed,
    /// The error was measured on the sample; the time follows from other qualities.
    Tried,
    /// The error lies between those of two other qualities; the time follows from other
    /// qualities.
    Interpolated,
    /// The time was measured on the whole picture, see [`Forecast::settle`].
    Timed,
}

/// A setting without a forecast.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skipped {
    /// Index of the setting; see [`Prediction::setting`].
    pub setting: usize,
    /// The method and its quality.
    pub what: String,
    /// The reason.
    pub why: String,
}

/// The forecast for all settings. `Display` writes it as a table.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Forecast {
    /// The forecasts, in the order of the settings.
    pub rows: Vec<Prediction>,
    /// Settings that have no row.
    pub skipped: Vec<Skipped>,
}

impl Prediction {
    /// Seconds per frame, if so many frames share the start of the backend and what is made
    /// before the first frame; the number may be infinite.
    pub fn seconds(&self, frames: f64) -> f64 {
        self.frame + (self.start + self.once) / frames
    }
}

impl Known {
    /// A word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Probed => "probed",
            Self::Tried => "tried",
            Self::Interpolated => "interpolated",
            Self::Timed => "timed",
        }
    }
}

impl fmt::Display for Prediction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} with {} {} on {}: {:.2} ms a frame, {:.2} ms before the first, RMSE {:.3} %",
            self.method,
            self.quality,
            self.unit,
            self.backend,
            1e3 * self.frame,
            1e3 * self.once,
            100.0 * self.rmse,
        )?;
        match self.start > 0.0 {
            true => write!(f, ", {:.0} ms to start", 1e3 * self.start),
            false => Ok(()),
        }
    }
}

impl fmt::Display for Forecast {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|row| row.method.len()).max();
        let width = width.unwrap_or(0).max(6);
        writeln!(
            f,
            "{:width$}  {:>7}  {:>8}  {:>10}  {:>10}  {:>9}  {:>9}  {:>8}  known",
            "method", "quality", "start ms", "once ms", "frame ms", "MiB", "RMSE %", "±",
        )?;
        for row in &self.rows {
            writeln!(
                f,
                "{:width$}  {:>7}  {:>8.0}  {:>10.3}  {:>10.3}  {:>9.2}  {:>9.4}  {:>8.4}  {}, {}",
                row.method,
                row.quality,
                1e3 * row.start,
                1e3 * row.once,
                1e3 * row.frame,
                row.bytes as f64 / f64::from(1 << 20),
                100.0 * row.rmse,
                100.0 * row.rmse_spread,
                row.known.name(),
                row.backend,
            )?;
        }
        for Skipped { what, why, .. } in &self.skipped {
            writeln!(f, "not foreseen: {what} ({why})")?;
        }
        Ok(())
    }
}

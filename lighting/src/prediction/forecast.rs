//! What comes out of a probe.

use std::fmt;

/// What is expected of a setting on a backend.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// The setting, by its place in the list that was probed.
    pub setting: usize,
    /// The name of the method.
    pub method: String,
    /// The backend.
    pub backend: String,
    /// The quality.
    pub quality: u32,
    /// What the quality is a number of.
    pub unit: &'static str,
    /// Seconds before the first frame.
    pub once: f64,
    /// Seconds per frame.
    pub frame: f64,
    /// Memory for what is kept, bytes.
    pub bytes: u64,
    /// RMSE over the mean radiance.
    pub rmse: f64,
    /// Its standard error; that of the nearest probed quality if this one was not.
    pub rmse_spread: f64,
    /// How all this is known.
    pub known: Known,
    /// Counted work before the first frame, and of a frame.
    pub counted: [f64; 2],
}

/// How something is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Known {
    /// Its time and its error were found on the sample.
    Probed,
    /// Its error was; its time is that between other qualities, or beyond them.
    Tried,
    /// Its error is that between two other qualities, its time too or beyond them.
    Interpolated,
}

/// A setting of which nothing is foreseen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skipped {
    /// See [`Prediction::setting`].
    pub setting: usize,
    /// The method and its quality.
    pub what: String,
    /// Why not.
    pub why: String,
}

/// What is expected of all settings.
///
/// `Display` writes it as a table.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Forecast {
    /// In the order of the settings.
    pub rows: Vec<Prediction>,
    /// Settings that have no row.
    pub skipped: Vec<Skipped>,
}

impl Prediction {
    /// Seconds per frame where what is made once is shared by so many frames, which may be
    /// infinitely many.
    pub fn seconds(&self, frames: f64) -> f64 {
        self.frame + self.once / frames
    }
}

impl Known {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Probed => "probed",
            Self::Tried => "tried",
            Self::Interpolated => "interpolated",
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
        )
    }
}

impl fmt::Display for Forecast {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|row| row.method.len()).max();
        let width = width.unwrap_or(0).max(6);
        writeln!(
            f,
            "{:width$}  {:>7}  {:>10}  {:>10}  {:>9}  {:>9}  {:>8}  known",
            "method", "quality", "once ms", "frame ms", "MiB", "RMSE %", "±",
        )?;
        for row in &self.rows {
            writeln!(
                f,
                "{:width$}  {:>7}  {:>10.3}  {:>10.3}  {:>9.2}  {:>9.4}  {:>8.4}  {}, {}",
                row.method,
                row.quality,
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

//! Backends that take longer to start than they save.

use super::{Forecast, Prediction};

/// A backend that need not be started, because others finish each of its settings first.
#[derive(Debug, Clone, PartialEq)]
pub struct SlowStart {
    /// The backend.
    pub backend: String,
    /// Seconds that it takes to start: the shortest over its settings.
    pub start: f64,
    /// The number of frames from which it finishes some setting first; infinite if it never
    /// does.
    pub pays_from: f64,
    /// Seconds that are saved at least, whatever the setting.
    pub saving: f64,
}

impl Forecast {
    /// The backends on which every setting is finished later than on another backend, if there
    /// are so many frames, at least one. Start and preparation count, so that what
    /// [`Forecast::choose`] takes is done no later without these backends.
    ///
    /// A backend that runs already (whose start is 0) is not in the list, nor is one with a
    /// setting that no other backend has. An infinite number of frames makes the list empty.
    pub fn slow_starts(&self, frames: f64) -> Vec<SlowStart> {
        let mut names: Vec<&str> = Vec::new();
        for row in &self.rows {
            if row.start > 0.0 && !names.contains(&row.backend.as_str()) {
                names.push(&row.backend);
            }
        }
        let slow = |name: &str| {
            let own = self.rows.iter().filter(|row| row.backend == name);
            let start = own.clone().map(|row| row.start);
            let mut found = SlowStart {
                backend: name.into(),
                start: start.fold(f64::INFINITY, f64::min),
                pays_from: f64::INFINITY,
                saving: f64::INFINITY,
            };
            for row in own {
                let other = self.soonest_elsewhere(row, frames)?;
                found.pays_from = found.pays_from.min(pays_from(row, other));
                let saved = row.seconds(frames) - other.seconds(frames);
                found.saving = found.saving.min(saved * frames);
            }
            (frames < found.pays_from).then_some(found)
        };
        names.into_iter().filter_map(slow).collect()
    }

    /// The same setting on the other backend that finishes it first.
    fn soonest_elsewhere(&self, row: &Prediction, frames: f64) -> Option<&Prediction> {
        let is_same = |other: &&Prediction| {
            other.backend != row.backend
                && (&other.method, other.quality) == (&row.method, row.quality)
        };
        let others = self.rows.iter().filter(is_same);
        others.min_by(|a, b| a.seconds(frames).total_cmp(&b.seconds(frames)))
    }
}

/// The smallest number of frames that `row` finishes before `other`.
fn pays_from(row: &Prediction, other: &Prediction) -> f64 {
    let later = (row.start + row.once) - (other.start + other.once);
    let gain = other.frame - row.frame;
    if later < gain {
        1.0
    } else if gain > 0.0 {
        (later / gain).floor() + 1.0
    } else {
        f64::INFINITY
    }
}

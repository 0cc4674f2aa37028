//! The known costs of a machine.

use std::collections::BTreeMap;

use super::{Forecast, Known};
use crate::methods::Work;

/// Seconds per unit of [counted work](crate::methods::Work) of a method on a backend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Costs {
    /// Cost of what is made before the first frame.
    pub once: f64,
    /// Cost of a frame, per unit of the work of the frame and of all its rays.
    pub frame: f64,
}

impl Costs {
    /// The assumed costs of an unknown method: a unit of work takes about this long on a CPU
    /// core of 2020.
    pub const ASSUMED: Self = Self {
        once: 1e-8,
        frame: 1e-8,
    };
}

/// The costs of methods on a machine; see the [module](super).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Profile {
    costs: BTreeMap<(String, String), Costs>,
    starts: BTreeMap<String, f64>,
}

/// Counted work of a frame with so many rays.
pub(super) fn counted(work: &Work, rays: usize) -> f64 {
    (work.per_frame + work.per_ray * rays as f64).max(1.0)
}

impl Profile {
    /// A profile that knows no method.
    pub fn new() -> Self {
        Self::default()
    }

    /// A profile with the median costs of each method over what was probed of some scenes.
    /// Costs that were not probed are assumed. A backend starts in the shortest time of any
    /// method in a scene, and in the longest of these times, because a driver starts faster when
    /// it has been started before.
    pub fn learned<'a>(forecasts: impl IntoIterator<Item = &'a Forecast>) -> Self {
        let mut all: BTreeMap<(String, String), Vec<Costs>> = BTreeMap::new();
        let forecasts: Vec<&Forecast> = forecasts.into_iter().collect();
        let mut starts: BTreeMap<String, f64> = BTreeMap::new();
        for forecast in &forecasts {
            let mut shortest: BTreeMap<&str, f64> = BTreeMap::new();
            for row in forecast.rows.iter().filter(|row| row.start > 0.0) {
                let start = shortest.entry(&row.backend).or_insert(row.start);
                *start = start.min(row.start);
            }
            for (backend, start) in shortest {
                let longest = starts.entry(backend.into()).or_insert(start);
                *longest = longest.max(start);
            }
        }
        let rows = forecasts.into_iter().flat_map(|forecast| &forecast.rows);
        for row in rows.filter(|row| row.known == Known::Probed) {
            let key = (row.backend.clone(), row.method.clone());
            let [once, frame] = row.counted;
            all.entry(key).or_default().push(Costs {
                once: row.once / once,
                frame: row.frame / frame,
            });
        }
        let of = |costs: &[Costs]| Costs {
            once: median(costs.iter().map(|c| c.once)).unwrap_or(Costs::ASSUMED.once),
            frame: median(costs.iter().map(|c| c.frame)).unwrap_or(Costs::ASSUMED.frame),
        };
        Self {
            costs: all
                .into_iter()
                .map(|(key, some)| (key, of(&some)))
                .collect(),
            starts,
        }
    }

    /// Sets the costs of a method, in place of earlier ones.
    pub fn insert(&mut self, backend: &str, method: &str, costs: Costs) {
        self.costs.insert((backend.into(), method.into()), costs);
    }

    /// Sets the seconds that a backend takes to start.
    pub fn insert_start(&mut self, backend: &str, seconds: f64) {
        self.starts.insert(backend.into(), seconds);
    }

    /// The seconds that backends take to start, by backend, as far as they are known.
    pub fn starts(&self) -> impl Iterator<Item = (&str, f64)> {
        let all = self.starts.iter();
        all.map(|(backend, seconds)| (backend.as_str(), *seconds))
    }

    /// Seconds until a method of this work has made a first picture of so many rays on a
    /// backend that has to be started. A start that is not known counts as 0, as that of the
    /// CPU is.
    pub fn first_picture(&self, backend: &str, method: &str, work: &Work, rays: usize) -> f64 {
        let costs = self.costs(backend, method);
        let start = self.starts.get(backend).copied().unwrap_or(0.0);
        start + costs.once * work.once + costs.frame * counted(work, rays)
    }

    /// The known costs of a method, or the assumed ones.
    pub fn costs(&self, backend: &str, method: &str) -> Costs {
        let key = (backend.to_owned(), method.to_owned());
        self.costs.get(&key).copied().unwrap_or(Costs::ASSUMED)
    }

    /// All known costs, by backend and method.
    pub fn all(&self) -> impl Iterator<Item = (&str, &str, Costs)> {
        let all = self.costs.iter();
        all.map(|((backend, method), costs)| (backend.as_str(), method.as_str(), *costs))
    }

    /// Whether no method is known.
    pub fn is_empty(&self) -> bool {
        self.costs.is_empty()
    }
}

/// The lower median of the values that are finite and positive.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.filter(|x| x.is_finite() && *x > 0.0).collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied()
}

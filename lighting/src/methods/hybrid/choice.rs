//! Whether looking for shadow volumes costs less than it saves.

use gpu_backend::Host;

use super::{Asking, ShadowVolumes};
use crate::scene::{Emitter, Medium};
use crate::{LightPath, Ray};

/// Rays that are looked at, about.
const SAMPLES: usize = 64;

/// What the search costs for a ray, and for each cell that it looks at, in steps:
/// measured on a CPU in the embedded scenes.
const RAY: f64 = 4.0;
const CELL: f64 = 1.6;

/// What a search for shadow volumes does for the rays of a frame: means of some of those
/// that the light can reach.
///
/// In place of the map, which may be in the memory of a GPU, the finest volumes are
/// asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// Steps of a whole ray.
    pub steps: u32,
    /// Steps that the map has to be asked about.
    pub asked: f64,
    /// Cells that are looked at.
    pub cells: f64,
}

impl Choice {
    /// For so many steps of a whole ray (0 counts as 1). `None` if the light reaches no
    /// ray.
    pub fn new(
        volumes: &ShadowVolumes<Host>,
        rays: &[Ray],
        emitter: &Emitter,
        medium: &Medium,
        steps: u32,
    ) -> Option<Self> {
        let steps = steps.max(1);
        // An odd stride does not stay in the columns of a picture.
        let stride = (rays.len() / SAMPLES) | 1;
        let (mut asked, mut cells, mut count) = (0_u64, 0_u64, 0_u64);
        for ray in rays.iter().step_by(stride) {
            let Some(path) = LightPath::new(ray, emitter, medium) else {
                continue;
            };
            let mut asking = Asking::new(&path, volumes.origin(), Some(volumes), steps);
            while asking.next(|x| !volumes.contains(ray.at(x))).is_some() {
                asked += 1;
            }
            cells += u64::from(asking.cells);
            count += 1;
        }
        let mean = |sum: u64| sum as f64 / count as f64;
        (count > 0).then(|| Self {
            steps,
            asked: mean(asked),
            cells: mean(cells),
        })
    }

    /// Steps that need not be asked about.
    pub fn saved(&self) -> f64 {
        f64::from(self.steps) - self.asked
    }

    /// What the search costs, in steps.
    pub fn cost(&self) -> f64 {
        RAY + CELL * self.cells
    }

    /// Whether the search costs less than it saves.
    pub fn is_worth_it(&self) -> bool {
        self.cost() < self.saved()
    }
}

//! Whether looking for volumes of shadow and light costs less than it saves.

use gpu_backend::Host;

use super::{Asking, ShadowVolumes, Spread, Volumes};
use crate::scene::{Emitter, Medium};
use crate::{LightPath, Ray};

/// Rays that are looked at, about.
const SAMPLES: usize = 64;

/// What the search costs for a ray, and for each cell that it looks at, in steps:
/// measured on a CPU in the embedded scenes.
const RAY: f64 = 4.0;
const CELL: f64 = 1.6;

/// What a search for volumes does for the rays of a frame: means of some of those
/// that the light can reach.
///
/// In place of the map, which may be in the memory of a GPU, the finest volumes are
/// asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// Steps of a ray.
    pub steps: u32,
    /// Steps of whole rays that would be as short, by root mean squares: those of the
    /// rays, unless they are spread over spans.
    pub as_short: f64,
    /// Steps that the map has to be asked about.
    pub asked: f64,
    /// Those of them that are dark.
    pub dark: f64,
    /// Cells that are looked at.
    pub cells: f64,
}

impl Choice {
    /// For the volumes that are looked for, and so many steps (0 counts as 1) that are
    /// spread over spans or whole rays; `map` are the volumes of shadow that stand for the
    /// map. `None` if the light reaches no ray.
    pub fn new(
        map: &ShadowVolumes<Host>,
        volumes: Volumes<'_>,
        rays: &[Ray],
        emitter: &Emitter,
        medium: &Medium,
        (steps, spread): (u32, Spread),
    ) -> Option<Self> {
        let steps = steps.max(1);
        // An odd stride does not stay in the columns of a picture.
        let stride = (rays.len() / SAMPLES) | 1;
        let (mut asked, mut dark, mut cells, mut count) = (0_u64, 0_u64, 0_u64, 0_u64);
        // Sums of squares of the lengths of rays and of what their steps are spread over.
        let mut squares = [0.0, 0.0];
        for ray in rays.iter().step_by(stride) {
            let Some(path) = LightPath::new(ray, emitter, medium) else {
                continue;
            };
            let mut asking = Asking::new(&path, map.cells.origin, volumes, (steps, spread));
            let lengths = [asking.whole(), asking.part()].map(|part| f64::from(part.length()));
            for (sum, length) in squares.iter_mut().zip(lengths) {
                *sum += length * length;
            }
            while let Some((_, is_lit)) = asking.next(|x| !map.contains(ray.at(x))) {
                asked += 1;
                dark += u64::from(!is_lit);
            }
            cells += u64::from(asking.cells);
            count += 1;
        }
        let mean = |sum: u64| sum as f64 / count as f64;
        let longer = match spread {
            Spread::Span if squares[1] > 0.0 => (squares[0] / squares[1]).sqrt(),
            _ => 1.0,
        };
        (count > 0).then(|| Self {
            steps,
            as_short: longer * f64::from(steps),
            asked: mean(asked),
            dark: mean(dark),
            cells: mean(cells),
        })
    }

    /// Steps of whole rays, as short as these, that need not be asked about.
    pub fn saved(&self) -> f64 {
        self.as_short - self.asked
    }

    /// What the search costs, in steps.
    pub fn cost(&self) -> f64 {
        RAY + CELL * self.cells
    }

    /// What a ray costs, in steps as long as those of another choice.
    pub fn cost_at(&self, other: &Self) -> f64 {
        self.cost() + self.asked * other.as_short / self.as_short
    }

    /// Whether the search costs less than it saves.
    pub fn is_worth_it(&self) -> bool {
        self.cost() < self.saved()
    }
}

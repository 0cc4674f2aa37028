//! The decision whether searching volumes of shadow and light costs less than it saves.

use gpu_backend::Host;

use super::{Asking, ShadowVolumes, Spread, Volumes};
use crate::scene::{Emitter, Medium};
use crate::{LightPath, Ray};

/// Roughly the number of rays that the decision is based on.
const SAMPLES: usize = 64;

/// The cost of a search per ray, and per cell that it visits, in steps: measured on a CPU in
/// the embedded scenes.
const RAY: f64 = 4.0;
const CELL: f64 = 1.6;

/// What a search of volumes achieves for the rays of a frame: means over some of those that the
/// light can reach.
///
/// The map may be in the memory of a GPU, so the finest volumes are asked in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// Number of steps per ray.
    pub steps: u32,
    /// The number of steps of whole rays that would be as short as these, by root mean squares.
    /// It is the number of steps unless they are spread over spans.
    pub as_short: f64,
    /// Number of steps that have to ask the map.
    pub asked: f64,
    /// Number of those that are dark.
    pub dark: f64,
    /// Number of cells that are visited.
    pub cells: f64,
}

impl Choice {
    /// The means for the volumes that are searched and for `steps` steps (0 counts as 1) that
    /// are spread over spans or whole rays. `map` are the shadow volumes that take the place of
    /// the map. `None` if the light reaches no ray.
    pub fn new(
        map: &ShadowVolumes<Host>,
        volumes: Volumes<'_>,
        rays: &[Ray],
        emitter: &Emitter,
        medium: &Medium,
        (steps, spread): (u32, Spread),
    ) -> Option<Self> {
        let steps = steps.max(1);
        // An odd stride does not stay within a few columns of a picture.
        let stride = (rays.len() / SAMPLES) | 1;
        let (mut asked, mut dark, mut cells, mut count) = (0_u64, 0_u64, 0_u64, 0_u64);
        // Sums of the squared lengths of rays, and of the parts over which their steps are
        // spread.
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

    /// Number of steps of whole rays, as short as these, that need not ask the map.
    pub fn saved(&self) -> f64 {
        self.as_short - self.asked
    }

    /// The cost of the search, in steps.
    pub fn cost(&self) -> f64 {
        RAY + CELL * self.cells
    }

    /// The cost of a ray, in steps as long as those of another choice.
    pub fn cost_at(&self, other: &Self) -> f64 {
        self.cost() + self.asked * other.as_short / self.as_short
    }

    /// Whether the search costs less than it saves.
    pub fn is_worth_it(&self) -> bool {
        self.cost() < self.saved()
    }
}

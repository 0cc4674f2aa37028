//! The choice of the rays of a picture that are gathered.

use gpu_backend::{Cpu, Error};

use super::Reduction;
use super::grid::{Filter, Grid};
use super::resemblance::{Plane, Seen, planes};
use crate::methods::{FrameInputs, Selection};
use crate::scene::trace::Hit;
use crate::{Interleaving, Ray};

/// Takes the place of a ray index for a pixel that has no ray of its own.
pub(super) const NONE: u32 = u32::MAX;

/// The rays of a picture that a reduction gathers: those of the samples, and those of the
/// pixels that no sample resembles.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    pub(super) grid: Grid,
    /// The surface that each pixel of the picture sees.
    pub(super) planes: Vec<Plane>,
    /// The pixel of each gathered ray, samples first.
    pixels: Vec<u32>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    /// For each sample the index of a ray that takes all parts for it, or [`NONE`]; empty if
    /// samples are used as they are.
    pub(super) of_samples: Vec<u32>,
    /// For each pixel the index of a ray of its own, or [`NONE`]; empty if every pixel is a
    /// sample.
    pub(super) of_pixels: Vec<u32>,
    alone: usize,
}

/// Numbers the entries that are true, from `first` on.
fn number(alone: &[bool], first: &mut u32) -> Vec<u32> {
    let numbers = alone.iter().map(|alone| match alone {
        true => {
            *first += 1;
            *first - 1
        }
        false => NONE,
    });
    numbers.collect()
}

impl Choice {
    /// Chooses the rays for a frame, which must be a whole picture. The result does not depend
    /// on threads.
    ///
    /// Cost: a few comparisons of neighbours for each pixel.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if there are not as many rays and hits as pixels.
    pub fn new(cpu: &Cpu, inputs: &FrameInputs<'_>, reduction: Reduction) -> Result<Self, Error> {
        let grid = Grid::new(inputs.size.map(|side| side.max(1)), reduction);
        for (what, actual) in [
            ("the rays of a picture", inputs.rays.len()),
            ("what the rays of a picture end on", inputs.hits.len()),
        ] {
            if actual != grid.pixels() {
                return Err(Error::LengthMismatch {
                    what,
                    expected: grid.pixels(),
                    actual,
                });
            }
        }
        let matters = grid.filter == Filter::Bilateral;
        let planes = planes(cpu, inputs);
        let seen = Seen {
            rays: inputs.rays,
            planes: &planes,
            matters,
        };
        // A picture has no more pixels than a u32 counts.
        let mut pixels: Vec<u32> = grid.gathered().map(|pixel| pixel as u32).collect();
        let mut next = pixels.len() as u32;
        let (mut of_samples, mut of_pixels) = (Vec::new(), Vec::new());
        if grid.window > 1 || grid.block == 1 {
            let columns = grid.samples[0] as usize;
            let alone = cpu.map(grid.sample_count(), |sample| {
                let place = [sample % columns, sample / columns].map(|i| i as u32);
                !grid.sees_all_subsets(&seen, place)
            });
            of_samples = number(&alone, &mut next);
            let own = (0..).zip(&alone).filter(|(_, alone)| **alone);
            let own = own.map(|(sample, _): (u32, _)| {
                grid.pixel([sample % grid.samples[0], sample / grid.samples[0]]) as u32
            });
            pixels.extend(own);
        }
        if grid.block > 1 {
            let columns = grid.size[0] as usize;
            let alone = cpu.map(grid.pixels(), |pixel| {
                let place = [pixel % columns, pixel / columns].map(|i| i as u32);
                !grid.has_sample_like(&seen, place)
            });
            of_pixels = number(&alone, &mut next);
            let own = (0..).zip(&alone).filter(|(_, alone)| **alone);
            pixels.extend(own.map(|(pixel, _): (u32, _)| pixel));
        }
        let alone = pixels.len() - grid.gathered_count();
        Ok(Self {
            rays: pixels.iter().map(|i| inputs.rays[*i as usize]).collect(),
            hits: pixels.iter().map(|i| inputs.hits[*i as usize]).collect(),
            grid,
            planes,
            pixels,
            of_samples,
            of_pixels,
            alone,
        })
    }

    /// The rays that are gathered.
    pub fn rays(&self) -> &[Ray] {
        &self.rays
    }

    /// Which pixels they are, and how they share the work.
    pub fn selection(&self) -> Selection<'_> {
        let window = self.grid.window;
        Selection {
            pixels: Some(&self.pixels),
            interleaving: Interleaving::new(window * window, self.grid.window_count()),
        }
    }

    /// The frame with these rays, made from that of the whole picture.
    pub fn inputs<'a>(&'a self, whole: &FrameInputs<'a>) -> FrameInputs<'a> {
        FrameInputs {
            rays: &self.rays,
            hits: &self.hits,
            selection: self.selection(),
            ..*whole
        }
    }

    /// The share of the picture's pixels that are gathered in full because no sample resembles
    /// them.
    pub fn in_full(&self) -> f64 {
        self.alone as f64 / self.grid.pixels() as f64
    }
}

impl Grid {
    pub(super) fn gathered_count(&self) -> usize {
        (self.window * self.window) as usize * self.window_count() as usize
    }

    /// Calls `tap(sample, weight)` for the samples around a pixel.
    pub(super) fn for_each_between(&self, [x, y]: [u32; 2], mut tap: impl FnMut([u32; 2], f32)) {
        let (column, across) = self.between(x, 0);
        let (row, down) = self.between(y, 1);
        let near = |sample: u32, tap: usize, side: usize| {
            (sample + tap as u32)
                .saturating_sub(1)
                .min(self.samples[side] - 1)
        };
        // Without the Gaussian, the outer taps have no weight.
        let taps = match self.filter {
            Filter::Bilateral => 1..3,
            Filter::Gaussian => 0..4,
        };
        for j in taps.clone() {
            for i in taps.clone() {
                let weight = across[i] * down[j];
                if weight > 0.0 {
                    tap([near(column, i, 0), near(row, j, 1)], weight);
                }
            }
        }
    }

    /// Calls `tap(sample, weight)` for the samples of a subset around a sample.
    pub(super) fn for_each_beside(
        &self,
        [x, y]: [u32; 2],
        [a, b]: [u32; 2],
        mut tap: impl FnMut([u32; 2], f32),
    ) {
        for (dy, v) in self.beside(y, b) {
            for (dx, u) in self.beside(x, a) {
                let place = [x.checked_add_signed(dx), y.checked_add_signed(dy)];
                let [Some(x), Some(y)] = place else {
                    continue;
                };
                if u * v > 0.0 && x < self.samples[0] && y < self.samples[1] {
                    tap([x, y], u * v);
                }
            }
        }
    }

    fn has_sample_like(&self, seen: &Seen<'_>, [x, y]: [u32; 2]) -> bool {
        let pixel = y as usize * self.size[0] as usize + x as usize;
        let mut sum = 0.0;
        self.for_each_between([x, y], |sample, weight| {
            // Once the sum is large enough, no further sample is compared.
            if sum < self.least_between() {
                sum += weight * seen.resemblance(pixel, self.pixel(sample));
            }
        });
        sum >= self.least_between()
    }

    fn sees_all_subsets(&self, seen: &Seen<'_>, place: [u32; 2]) -> bool {
        let pixel = self.pixel(place);
        (0..self.window * self.window).all(|subset| {
            let subset = [subset % self.window, subset / self.window];
            let mut sum = 0.0;
            self.for_each_beside(place, subset, |sample, weight| {
                if sum < self.least_beside() {
                    sum += weight * seen.resemblance(pixel, self.pixel(sample));
                }
            });
            sum >= self.least_beside()
        })
    }
}

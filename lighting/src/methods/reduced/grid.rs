//! The grid of sampled pixels, and the weights of samples by their place.

use std::fmt;

/// How much the work for a picture is reduced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Reduction {
    block: u32,
    window: u32,
    filter: Filter,
}

/// What fills the pixels between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Filter {
    /// From the samples that resemble a pixel; the pixel is gathered in full if none does.
    #[default]
    Bilateral,
    /// From all samples, whatever they see, after a 3 × 3 Gaussian. This is the baseline for
    /// [`Filter::Bilateral`].
    Gaussian,
}

/// The sides of blocks or windows are out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{what} of {side} x {side} pixels were asked for, expected 1 to {MOST} per side")]
pub struct ReductionError {
    what: &'static str,
    side: u32,
}

/// The largest side of blocks and windows.
const MOST: u32 = 8;

impl Reduction {
    /// Nothing is left out.
    pub const NONE: Self = Self {
        block: 1,
        window: 1,
        filter: Filter::Bilateral,
    };

    /// A quarter of the pixels: a sample for every 2 × 2.
    pub const QUARTER: Self = Self {
        block: 2,
        ..Self::NONE
    };

    /// A sixteenth of the pixels: a sample for every 4 × 4.
    pub const SIXTEENTH: Self = Self {
        block: 4,
        ..Self::NONE
    };

    /// A quarter of the work at every pixel: windows of 2 × 2.
    pub const WINDOWS_OF_2: Self = Self {
        window: 2,
        ..Self::NONE
    };

    /// A ninth of the work at every pixel: windows of 3 × 3.
    pub const WINDOWS_OF_3: Self = Self {
        window: 3,
        ..Self::NONE
    };

    /// One sample for every `block` × `block` pixels, each of which takes one part in `window`
    /// × `window` of the work. 1 reduces nothing.
    ///
    /// # Errors
    /// [`ReductionError`] for 0 and for numbers above 8.
    pub fn new(block: u32, window: u32) -> Result<Self, ReductionError> {
        for (what, side) in [("blocks", block), ("windows", window)] {
            if !(1..=MOST).contains(&side) {
                return Err(ReductionError { what, side });
            }
        }
        Ok(Self {
            block,
            window,
            filter: Filter::Bilateral,
        })
    }

    /// The same windows with a quarter of the pixels.
    #[must_use]
    pub const fn and_a_quarter(self) -> Self {
        Self { block: 2, ..self }
    }

    /// The same reduction with another filter.
    #[must_use]
    pub fn with_filter(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }

    /// Pixels along each side of the blocks that share a sample.
    pub fn block(self) -> u32 {
        self.block
    }

    /// Samples along each side of the windows that share the work.
    pub fn window(self) -> u32 {
        self.window
    }

    /// What fills the pixels between samples.
    pub fn filter(self) -> Filter {
        self.filter
    }

    /// Splits a name into the name of a method and the reduction in which it ends, as
    /// [`Display`](fmt::Display) writes it: `hybrid x gauss-8 3x3 quarter` is a `3x3 quarter`
    /// of `hybrid x gauss-8`. A name that does not end in a reduction is returned whole, with
    /// [`Reduction::NONE`].
    pub fn of_name(name: &str) -> (&str, Self) {
        let (mut rest, mut reduction) = (name.trim_end(), Self::NONE);
        // Words are read from the end: the filter, then blocks, then windows.
        let last = |rest: &mut &str| -> Option<String> {
            let (before, word) = rest.rsplit_once(' ')?;
            let word = word.to_owned();
            *rest = before.trim_end();
            Some(word)
        };
        let mut shorter = rest;
        if last(&mut shorter).as_deref() == Some("gaussian") {
            (rest, reduction.filter) = (shorter, Filter::Gaussian);
        }
        shorter = rest;
        if let Some(block) = last(&mut shorter).and_then(|word| side_of(&word, blocks)) {
            (rest, reduction.block) = (shorter, block);
        }
        shorter = rest;
        if let Some(window) = last(&mut shorter).and_then(|word| side_of(&word, windows)) {
            (rest, reduction.window) = (shorter, window);
        }
        match reduction.is_none() {
            true => (name, Self::NONE),
            false => (rest, reduction),
        }
    }

    /// Whether nothing is reduced.
    pub fn is_none(self) -> bool {
        self.block == 1 && self.window == 1
    }

    /// The share of the work of a whole picture that remains, without the additional rays at
    /// edges.
    pub fn share(self) -> f64 {
        let side = f64::from(self.block * self.window);
        1.0 / (side * side)
    }
}

/// The end of a reduced method's name: `3x3 quarter`, `sixteenth gaussian`; nothing for
/// [`Reduction::NONE`].
impl fmt::Display for Reduction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let window = match self.window {
            1 => String::new(),
            n => format!("{n}x{n}"),
        };
        let block = match self.block {
            1 => String::new(),
            2 => "quarter".into(),
            4 => "sixteenth".into(),
            n => format!("1/{}", n * n),
        };
        let filter = match self.filter {
            Filter::Gaussian if !self.is_none() => "gaussian",
            _ => "",
        };
        let words = [window.as_str(), &block, filter];
        let words: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
        f.write_str(&words.join(" "))
    }
}

/// The side for which `of` makes a reduction with this name.
fn side_of(word: &str, of: fn(u32) -> Reduction) -> Option<u32> {
    (2..=MOST).find(|side| of(*side).to_string() == word)
}

/// Blocks alone.
fn blocks(block: u32) -> Reduction {
    Reduction {
        block,
        ..Reduction::NONE
    }
}

/// Windows alone.
fn windows(window: u32) -> Reduction {
    Reduction {
        window,
        ..Reduction::NONE
    }
}

/// The samples of a picture: the pixels of every `block`-th row and column, and those
/// of the last row and column. Windows lie over the samples.
///
/// `Grid` of `reduced.wgsl`, but for `filter`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Grid {
    /// Of the picture, pixels.
    pub(super) size: [u32; 2],
    /// Columns and rows of samples.
    pub(super) samples: [u32; 2],
    /// Columns and rows of windows.
    pub(super) windows: [u32; 2],
    pub(super) block: u32,
    pub(super) window: u32,
    pub(super) filter: Filter,
}

impl Grid {
    /// Of a picture of at least 1 × 1 pixels.
    pub(super) fn new(size: [u32; 2], reduction: Reduction) -> Self {
        let Reduction {
            block,
            window,
            filter,
        } = reduction;
        let samples = size.map(|side| side.saturating_sub(1).div_ceil(block) + 1);
        Self {
            size,
            samples,
            windows: samples.map(|side| side.div_ceil(window)),
            block,
            window,
            filter,
        }
    }

    pub(super) fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    pub(super) fn sample_count(&self) -> usize {
        self.samples[0] as usize * self.samples[1] as usize
    }

    /// The number of windows, which is that of the samples of a subset; those that lie
    /// beyond the picture are doubles of the last.
    pub(super) fn window_count(&self) -> u32 {
        self.windows[0] * self.windows[1]
    }

    /// The pixel of a sample.
    pub(super) fn pixel(&self, [x, y]: [u32; 2]) -> usize {
        let [x, y] = [x, y].map(|place| place * self.block);
        let x = x.min(self.size[0] - 1) as usize;
        let y = y.min(self.size[1] - 1) as usize;
        y * self.size[0] as usize + x
    }

    /// The number of a sample among all that are gathered: subset by subset, each by
    /// rows of windows.
    pub(super) fn slot(&self, [x, y]: [u32; 2]) -> usize {
        let n = self.window;
        let subset = (y % n) * n + x % n;
        let window = (y / n) * self.windows[0] + x / n;
        (subset * self.window_count() + window) as usize
    }

    /// The pixels that are gathered, by their number.
    pub(super) fn gathered(&self) -> impl Iterator<Item = usize> {
        let (n, [columns, rows]) = (self.window, self.windows);
        let last = self.samples.map(|side| side - 1);
        (0..n * n).flat_map(move |subset| {
            let offset = [subset % n, subset / n];
            (0..rows).flat_map(move |row| {
                (0..columns).map(move |column| {
                    let x = (column * n + offset[0]).min(last[0]);
                    let y = (row * n + offset[1]).min(last[1]);
                    self.pixel([x, y])
                })
            })
        })
    }

    /// The sample before a pixel along a side, and the weights of four samples from
    /// the one before it on.
    pub(super) fn between(&self, place: u32, side: usize) -> (u32, [f32; 4]) {
        let sample = place / self.block;
        let start = sample * self.block;
        let width = (start + self.block).min(self.size[side] - 1) - start;
        let f = match width {
            0 => 0.0,
            width => (place - start) as f32 / width as f32,
        };
        let weights = match self.filter {
            Filter::Bilateral => [0.0, 1.0 - f, f, 0.0],
            // 1 2 1 over 4, shared between the two samples.
            Filter::Gaussian => [0.25 * (1.0 - f), 0.5 - 0.25 * f, 0.25 + 0.25 * f, 0.25 * f],
        };
        (sample, weights)
    }

    /// The offsets of the one or two samples of a subset that are within a window's
    /// width of a sample at `place` along a side, and their weights: the square of the
    /// share of the width that is left.
    pub(super) fn beside(&self, place: u32, subset: u32) -> [(i32, f32); 2] {
        let n = self.window as i32;
        let after = (subset as i32 - place as i32).rem_euclid(n);
        [after, after - n].map(|offset| {
            let left = (n - offset.abs()) as f32 / n as f32;
            (offset, left * left)
        })
    }

    /// The least sum of weights of samples that resemble a pixel between four of them:
    /// a quarter of what the one furthest away has by its place.
    pub(super) fn least_between(&self) -> f32 {
        0.25 / (self.block * self.block) as f32
    }

    /// The same for the samples of a subset.
    pub(super) fn least_beside(&self) -> f32 {
        let side = (self.window * self.window) as f32;
        0.25 / (side * side)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZES: [[u32; 2]; 6] = [[1, 1], [2, 1], [5, 7], [8, 4], [9, 9], [17, 3]];

    #[test]
    fn a_reduction_is_found_in_the_name_that_it_gives() {
        for filter in [Filter::Bilateral, Filter::Gaussian] {
            for block in 1..=MOST {
                for window in 1..=MOST {
                    let reduction = Reduction::new(block, window).unwrap().with_filter(filter);
                    let name = format!("a x b-8 {reduction}");
                    let expected = match reduction.is_none() {
                        true => (name.as_str(), Reduction::NONE),
                        false => ("a x b-8", reduction),
                    };
                    assert_eq!(Reduction::of_name(&name), expected);
                }
            }
        }
        for name in [
            "",
            "quarter",
            "gaussian",
            "a gaussian",
            "a 9x9",
            "a 2x3",
            "a 1/1",
            "a  b",
        ] {
            assert_eq!(Reduction::of_name(name), (name, Reduction::NONE));
        }
    }

    fn grids() -> impl Iterator<Item = Grid> {
        SIZES.into_iter().flat_map(|size| {
            (1..=4).flat_map(move |block| {
                (1..=4).map(move |window| Grid::new(size, Reduction::new(block, window).unwrap()))
            })
        })
    }

    #[test]
    fn samples_have_slots_of_their_own_and_reach_the_border() {
        for grid in grids() {
            let gathered: Vec<usize> = grid.gathered().collect();
            let side = grid.window * grid.window;
            assert_eq!(gathered.len(), (side * grid.window_count()) as usize);
            let mut slots = Vec::new();
            for y in 0..grid.samples[1] {
                for x in 0..grid.samples[0] {
                    let slot = grid.slot([x, y]);
                    assert_eq!(gathered[slot], grid.pixel([x, y]));
                    slots.push(slot);
                }
            }
            slots.sort_unstable();
            slots.dedup();
            assert_eq!(slots.len(), grid.sample_count());
            let last = [grid.samples[0] - 1, grid.samples[1] - 1];
            assert_eq!(grid.pixel(last), grid.pixels() - 1);
        }
    }

    /// Bilateral weights are those of linear interpolation, Gaussian ones those of the
    /// smoothed samples; both add up to one.
    #[test]
    fn weights_between_samples_reproduce_places() {
        for grid in grids() {
            for filter in [Filter::Bilateral, Filter::Gaussian] {
                let grid = Grid { filter, ..grid };
                for place in 0..grid.size[0] {
                    let (sample, weights) = grid.between(place, 0);
                    assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
                    if filter == Filter::Bilateral {
                        let at = |i: u32| (i * grid.block).min(grid.size[0] - 1) as f32;
                        let mean = weights[1] * at(sample) + weights[2] * at(sample + 1);
                        assert!((mean - place as f32).abs() < 1e-5, "{grid:?} {place}");
                        assert!(weights[2] == 0.0 || sample + 1 < grid.samples[0]);
                    }
                }
            }
        }
    }

    #[test]
    fn every_subset_is_beside_every_sample_and_no_weight_is_below_the_least() {
        for window in 1..=8 {
            let grid = Grid::new([40, 40], Reduction::new(1, window).unwrap());
            for place in 0..9 {
                for subset in 0..window {
                    let beside = grid.beside(place, subset);
                    for (offset, weight) in beside {
                        let sample = place as i32 + offset;
                        assert_eq!(sample.rem_euclid(window as i32), subset as i32);
                        assert!(offset.unsigned_abs() <= window);
                        let is_far = offset.unsigned_abs() == window;
                        assert_eq!(weight == 0.0, is_far, "{window} {offset}");
                        assert!(is_far || weight * weight >= grid.least_beside());
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_no_reduction_is_an_error() {
        for (block, window) in [(0, 1), (1, 0), (9, 1), (1, 9)] {
            let error = Reduction::new(block, window).unwrap_err().to_string();
            assert!(error.contains("1 to 8"), "{error}");
        }
        assert!(Reduction::new(1, 1).unwrap().is_none());
        assert_eq!(Reduction::new(2, 3).unwrap().share(), 1.0 / 36.0);
    }
}

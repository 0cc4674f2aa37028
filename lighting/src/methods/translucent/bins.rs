//! Sorts blockers by the parts of a map that they may touch.

use std::ops::Range;

use transmittance::Tile;

use super::view::Texels;

/// Texels along each side of the smallest bins.
const SIDE: usize = 16;

/// A blocker goes into the smallest bins of which it touches no more than this, which keeps
/// memory proportional to the number of blockers. Anything touches at most four bins that are
/// no smaller than itself.
const MOST_BINS: usize = 4;

/// The indices of the blockers that may touch each square of texels: squares of [`SIDE`]
/// texels, and on each further level of twice as many, up to one that contains everything.
#[derive(Debug)]
pub(crate) struct Bins {
    levels: Vec<Level>,
    /// The start of each bin's indices, and the end of the last bin.
    starts: Vec<usize>,
    numbers: Vec<u32>,
}

/// Bins of one size.
#[derive(Debug)]
struct Level {
    side: usize,
    per_side: usize,
    /// Index of its first bin.
    first: usize,
}

impl Bins {
    /// Sorts the blockers with indices below `count`; `texels` gives the texels that each may
    /// touch.
    pub(crate) fn new(
        resolution: u32,
        count: usize,
        texels: impl Fn(usize) -> Option<Texels>,
    ) -> Self {
        let (mut levels, mut side, mut first) = (Vec::new(), SIDE, 0);
        loop {
            let per_side = (resolution as usize).div_ceil(side).max(1);
            levels.push(Level {
                side,
                per_side,
                first,
            });
            first += per_side * per_side;
            if per_side == 1 {
                break;
            }
            side *= 2;
        }
        let mut starts = vec![0; first + 1];
        for blocker in 0..count {
            if let Some(texels) = texels(blocker) {
                for_each_bin(&levels, texels, |bin| starts[bin + 1] += 1);
            }
        }
        for bin in 0..first {
            starts[bin + 1] += starts[bin];
        }
        let mut numbers = vec![0; starts[first]];
        let mut next = starts.clone();
        for blocker in 0..count {
            if let Some(texels) = texels(blocker) {
                for_each_bin(&levels, texels, |bin| {
                    numbers[next[bin]] = blocker as u32;
                    next[bin] += 1;
                });
            }
        }
        Self {
            levels,
            starts,
            numbers,
        }
    }

    /// Indices of all blockers that may touch the tile, in rising order.
    pub(crate) fn of_tile(&self, tile: &Tile) -> Vec<u32> {
        let mut found = Vec::new();
        for level in &self.levels {
            level.for_each([&tile.x, &tile.y], |bin| {
                found.extend(&self.numbers[self.starts[bin]..self.starts[bin + 1]]);
            });
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

impl Level {
    /// The columns or rows of bins that contain these texels.
    fn along(&self, texels: &Range<usize>) -> Range<usize> {
        texels.start / self.side..texels.end.div_ceil(self.side).min(self.per_side)
    }

    /// Calls `bin` with the number of each bin that holds some of the texels.
    fn for_each(&self, [x, y]: [&Range<usize>; 2], mut bin: impl FnMut(usize)) {
        for row in self.along(y) {
            for column in self.along(x) {
                bin(self.first + row * self.per_side + column);
            }
        }
    }
}

/// Calls `bin` with the index of each bin that a blocker belongs to.
fn for_each_bin(levels: &[Level], texels: Texels, bin: impl FnMut(usize)) {
    let [x, y] = [texels.x, texels.y].map(|[first, end]| first as usize..end as usize);
    let fits = |level: &&Level| level.along(&x).len() * level.along(&y).len() <= MOST_BINS;
    // The last level, with one bin, contains everything.
    if let Some(level) = levels.iter().find(fits) {
        level.for_each([&x, &y], bin);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_is_told_of_all_that_touches_it_in_order() {
        let boxes = [
            Some([[0, 40], [0, 1]]),
            None,
            Some([[0, 300], [0, 300]]),
            Some([[33, 34], [17, 18]]),
            Some([[30, 34], [14, 18]]),
        ];
        let texels = |blocker: usize| boxes[blocker].map(|[x, y]| Texels { x, y });
        let bins = Bins::new(300, 5, texels);
        let at = |x: Range<usize>, y: Range<usize>| bins.of_tile(&Tile { x, y });
        assert_eq!(at(32..48, 16..32), [2, 3, 4]);
        assert_eq!(at(16..48, 0..32), [0, 2, 3, 4]);
        assert_eq!(at(288..300, 288..300), [2]);
        assert_eq!(at(0..4000, 0..16), [0, 2, 4]);
    }

    #[test]
    fn nothing_is_in_more_than_four_bins_and_long_things_are_not_everywhere() {
        let boxes: Vec<Texels> = (0..2000_u32)
            .map(|i| {
                let (x, y) = (i * 37 % 900, i * 61 % 900);
                Texels {
                    x: [x, x + 1 + i % 124],
                    y: [y, y + 1 + i * 7 % 124],
                }
            })
            .collect();
        let bins = Bins::new(1024, boxes.len(), |blocker| Some(boxes[blocker]));
        assert!(bins.numbers.len() <= 4 * boxes.len());
        let mut asked = 0;
        for (column, row) in (0..64).flat_map(|row| (0..64).map(move |column| (column, row))) {
            let [x, y] = [column, row].map(|at| 16 * at..16 * at + 16);
            let found = bins.of_tile(&Tile {
                x: x.clone(),
                y: y.clone(),
            });
            asked += found.len();
            for (number, it) in boxes.iter().enumerate() {
                let meets = |[first, end]: [u32; 2], tile: &Range<usize>| {
                    (first as usize) < tile.end && tile.start < end as usize
                };
                if meets(it.x, &x) && meets(it.y, &y) {
                    assert!(found.binary_search(&(number as u32)).is_ok());
                }
            }
        }
        // Bins are up to four times as long as what is in them.
        let all = 64 * 64 * boxes.len();
        assert!(asked < all / 10, "{asked} of {all}");
    }
}

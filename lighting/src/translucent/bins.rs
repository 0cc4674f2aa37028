//! Which blockers may touch which part of a map.

use std::ops::Range;

use transmittance::Tile;

use super::view::Texels;

/// Texels along each side of a bin.
const SIDE: usize = 16;

/// Blockers that touch more bins than this are looked at for every tile, so
/// that memory stays in proportion to their number.
const MOST_BINS: usize = 64;

/// The numbers of the blockers that may touch each square of texels.
#[derive(Debug)]
pub(super) struct Bins {
    per_side: usize,
    /// Where the numbers of each bin start; and the end of the last.
    starts: Vec<usize>,
    numbers: Vec<u32>,
    /// Those that are not in the bins.
    large: Vec<u32>,
}

impl Bins {
    /// Sorts the blockers 0 to before `count`; `texels` tells what each touches.
    pub(super) fn new(
        resolution: u32,
        count: usize,
        texels: impl Fn(usize) -> Option<Texels>,
    ) -> Self {
        let per_side = (resolution as usize).div_ceil(SIDE);
        let mut starts = vec![0; per_side * per_side + 1];
        let mut large = Vec::new();
        for blocker in 0..count {
            let Some(texels) = texels(blocker) else {
                continue;
            };
            match bins(texels) {
                Some(bins) => for_each_bin(bins, per_side, |bin| starts[bin + 1] += 1),
                None => large.push(blocker as u32),
            }
        }
        for bin in 0..per_side * per_side {
            starts[bin + 1] += starts[bin];
        }
        let mut numbers = vec![0; starts[per_side * per_side]];
        let mut next = starts.clone();
        for blocker in 0..count {
            if let Some(bins) = texels(blocker).and_then(bins) {
                for_each_bin(bins, per_side, |bin| {
                    numbers[next[bin]] = blocker as u32;
                    next[bin] += 1;
                });
            }
        }
        Self {
            per_side,
            starts,
            numbers,
            large,
        }
    }

    /// The numbers of all blockers that may touch the tile, in rising order.
    pub(super) fn of_tile(&self, tile: &Tile) -> Vec<u32> {
        let mut found = self.large.clone();
        let bins =
            |range: &Range<usize>| range.start / SIDE..range.end.div_ceil(SIDE).min(self.per_side);
        for row in bins(&tile.y) {
            for column in bins(&tile.x) {
                let bin = row * self.per_side + column;
                found.extend(&self.numbers[self.starts[bin]..self.starts[bin + 1]]);
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// Columns and rows of the bins that hold these texels, `None` if they are many.
fn bins(texels: Texels) -> Option<[Range<usize>; 2]> {
    let along = |[first, end]: [u32; 2]| first as usize / SIDE..(end as usize).div_ceil(SIDE);
    let bins = [along(texels.x), along(texels.y)];
    (bins[0].len() * bins[1].len() <= MOST_BINS).then_some(bins)
}

fn for_each_bin([columns, rows]: [Range<usize>; 2], per_side: usize, mut bin: impl FnMut(usize)) {
    for row in rows {
        for column in columns.clone() {
            bin(row * per_side + column);
        }
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
}

//! The cells of a grid in which there is anything, so that walks can leave out the others.

use glam::DVec3;

use super::grid::Interpolation;

/// A bit for each cell of a grid: whether one of the samples at its corners counts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Occupancy {
    cells: [u32; 3],
    bits: Vec<u32>,
    /// The occupied cells are at least at the first and below the second of these along each
    /// axis.
    range: [[u32; 3]; 2],
}

impl Occupancy {
    /// `counts` tells whether there is anything at a sample of that index.
    pub(super) fn new(
        [cells, samples]: [[u32; 3]; 2],
        interpolation: Interpolation,
        counts: impl Fn(usize) -> bool,
    ) -> Self {
        let all = cells.iter().map(|&count| u64::from(count)).product::<u64>();
        let mut occupancy = Self {
            cells,
            bits: vec![0; all.div_ceil(u32::BITS.into()) as usize],
            range: [cells, [0; 3]],
        };
        // Between samples a sample counts for the cells on both sides of it.
        let before = match interpolation {
            Interpolation::Constant => 0,
            Interpolation::Linear => 1,
        };
        let mut index = 0;
        for z in 0..samples[2] {
            for y in 0..samples[1] {
                for x in 0..samples[0] {
                    if counts(index) {
                        occupancy.occupy([x, y, z], before);
                    }
                    index += 1;
                }
            }
        }
        occupancy
    }

    /// Occupies the cells at a sample, and `before` it.
    fn occupy(&mut self, sample: [u32; 3], before: u32) {
        let first = sample.map(|at| at.saturating_sub(before));
        let last = [0, 1, 2].map(|axis| sample[axis].min(self.cells[axis] - 1));
        for axis in 0..3 {
            self.range[0][axis] = self.range[0][axis].min(first[axis]);
            self.range[1][axis] = self.range[1][axis].max(last[axis] + 1);
        }
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let (word, bit) = self.place([x, y, z]);
                    self.bits[word] |= bit;
                }
            }
        }
    }

    /// The word and the bit of a cell.
    fn place(&self, [x, y, z]: [u32; 3]) -> (usize, u32) {
        // A grid has at most 2²⁸ cells.
        let index = (z * self.cells[1] + y) * self.cells[0] + x;
        ((index / u32::BITS) as usize, 1 << (index % u32::BITS))
    }

    pub(super) fn is_occupied(&self, cell: [u32; 3]) -> bool {
        let (word, bit) = self.place(cell);
        self.bits[word] & bit != 0
    }

    pub(super) fn words(&self) -> &[u32] {
        &self.bits
    }

    /// The part of a line that may be in occupied cells; it ends within empty cells or outside,
    /// so that no occupied cell is cut.
    pub(super) fn clip(&self, start: DVec3, direction: DVec3, part: [f64; 2]) -> [f64; 2] {
        let [mut from, mut to] = part;
        for axis in 0..3 {
            let (at, slope) = (start[axis], direction[axis]);
            let [low, high] = self.range.map(|cell| f64::from(cell[axis]));
            let (near, far) = (low - 0.5 - at, high + 0.5 - at);
            if slope != 0.0 {
                from = from.max((near / slope).min(far / slope));
                to = to.min((near / slope).max(far / slope));
            } else if near > 0.0 || far < 0.0 {
                to = f64::NEG_INFINITY;
            }
        }
        [from, to]
    }

    /// Along each axis, the first occupied cell and the one behind the last; `None` if no cell
    /// is occupied.
    pub(super) fn range(&self) -> Option<[[u32; 3]; 2]> {
        let [first, end] = self.range;
        (first[0] < end[0]).then_some(self.range)
    }
}

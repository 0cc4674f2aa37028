//! Which of the free voxels are lit.
//!
//! Based on: Kämpe, Sintorn and Assarsson, Fast, Memory-Efficient Construction
//! of Voxelized Shadows, I3D 2015, section 3.4; and the rule of 2014 that it
//! replaced.
//!
//! The section says that a mask serves until the closest exit of the cells that
//! are lit still, and that all is shadowed behind the farthest enter. Both hold
//! for the last mask of a tile, which may thus end at either. Here it ends at
//! the exit, like all others, while volumes as a whole are shadowed from the
//! farthest enter on. With maps of 4096² texels the sizes of 2014 are 1.51 and
//! 1.53 times those of 2015 for two cities and 1.73 times for a landscape; the
//! paper has 1.43 and 1.72. Ended at the enter, nodes take 7 to 10 % more, and
//! the ratios are 1.37, 1.43 and 1.58.

use crate::interval::Interval;

/// How voxels inside of solids, which may be either, are resolved.
///
/// All rules give the same answers for voxels outside of solids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rule {
    /// Sintorn et al. 2014: a volume that can be lit or shadowed throughout
    /// is; in all others free voxels are shadowed. For comparison.
    Sintorn2014,
    /// Kämpe et al. 2015: as before, but the 8×8 masks change as late and as
    /// seldom as possible. For comparison.
    Kampe2015,
    /// As seldom, and where there is a choice at the depth that is a multiple
    /// of the highest power of two: footprints of any size whose texels can
    /// share one depth do, 8×8 tiles use the fewest masks. Volumes that can be
    /// shadowed throughout are, unless the node in front of them is right for
    /// them too. Every texel then turns from lit to shadowed once.
    #[default]
    Aligned,
}

impl Rule {
    /// The number that stands for it in files.
    pub(crate) fn number(self) -> u32 {
        match self {
            Self::Sintorn2014 => 2014,
            Self::Kampe2015 => 2015 << 8 | 1,
            Self::Aligned => 1,
        }
    }

    /// The rule of such a number.
    pub(crate) fn of_number(number: u32) -> Option<Self> {
        let all = [Self::Sintorn2014, Self::Kampe2015, Self::Aligned];
        all.into_iter().find(|rule| rule.number() == number)
    }
}

/// The enter and exit slices of an 8×8 tile, texel `8 y + x`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tile {
    pub(crate) enter: [u32; 64],
    pub(crate) exit: [u32; 64],
}

impl Default for Tile {
    fn default() -> Self {
        Self {
            enter: [0; 64],
            exit: [0; 64],
        }
    }
}

/// From slice `start` on, `mask` holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Transition {
    pub(crate) start: u32,
    pub(crate) mask: u64,
}

impl Tile {
    /// The depths that suit all texels.
    pub(crate) fn meet(&self) -> Interval {
        Interval {
            enter: self.enter.iter().fold(0, |a, &b| a.max(b)),
            exit: self.exit.iter().fold(u32::MAX, |a, &b| a.min(b)),
        }
    }

    /// The masks of the tile, near to far, after the lit slices in front of
    /// the first. `side` is the number of slices; masks that would start
    /// there or behind are left out.
    pub(crate) fn transitions(&self, rule: Rule, side: u32, out: &mut Vec<Transition>) {
        out.clear();
        match rule {
            Rule::Sintorn2014 => self.enters(side, out),
            Rule::Kampe2015 => self.exits(side, out, |stretch| stretch.exit),
            Rule::Aligned => self.exits(side, out, |stretch| stretch.most_aligned(side)),
        }
    }

    /// Shadows each cell from its enter on, but none in front of the first exit of the tile:
    /// slices up to there can be lit throughout.
    fn enters(&self, side: u32, out: &mut Vec<Transition>) {
        let first_exit = self.meet().exit;
        let mut lit = Lit::new(self);
        while let Some(enter) = Lit::first(&lit.enter) {
            let start = enter.max(first_exit);
            if start >= side {
                return;
            }
            lit.shade(start);
            let mask = lit.cells;
            out.push(Transition { start, mask });
        }
    }

    /// Waits until a lit cell must be shadowed, at the smallest exit, and shadows all cells that
    /// have entered by then along with it: no other way has fewer masks. The mask may begin at
    /// any slice from the last of their enters to that exit; `choose` says at which.
    fn exits(&self, side: u32, out: &mut Vec<Transition>, choose: impl Fn(Interval) -> u32) {
        let mut lit = Lit::new(self);
        while let Some(exit) = Lit::first(&lit.exit) {
            let enter = lit.shade(exit);
            let mask = lit.cells;
            let start = choose(Interval { enter, exit });
            if start >= side {
                return;
            }
            out.push(Transition { start, mask });
        }
    }
}

/// Behind all slices.
const NEVER: i32 = i32::MAX;

/// Eight numbers that are compared at once.
type Row = [i32; 8];

/// The cells of a tile that are still lit. Depths are signed because not every processor
/// compares several unsigned numbers at once.
struct Lit {
    cells: u64,
    /// By upper and lower half, row by row; [`NEVER`] for cells that are
    /// shadowed.
    enter: [[Row; 4]; 2],
    exit: [[Row; 4]; 2],
}

/// The bits of the cells of half a tile.
const BITS: [Row; 4] = {
    let mut bits = [[0; 8]; 4];
    let mut cell = 0;
    while cell < 32 {
        bits[cell / 8][cell % 8] = (1_u32 << cell) as i32;
        cell += 1;
    }
    bits
};

impl Lit {
    /// All of them.
    fn new(tile: &Tile) -> Self {
        let rows = |depths: &[u32; 64]| {
            let cell = |i: usize| depths[i] as i32;
            [0, 32].map(|half| {
                [0, 8, 16, 24].map(|row| [0, 1, 2, 3, 4, 5, 6, 7].map(|x| cell(half + row + x)))
            })
        };
        Self {
            cells: u64::MAX,
            enter: rows(&tile.enter),
            exit: rows(&tile.exit),
        }
    }

    /// The smallest of these depths; none if all cells are shadowed.
    fn first(depths: &[[Row; 4]; 2]) -> Option<u32> {
        let all = depths.as_flattened().as_flattened();
        let least = all.iter().fold(NEVER, |a, &b| a.min(b));
        (least != NEVER).then_some(least as u32)
    }

    /// Shadows the lit cells that enter at `depth` or in front of it, and returns the largest
    /// of their enters.
    fn shade(&mut self, depth: u32) -> u32 {
        let mut last = [0; 8];
        let halves = self.enter.iter_mut().zip(&mut self.exit);
        let shaded = halves.map(|(enter, exit)| {
            let mut shaded = [0; 8];
            for ((enter, exit), bits) in enter.iter_mut().zip(exit).zip(&BITS) {
                for x in 0..8 {
                    // All ones for cells that have entered.
                    let inside = -i32::from(enter[x] <= depth as i32);
                    last[x] = last[x].max(enter[x] & inside);
                    enter[x] |= NEVER & inside;
                    exit[x] |= NEVER & inside;
                    shaded[x] |= bits[x] & inside;
                }
            }
            shaded.iter().fold(0, |a, b| a | b) as u32
        });
        let shaded = shaded.enumerate().fold(0, |cells, (half, bits)| {
            cells | u64::from(bits) << (32 * half)
        });
        self.cells &= !shaded;
        last.iter().fold(0, |a, &b: &i32| a.max(b)) as u32
    }
}

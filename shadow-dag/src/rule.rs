//! Which of the free voxels are lit.
//!
//! Based on: Kämpe, Sintorn and Assarsson, Fast, Memory-Efficient Construction
//! of Voxelized Shadows, I3D 2015, section 3.4; and the rule of 2014 that it
//! replaced.

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
    /// share one depth do, 8×8 tiles use the fewest masks. Every texel then
    /// turns from lit to shadowed once.
    #[default]
    Aligned,
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
            Rule::Kampe2015 => {
                let choose = |stretch: Interval, last| {
                    if last { stretch.enter } else { stretch.exit }
                };
                self.exits(side, out, choose);
            }
            Rule::Aligned => self.exits(side, out, |stretch, _| stretch.most_aligned(side)),
        }
    }

    /// A cell is shadowed from where it enters, behind the slices in front of
    /// the first exit: those can be lit throughout.
    fn enters(&self, side: u32, out: &mut Vec<Transition>) {
        let first_exit = self.meet().exit;
        let mut lit = u64::MAX;
        loop {
            let start = self.least(&self.enter, lit).max(first_exit);
            if lit == 0 || start >= side {
                return;
            }
            lit &= !self.entered(lit, start).0;
            out.push(Transition { start, mask: lit });
        }
    }

    /// At the smallest exit of what is lit everything that has entered is
    /// shadowed: the fewest masks that there can be. The first slice with
    /// that mask can be any from where the last of those cells enters;
    /// `choose` says which, and is told if all cells are shadowed by a
    /// transition that is not the only one.
    fn exits(&self, side: u32, out: &mut Vec<Transition>, choose: impl Fn(Interval, bool) -> u32) {
        let mut lit = u64::MAX;
        loop {
            let exit = self.least(&self.exit, lit);
            if lit == 0 {
                return;
            }
            let (shaded, enter) = self.entered(lit, exit);
            let last = shaded == lit && lit != u64::MAX;
            lit &= !shaded;
            let start = choose(Interval { enter, exit }, last);
            if start >= side {
                return;
            }
            out.push(Transition { start, mask: lit });
        }
    }

    fn least(&self, depths: &[u32; 64], cells: u64) -> u32 {
        (0..64).fold(u32::MAX, |least, i| {
            let depth = if cells >> i & 1 == 1 {
                depths[i]
            } else {
                u32::MAX
            };
            least.min(depth)
        })
    }

    /// The `cells` that enter at `depth` or in front of it, and where the
    /// last of them does.
    fn entered(&self, cells: u64, depth: u32) -> (u64, u32) {
        let mut mask = 0;
        let mut last = 0;
        for i in 0..64 {
            let inside = cells >> i & 1 == 1 && self.enter[i] <= depth;
            mask |= u64::from(inside) << i;
            last = last.max(if inside { self.enter[i] } else { 0 });
        }
        (mask, last)
    }
}

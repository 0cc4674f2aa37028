//! Tables over blocks of segments.
//!
//! A segment takes about 8 cycles with AVX-512 on ordinary lists, and 5 if it is the
//! step of a march. Arithmetic binds: two roots, two divisions and two exponentials
//! among a hundred operations. It reads 16 bytes, two cells of 16 bytes each, and
//! writes 4; that the cells of 64 KiB do not all fit into the first-level cache costs
//! a tenth.

use std::ops::Range;

use super::Table;
use super::cells;
use super::close::is_close;
use super::long::{End, Found, Lookup, known, settle};
use super::waiting::{FEW, GROUP, Waiting};
use crate::Segment;
use crate::simd::{Kernel, LANES, Lanes};

/// A table and an extinction: all that a batch has in common.
#[derive(Debug)]
pub(super) struct Batch<'a> {
    pub(super) table: &'a Table,
    pub(super) lookup: Lookup,
}

/// Values that pass between the loops of a block.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub(super) ends: [EndLanes; 2],
    pub(super) depth: Lanes<f32>,
    pub(super) growth: Lanes<f32>,
    known: Lanes<f32>,
    pub(super) cells: Lanes<[f32; 4]>,
    /// Number of segments that are close.
    close: u32,
    /// 1 for parts that are near, and their airlight.
    is_near: Lanes<u32>,
    nears: Nears,
    /// 1 for short parts that are not near, which wait for more of them.
    is_short: Lanes<u32>,
    waiting: Waiting,
}

/// The segments of a block, as an array for each of the four lengths. With an array of
/// segments, loops that do not read all four lengths would do their last rounds in scalar
/// instructions. It is kept apart from what loops write, so that the compiler sees that the
/// two do not overlap.
#[derive(Debug)]
pub(super) struct SegmentLanes([Lanes<f32>; 4]);

impl SegmentLanes {
    #[inline(always)]
    pub(super) fn of(segments: &[Segment; LANES]) -> Self {
        Self::by(|i| segments[i])
    }

    #[inline(always)]
    pub(super) fn by(segment: impl Fn(usize) -> Segment) -> Self {
        let mut lanes = [Lanes::default(); 4];
        for i in 0..LANES {
            let segment = segment(i);
            lanes[0].0[i] = segment.x;
            lanes[1].0[i] = segment.s;
            lanes[2].0[i] = segment.h;
            lanes[3].0[i] = segment.length;
        }
        Self(lanes)
    }

    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> Segment {
        let [x, s, h, length] = &self.0;
        Segment {
            x: x.0[i],
            s: s.0[i],
            h: h.0[i],
            length: length.0[i],
        }
    }
}

/// One end of each segment.
#[derive(Debug, Default)]
pub(super) struct EndLanes {
    cell: Lanes<u32>,
    alpha: Lanes<f32>,
    beta: Lanes<f32>,
    divisor: Lanes<f32>,
    /// The polynomial of the cell.
    value: Lanes<f32>,
}

impl EndLanes {
    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, end: &End) {
        self.cell.0[i] = end.place.cell;
        self.alpha.0[i] = end.place.alpha;
        self.beta.0[i] = end.place.beta;
        self.divisor.0[i] = end.divisor;
    }

    #[inline(always)]
    pub(super) fn look_up(&mut self, table: &Table, cells: &mut Lanes<[f32; 4]>) {
        // These are the only loads whose address depends on the segment. Each cell is one
        // vector of four words.
        for (cell, &index) in cells.0.iter_mut().zip(&self.cell.0) {
            *cell = table.cells[index as usize];
        }
        let units = table.units;
        for i in 0..LANES {
            let (alpha, beta) = (self.alpha.0[i], self.beta.0[i]);
            self.value.0[i] = cells::value(cells.0[i], units, alpha, beta);
        }
    }

    /// Sets each of these starts to the end of the segment before; `first` is the start of
    /// the first one.
    #[inline(always)]
    pub(super) fn follow(&mut self, ends: &Self, first: Found) {
        self.value.0[1..].copy_from_slice(&ends.value.0[..LANES - 1]);
        self.divisor.0[1..].copy_from_slice(&ends.divisor.0[..LANES - 1]);
        self.value.0[0] = first.value;
        self.divisor.0[0] = first.divisor;
    }

    #[inline(always)]
    fn get(&self, i: usize) -> Found {
        Found {
            value: self.value.0[i],
            divisor: self.divisor.0[i],
        }
    }
}

/// Values that pass between the loops over near parts.
#[derive(Debug, Default)]
struct Nears {
    row: Lanes<u32>,
    beta: Lanes<f32>,
    phase: Lanes<[f32; 4]>,
    sum: Lanes<f32>,
}

impl Nears {
    /// Integrates all parts of a block as if they were near: [`Nears::sum`] becomes
    /// the airlight of those that are.
    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "steps over several arrays at once, which zipped would be unreadable"
    )]
    fn integrate(&mut self, table: &Table, lookup: Lookup, segments: &SegmentLanes) {
        let node = |i: usize, t| {
            let Segment { x, s, h, length } = segments.get(i);
            lookup.node([x, s, h, length], t)
        };
        self.sum = Lanes::default();
        for &[t, weight] in &table.near_rule {
            if let Some(constant) = table.constant {
                for i in 0..LANES {
                    self.sum.0[i] += node(i, t).root_term(weight, 0.5 * constant);
                }
                continue;
            }
            for i in 0..LANES {
                let (row, beta) = lookup.node_row(&node(i, t));
                self.row.0[i] = row;
                self.beta.0[i] = beta;
            }
            for (phase, &row) in self.phase.0.iter_mut().zip(&self.row.0) {
                *phase = table.phase[row as usize];
            }
            for i in 0..LANES {
                let phase = cells::phase_value(self.phase.0[i], self.beta.0[i]);
                self.sum.0[i] += node(i, t).root_term(weight, 0.5 * phase);
            }
        }
    }
}

impl Batch<'_> {
    /// The airlight of parts that are near, and whether all of them are: nothing has
    /// to be looked up then.
    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "steps over a dozen arrays at once, which zipped would be unreadable"
    )]
    pub(super) fn begin(
        &self,
        scratch: &mut Scratch,
        lanes: &SegmentLanes,
        airlight: &mut [f32; LANES],
    ) -> bool {
        let lookup = self.lookup;
        let (mut near, mut close) = (0, 0);
        for i in 0..LANES {
            let segment = lanes.get(i);
            let is_close = is_close(&segment);
            let is_near = lookup.is_near(&segment) & !is_close;
            scratch.is_near.0[i] = u32::from(is_near);
            scratch.known.0[i] = known(&segment);
            near += u32::from(is_near);
            close += u32::from(is_close);
        }
        if near > 0 {
            scratch.nears.integrate(self.table, lookup, lanes);
        }
        if near == LANES as u32 {
            for i in 0..LANES {
                airlight[i] = settle(scratch.known.0[i], scratch.nears.sum.0[i]);
                scratch.is_short.0[i] = 0;
            }
            return true;
        }
        scratch.close = close;
        false
    }

    /// The airlight of a block whose ends have been looked up.
    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "steps over a dozen arrays at once, which zipped would be unreadable"
    )]
    pub(super) fn finish(
        &self,
        scratch: &mut Scratch,
        lanes: &SegmentLanes,
        airlight: &mut [f32; LANES],
    ) {
        let lookup = self.lookup;
        for i in 0..LANES {
            let found = [scratch.ends[0].get(i), scratch.ends[1].get(i)];
            let (value, is_short) =
                lookup.difference(found, scratch.depth.0[i], scratch.growth.0[i]);
            let is_near = scratch.is_near.0[i] != 0;
            let value = if is_near {
                scratch.nears.sum.0[i]
            } else {
                value
            };
            let known = scratch.known.0[i];
            airlight[i] = settle(known, value);
            scratch.is_short.0[i] = u32::from(is_short & !is_near & known.is_nan());
        }
        if scratch.close > 0 {
            for i in 0..LANES {
                let segment = lanes.get(i);
                if is_close(&segment) {
                    scratch.is_short.0[i] = 0;
                    airlight[i] = settle(known(&segment), self.table.close(&lookup, &segment));
                }
            }
        }
    }
}

impl Batch<'_> {
    /// Integrates the short parts of a block that no other follows.
    #[inline(always)]
    pub(super) fn integrate(
        &self,
        scratch: &mut Scratch,
        lanes: &SegmentLanes,
        airlight: &mut [f32; LANES],
    ) {
        let count = scratch.is_short.0.iter().sum::<u32>() as usize;
        if count >= FEW {
            let sums = scratch.waiting.integrate_block(self, lanes);
            let marks = scratch.is_short.0.iter().zip(&sums.0);
            for (airlight, (&is_short, &sum)) in airlight.iter_mut().zip(marks) {
                let value = settle(f32::NAN, sum);
                *airlight = if is_short != 0 { value } else { *airlight };
            }
        } else if count > 0 {
            for (i, airlight) in airlight.iter_mut().enumerate() {
                if scratch.is_short.0[i] != 0 {
                    let short = self.table.short(&self.lookup, &lanes.get(i));
                    *airlight = settle(f32::NAN, short);
                }
            }
        }
    }
}

impl Kernel for Batch<'_> {
    type Scratch = Scratch;

    #[inline(always)]
    fn block(
        &self,
        scratch: &mut Scratch,
        segments: &[Segment; LANES],
        airlight: &mut [f32; LANES],
    ) {
        let lanes = &SegmentLanes::of(segments);
        if self.begin(scratch, lanes, airlight) {
            return;
        }
        // A local copy, so that the compiler sees that the loops do not write it.
        let lookup = self.lookup;
        for i in 0..LANES {
            let ends = lookup.ends(&lanes.get(i));
            scratch.ends[0].set(i, &ends.start);
            scratch.ends[1].set(i, &ends.end);
            scratch.depth.0[i] = ends.depth;
            scratch.growth.0[i] = ends.growth;
        }
        for ends in &mut scratch.ends {
            ends.look_up(self.table, &mut scratch.cells);
        }
        self.finish(scratch, lanes, airlight);
    }

    #[inline(always)]
    fn behind(
        &self,
        scratch: &mut Scratch,
        segments: &[Segment],
        airlight: &mut [f32],
        done: Range<usize>,
    ) {
        let least = if done.is_empty() { 1 } else { GROUP };
        scratch.waiting.add(&scratch.is_short, done);
        scratch.waiting.integrate(self, least, segments, airlight);
    }
}

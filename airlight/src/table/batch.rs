//! Tables over blocks of segments.

use std::ops::Range;

use super::Table;
use super::cells;
use super::close::is_close;
use super::long::{End, Ends, Lookup, known, settle};
use super::short::Short;
use crate::Segment;
use crate::simd::{Kernel, LANES, Lanes};

/// A table and an extinction: all that a batch has in common.
#[derive(Debug)]
pub(super) struct Batch<'a> {
    pub(super) table: &'a Table,
    pub(super) lookup: Lookup,
}

/// What passes between the loops of a block.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    ends: [EndLanes; 2],
    depth: Lanes<f32>,
    growth: Lanes<f32>,
    known: Lanes<f32>,
    is_near: Lanes<u32>,
    cells: [Lanes<[f32; 4]>; 2],
    /// 1 for short parts that are near and for those that are not.
    is_short: [Lanes<u32>; 2],
    waiting: [Waiting; 2],
    shorts: Shorts,
}

/// Room for less than a group and all of a block, and a power of two.
const WAITING: usize = GROUP + LANES;

/// Where there are short parts that wait until they are enough for a group.
#[derive(Debug)]
struct Waiting {
    count: usize,
    index: [usize; WAITING],
}

impl Default for Waiting {
    fn default() -> Self {
        Self {
            count: 0,
            index: [0; WAITING],
        }
    }
}

impl Waiting {
    /// Adds those of a range that are marked by a 1.
    #[inline(always)]
    fn add(&mut self, marks: &Lanes<u32>, range: Range<usize>) {
        if marks.0.iter().sum::<u32>() == 0 {
            return;
        }
        for (index, &mark) in range.zip(&marks.0) {
            // Written in any case and overwritten if it is not marked: no
            // branch to mispredict.
            self.index[self.count % WAITING] = index;
            self.count += mark as usize;
        }
    }

    /// Integrates groups until there are fewer than `least`.
    #[inline(always)]
    fn integrate(
        &mut self,
        batch: &Batch<'_>,
        rule: &[[f32; 2]],
        shorts: &mut Shorts,
        least: usize,
        segments: &[Segment],
        airlight: &mut [f32],
    ) {
        while self.count >= least {
            let start = self.count.saturating_sub(GROUP);
            let group = &self.index[start..self.count];
            for (segment, &index) in shorts.segments.iter_mut().zip(group) {
                *segment = segments[index];
            }
            shorts.integrate(batch.table, rule, batch.lookup);
            for (&index, &value) in group.iter().zip(&shorts.sum.0) {
                airlight[index] = settle(f32::NAN, value);
            }
            self.count = start;
        }
    }
}

#[derive(Debug, Default)]
struct EndLanes {
    cell: Lanes<u32>,
    alpha: Lanes<f32>,
    beta: Lanes<f32>,
    scale: Lanes<f32>,
}

impl EndLanes {
    #[inline(always)]
    fn set(&mut self, i: usize, end: &End) {
        self.cell.0[i] = end.place.cell;
        self.alpha.0[i] = end.place.alpha;
        self.beta.0[i] = end.place.beta;
        self.scale.0[i] = end.scale;
    }

    #[inline(always)]
    fn get(&self, i: usize) -> End {
        End {
            place: super::axes::Place {
                cell: self.cell.0[i],
                alpha: self.alpha.0[i],
                beta: self.beta.0[i],
            },
            scale: self.scale.0[i],
        }
    }
}

/// Short parts that are integrated together.
const GROUP: usize = LANES;

/// One value for each of a group of short parts.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Group<T>([T; GROUP]);

impl<T: Copy + Default> Default for Group<T> {
    fn default() -> Self {
        Self([T::default(); GROUP])
    }
}

/// What passes between the loops of a group of short parts.
#[derive(Debug)]
struct Shorts {
    segments: [Segment; GROUP],
    depth: Group<f32>,
    growth: Group<f32>,
    kappa: Group<f32>,
    bend: Group<f32>,
    angle: Group<f32>,
    ends: [Group<f32>; 2],
    h: Group<f32>,
    row: Group<u32>,
    beta: Group<f32>,
    phase: Group<[f32; 4]>,
    sum: Group<f32>,
}

impl Default for Shorts {
    fn default() -> Self {
        Self {
            segments: [Segment::default(); GROUP],
            depth: Group::default(),
            growth: Group::default(),
            kappa: Group::default(),
            bend: Group::default(),
            angle: Group::default(),
            ends: [Group::default(); 2],
            h: Group::default(),
            row: Group::default(),
            beta: Group::default(),
            phase: Group::default(),
            sum: Group::default(),
        }
    }
}

impl Shorts {
    #[inline(always)]
    fn set(&mut self, i: usize, short: &Short) {
        self.depth.0[i] = short.depth;
        self.growth.0[i] = short.growth;
        self.kappa.0[i] = short.kappa;
        self.bend.0[i] = short.bend;
        self.angle.0[i] = short.angle;
    }

    /// What only phase functions that vary ask for: two divisions.
    #[inline(always)]
    fn set_ends(&mut self, i: usize, short: &Short) {
        self.ends[0].0[i] = short.ends[0];
        self.ends[1].0[i] = short.ends[1];
        self.h.0[i] = short.h;
    }

    #[inline(always)]
    fn get(&self, i: usize) -> Short {
        Short {
            depth: self.depth.0[i],
            growth: self.growth.0[i],
            kappa: self.kappa.0[i],
            bend: self.bend.0[i],
            angle: self.angle.0[i],
            ends: [self.ends[0].0[i], self.ends[1].0[i]],
            h: self.h.0[i],
        }
    }

    /// Integrates the group: [`Shorts::sum`] becomes the airlight.
    #[inline(always)]
    fn integrate(&mut self, table: &Table, rule: &[[f32; 2]], lookup: Lookup) {
        // A copy is known not to be written by the loops, which are vectors only
        // then.
        let segments = self.segments;
        if table.constant.is_some() {
            for (i, segment) in segments.iter().enumerate() {
                self.set(i, &Short::of(lookup.extinction, segment));
            }
        } else {
            for (i, segment) in segments.iter().enumerate() {
                let part = Short::of(lookup.extinction, segment);
                self.set(i, &part);
                self.set_ends(i, &part);
            }
        }
        self.sum = Group::default();
        for &[t, weight] in rule {
            if let Some(constant) = table.constant {
                for i in 0..GROUP {
                    self.sum.0[i] += self.get(i).node(t, weight).term(constant);
                }
                continue;
            }
            for i in 0..GROUP {
                let (row, beta) = lookup.phase_row(&self.get(i), t);
                self.row.0[i] = row;
                self.beta.0[i] = beta;
            }
            for (phase, &row) in self.phase.0.iter_mut().zip(&self.row.0) {
                *phase = table.phase[row as usize];
            }
            for i in 0..GROUP {
                let phase = cells::phase_value(self.phase.0[i], self.beta.0[i]);
                self.sum.0[i] += self.get(i).node(t, weight).term(phase);
            }
        }
        for i in 0..GROUP {
            self.sum.0[i] = self.get(i).airlight(self.sum.0[i]);
        }
    }
}

impl Kernel for Batch<'_> {
    type Scratch = Scratch;

    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "steps over a dozen arrays at once, which zipped would be unreadable"
    )]
    fn block(
        &self,
        scratch: &mut Scratch,
        segments: &[Segment; LANES],
        airlight: &mut [f32; LANES],
    ) {
        // A copy, so that it cannot be taken for something that the loops write.
        let lookup = self.lookup;
        // The steps of a march: nothing to look up. The first and the last
        // tell whether it is worth looking at all of them.
        let is_near = |segment| u32::from(lookup.is_near(segment) & !is_close(segment));
        if is_near(&segments[0]) + is_near(&segments[LANES - 1]) == 2
            && segments.iter().map(is_near).sum::<u32>() == LANES as u32
        {
            scratch.is_short = Default::default();
            scratch.shorts.segments = *segments;
            let rule = &self.table.near_rule;
            scratch.shorts.integrate(self.table, rule, lookup);
            for i in 0..LANES {
                airlight[i] = settle(known(&segments[i]), scratch.shorts.sum.0[i]);
            }
            return;
        }
        let mut close = 0;
        for i in 0..LANES {
            let ends = lookup.ends(&segments[i]);
            scratch.ends[0].set(i, &ends.start);
            scratch.ends[1].set(i, &ends.end);
            scratch.depth.0[i] = ends.depth;
            scratch.growth.0[i] = ends.growth;
            scratch.known.0[i] = ends.known;
            scratch.is_near.0[i] = u32::from(ends.is_near);
            close += u32::from(is_close(&segments[i]));
        }
        // The only loads whose address depends on the segment. A cell is a
        // vector of four words.
        for (ends, cells) in scratch.ends.iter().zip(&mut scratch.cells) {
            for (cell, &index) in cells.0.iter_mut().zip(&ends.cell.0) {
                *cell = self.table.cells[index as usize];
            }
        }
        for i in 0..LANES {
            let ends = Ends {
                start: scratch.ends[0].get(i),
                end: scratch.ends[1].get(i),
                depth: scratch.depth.0[i],
                growth: scratch.growth.0[i],
                known: scratch.known.0[i],
                is_near: scratch.is_near.0[i] != 0,
            };
            let cells = [scratch.cells[0].0[i], scratch.cells[1].0[i]];
            let (value, is_short) = lookup.difference(&ends, cells);
            airlight[i] = settle(ends.known, value);
            let is_short = is_short && ends.known.is_nan();
            scratch.is_short[0].0[i] = u32::from(is_short && ends.is_near);
            scratch.is_short[1].0[i] = u32::from(is_short && !ends.is_near);
        }
        if close > 0 {
            for i in 0..LANES {
                if is_close(&segments[i]) {
                    scratch.is_short[0].0[i] = 0;
                    scratch.is_short[1].0[i] = 0;
                    let value = self.table.close(&lookup, &segments[i]);
                    airlight[i] = settle(known(&segments[i]), value);
                }
            }
        }
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
        let rules = [&self.table.near_rule, &self.table.rule];
        for ((waiting, is_short), rule) in
            scratch.waiting.iter_mut().zip(&scratch.is_short).zip(rules)
        {
            waiting.add(is_short, done.clone());
            waiting.integrate(self, rule, &mut scratch.shorts, least, segments, airlight);
        }
    }
}

//! Short parts of a batch, which wait until there are enough of them for vectors.

use std::ops::Range;

use super::Table;
use super::batch::{Batch, SegmentLanes};
use super::cells;
use super::long::{Lookup, settle};
use super::short::Short;
use crate::Segment;
use crate::simd::{LANES, Lanes};

/// Room for the rest of a group and a whole block; a power of two.
const WAITING: usize = 2 * LANES;

/// Short parts that wait until there are enough of them for a group.
#[derive(Debug)]
pub(super) struct Waiting {
    count: usize,
    index: [usize; WAITING],
    shorts: Shorts,
}

impl Default for Waiting {
    fn default() -> Self {
        Self {
            count: 0,
            index: [0; WAITING],
            shorts: Shorts::default(),
        }
    }
}

impl Waiting {
    /// Adds the segments of a range that are marked with 1.
    #[inline(always)]
    pub(super) fn add(&mut self, marks: &Lanes<u32>, range: Range<usize>) {
        if marks.0.iter().sum::<u32>() == 0 {
            return;
        }
        for (index, &mark) in range.zip(&marks.0) {
            // Each index is written, and overwritten by the next one if it is not marked, so
            // that there is no branch to mispredict.
            self.index[self.count % WAITING] = index;
            self.count += mark as usize;
        }
    }

    /// The airlight of all parts of a block as if they were short.
    #[inline(always)]
    pub(super) fn integrate_block(
        &mut self,
        batch: &Batch<'_>,
        block: &SegmentLanes,
    ) -> Lanes<f32> {
        self.shorts.integrate(batch.table, batch.lookup, block);
        self.shorts.sum
    }

    /// Integrates groups until there are fewer than `least`.
    #[inline(always)]
    pub(super) fn integrate(
        &mut self,
        batch: &Batch<'_>,
        least: usize,
        segments: &[Segment],
        airlight: &mut [f32],
    ) {
        while self.count >= least {
            let start = self.count.saturating_sub(GROUP);
            let group = &self.index[start..self.count];
            self.count = start;
            if group.len() < FEW {
                for &index in group {
                    let value = batch.table.short(&batch.lookup, &segments[index]);
                    airlight[index] = settle(f32::NAN, value);
                }
                continue;
            }
            let mut short = [Segment::default(); GROUP];
            for (segment, &index) in short.iter_mut().zip(group) {
                *segment = segments[index];
            }
            let short = SegmentLanes::of(&short);
            self.shorts.integrate(batch.table, batch.lookup, &short);
            for (&index, &value) in group.iter().zip(&self.shorts.sum.0) {
                airlight[index] = settle(f32::NAN, value);
            }
        }
    }
}

/// Short parts that are integrated together.
pub(super) const GROUP: usize = LANES;

/// Fewer than this are faster one by one.
pub(super) const FEW: usize = 8;

/// Values that pass between the loops of a group of short parts.
#[derive(Debug, Default)]
struct Shorts {
    depth: Lanes<f32>,
    growth: Lanes<f32>,
    kappa: Lanes<f32>,
    bend: Lanes<f32>,
    angle: Lanes<f32>,
    ends: [Lanes<f32>; 2],
    h: Lanes<f32>,
    row: Lanes<u32>,
    beta: Lanes<f32>,
    phase: Lanes<[f32; 4]>,
    sum: Lanes<f32>,
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

    /// Sets the values that only phase functions that vary need, because they take two divisions.
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
    fn integrate(&mut self, table: &Table, lookup: Lookup, segments: &SegmentLanes) {
        if table.constant.is_some() {
            for i in 0..GROUP {
                self.set(i, &Short::of(lookup.extinction, &segments.get(i)));
            }
        } else {
            for i in 0..GROUP {
                let part = Short::of(lookup.extinction, &segments.get(i));
                self.set(i, &part);
                self.set_ends(i, &part);
            }
        }
        self.sum = Lanes::default();
        for &[t, weight] in &table.rule {
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

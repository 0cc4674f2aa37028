//! The steps of a march: neighbours share an end, so that each step takes one
//! lookup.

use std::cell::RefCell;

use pulp::{Simd, WithSimd};

use super::Table;
use super::batch::{Batch, Scratch, SegmentLanes};
use super::long::{distances, half_depth};
use crate::Segment;
use crate::simd::{self, LANES};

thread_local! {
    /// Kept between calls, because to clear it takes as long as some dozens of steps.
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl Table {
    /// The airlight of each step of a march along `ray`, whose steps end at `ends`,
    /// distances from the start of the ray, m, that rise: what
    /// [`airlight`](crate::Evaluator::airlight) of [`ray.part`](Segment::part) is,
    /// within the [bound](Table::error_bound). The first step starts where the ray
    /// does. How long the ray is does not matter.
    ///
    /// A step takes one lookup, where it takes two in a batch of segments, and none
    /// if it is short beside its distance from the light.
    ///
    /// ```
    /// use airlight::{Evaluator, PhaseFunction, Segment, Table};
    ///
    /// let table = Table::new(&PhaseFunction::Isotropic, 64)?;
    /// let ray = Segment::from_ray([0.0; 3], [0.0, 0.0, -1.0], [1.0, 0.0, -4.0], 8.0);
    /// let ends: Vec<f32> = (1..=32).map(|i| 0.25 * i as f32).collect();
    /// let mut steps = vec![0.0; ends.len()];
    /// table.march(0.2, &ray, &ends, &mut steps);
    /// // Some of them are in the shadow; here none is.
    /// let sum: f32 = steps.iter().sum();
    /// assert!((sum / table.airlight(0.2, &ray) - 1.0).abs() < 2e-4);
    /// # Ok::<(), airlight::Error>(())
    /// ```
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn march(&self, sigma_t: f32, ray: &Segment, ends: &[f32], airlight: &mut [f32]) {
        assert_eq!(ends.len(), airlight.len(), "one result per step");
        let Some(lookup) = self.lookup(sigma_t) else {
            airlight.fill(0.0);
            return;
        };
        let batch = &Batch {
            table: self,
            lookup,
        };
        SCRATCH.with_borrow_mut(|scratch| {
            simd::arch().dispatch(March {
                batch,
                ray,
                ends,
                airlight,
                scratch,
            });
        });
    }
}

struct March<'a> {
    batch: &'a Batch<'a>,
    ray: &'a Segment,
    ends: &'a [f32],
    airlight: &'a mut [f32],
    scratch: &'a mut Scratch,
}

impl WithSimd for March<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let ray = *self.ray;
        let mut from = 0.0;
        let blocks = self.ends.chunks(LANES).zip(self.airlight.chunks_mut(LANES));
        for (ends, airlight) in blocks {
            // Steps that are not needed in the last block have no length.
            let mut to = [ends[ends.len() - 1]; LANES];
            to[..ends.len()].copy_from_slice(ends);
            let mut start = [from; LANES];
            start[1..].copy_from_slice(&to[..LANES - 1]);
            from = to[LANES - 1];
            let lanes = SegmentLanes::by(|i| ray.part(start[i], to[i]));
            let mut block = [0.0; LANES];
            self.batch.march(self.scratch, &lanes, &mut block);
            self.batch.integrate(self.scratch, &lanes, &mut block);
            airlight.copy_from_slice(&block[..airlight.len()]);
        }
    }
}

impl Batch<'_> {
    /// A block of segments each of which starts where the one before it ends.
    #[inline(always)]
    fn march(&self, scratch: &mut Scratch, lanes: &SegmentLanes, airlight: &mut [f32; LANES]) {
        if self.begin(scratch, lanes, airlight) {
            return;
        }
        let lookup = self.lookup;
        let octaves = lookup.extinction.octaves;
        for i in 0..LANES {
            let Segment { x, s, h, length } = lanes.get(i);
            let [length, end, d_start, d_end] = distances(s, h, length);
            scratch.ends[1].set(i, &lookup.end_at(end, h.abs(), d_end));
            scratch.depth.0[i] = half_depth(octaves, x, d_start);
            let growth = octaves * (length + (d_end - d_start));
            scratch.growth.0[i] = if growth > 0.0 { growth } else { 0.0 };
        }
        let Segment { s, h, .. } = lanes.get(0);
        let first = lookup.end_at(s, h.abs(), (s * s + h * h).sqrt());
        scratch.ends[1].look_up(self.table, &mut scratch.cells);
        let [starts, ends] = &mut scratch.ends;
        starts.follow(ends, self.table.found(&first));
        self.finish(scratch, lanes, airlight);
    }
}

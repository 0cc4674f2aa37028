//! Tables of frames for segments of many frames.

use airlight::{Error, Evaluator, FrameTable, PhaseFunction, Quadrature, Segment};

/// A table for each frame that the segments come from, and a quadrature for segments outside of
/// the tables.
#[derive(Debug)]
pub(super) struct Frames {
    tables: Vec<FrameTable>,
    fallback: Quadrature,
}

impl Frames {
    /// For pairs of extinction and distance between eye and light.
    pub(super) fn new(phase: PhaseFunction, frames: &[[f32; 2]], rows: u32) -> Result<Self, Error> {
        let tables = frames
            .iter()
            .map(|&[sigma_t, distance]| FrameTable::new(&phase, sigma_t, distance, rows));
        Ok(Self {
            tables: tables.collect::<Result<_, _>>()?,
            fallback: Quadrature::with_tolerance(phase, 1e-5)?,
        })
    }

    /// Memory of one table, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.tables.first().map_or(0, FrameTable::bytes)
    }

    /// The table of a segment and its number; the search begins at `hint`.
    fn table(&self, sigma_t: f32, segment: &Segment, hint: usize) -> Option<usize> {
        let distance = (segment.x - segment.s).hypot(segment.h);
        let is_it = |table: &FrameTable| {
            let off = (table.distance() - distance).abs();
            table.sigma_t() == sigma_t && off <= 1e-5 * distance
        };
        let count = self.tables.len();
        let mut all = (0..count).map(|i| (hint + i) % count);
        all.find(|&i| is_it(&self.tables[i]))
    }

    fn look_up(&self, sigma_t: f32, segment: &Segment, hint: &mut usize) -> f32 {
        let found = self.table(sigma_t, segment, *hint);
        *hint = found.unwrap_or(*hint);
        let known = found.and_then(|i| self.tables[i].look_up(segment));
        known.unwrap_or_else(|| self.fallback.airlight(sigma_t, segment))
    }
}

impl Evaluator for Frames {
    fn airlight(&self, sigma_t: f32, segment: &Segment) -> f32 {
        self.look_up(sigma_t, segment, &mut 0)
    }

    fn airlight_batch(&self, sigma_t: f32, segments: &[Segment], airlight: &mut [f32]) {
        let mut hint = 0;
        for (segment, airlight) in segments.iter().zip(airlight) {
            *airlight = self.look_up(sigma_t, segment, &mut hint);
        }
    }
}

//! Segments with an end so close to the light that single precision cannot
//! square its distance. They take the same ways as others, in double precision and one by
//! one.

use super::cells;
use super::long::{Lookup, distances};
use super::near::{NEAR, Node, THIN};
use super::short::Short;
use super::{LARGEST_REST, Table};
use crate::{Segment, Segment64};

/// Squares of lengths above this, m, and products of two such squares, keep all their digits in
/// single precision.
const CLOSE: f32 = 1e-17;

/// Whether an end of a segment is that close.
#[inline(always)]
pub(super) fn is_close(segment: &Segment) -> bool {
    let Segment { s, h, length, .. } = *segment;
    let end = s + length;
    let nearer = if s.abs() < end.abs() { s } else { end };
    // `&` in place of `&&` makes no branch, so that loops over segments become vector
    // instructions.
    (nearer.abs() < CLOSE) & (0.0..CLOSE).contains(&h)
}

impl Table {
    /// The airlight of a segment that is neither empty nor meets the light.
    #[cold]
    pub(super) fn close(&self, lookup: &Lookup, segment: &Segment) -> f32 {
        let Segment64 { x, s, h, length } = Segment64::from(*segment);
        let octaves = f64::from(lookup.extinction.octaves);
        let [length, end, d_start, d_end] = distances(s, h, length);
        let sigma_t = f64::from(lookup.extinction.sigma_t);
        // The value of the table at an end, and the factor that the table leaves out.
        let at = |s: f64, d: f64| {
            let behind = s >= 0.0;
            let q = s.abs() + d;
            let longer = if behind { q } else { h };
            let v = sigma_t * longer;
            let row = self.axes.row((h / q) as f32, 1.0, behind);
            let place = self.axes.place(self.axes.within(v as f32), row);
            let cell = self.cells[place.cell as usize];
            let value = cells::value(cell, self.units, place.alpha, place.beta);
            (f64::from(value), 1.0 / (longer * (1.0 + v)))
        };
        let is_near =
            length < f64::from(NEAR) * d_start && 2.0 * octaves * length < f64::from(THIN);
        let depth = octaves * (x + d_start);
        if !is_near {
            let (from, scale) = at(s, d_start);
            let (to, end_scale) = at(end, d_end);
            let growth = octaves * (length + (d_end - d_start));
            let rest = end_scale * (2.0 * (to - from) - growth).exp2();
            if rest < f64::from(LARGEST_REST) * scale {
                return ((2.0 * from - depth).exp2() * (scale - rest)) as f32;
            }
        }
        let phase = |w: f64, h: f64| match self.constant {
            Some(constant) => f64::from(constant).exp2(),
            None => {
                let behind = w > h;
                let ratio = if behind { h / w } else { w / h };
                // On the axis in front of the light both are 0, and so is b.
                let ratio = if ratio.is_nan() { 0.0 } else { ratio };
                let row = self.axes.row(ratio as f32, 1.0, behind);
                let index = (row.index as usize).min(self.phase.len() - 1);
                f64::from(cells::phase_value(self.phase[index], row.beta)).exp2()
            }
        };
        let lengths = [x, s, h, length];
        if is_near {
            let term = |&[t, weight]: &[f32; 2]| {
                Node::new(octaves, lengths, t.into()).term(weight.into(), phase)
            };
            return self.near_rule.iter().map(term).sum::<f64>() as f32;
        }
        let short = Short::new(octaves, lengths);
        let term = |&[t, weight]: &[f32; 2]| short.term(t.into(), weight.into(), phase);
        let sum: f64 = self.rule.iter().map(term).sum();
        ((-depth).exp2() * (2.0 * short.angle * sum)) as f32
    }
}

//! Parts that hold much of the light of the ray behind their start: the
//! difference of two lookups.

use super::axes::{Axes, Place};
use super::cells;
use crate::{Real, Segment};

/// What has to be known of one end of a segment, apart from its cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    pub(super) place: Place,
    /// `1 / (w (1 + v))` with `w = max(s + d, h)`, 1/m: the factor that was left out of the table.
    pub(super) scale: f32,
}

/// What has to be known of a segment, apart from its cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ends {
    pub(super) start: End,
    pub(super) end: End,
    /// Half the optical depth from the light by the start to the eye, over ln 2.
    pub(super) depth: f32,
    /// How much longer the way by the end is, over ln 2.
    pub(super) growth: f32,
    /// See [`known`].
    pub(super) known: f32,
    /// Whether the part is so short that there is no need to look.
    pub(super) is_near: bool,
}

/// Extinction as lookups want it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extinction {
    /// 1/m.
    pub(super) sigma_t: f32,
    /// Over ln 2.
    pub(super) octaves: f32,
}

impl Extinction {
    pub(super) fn new(sigma_t: f32) -> Self {
        Self {
            sigma_t,
            octaves: sigma_t * std::f32::consts::LOG2_E,
        }
    }
}

/// m: longer lengths are taken for this one, so that squares stay in range.
const FAR: f32 = 1e18;

/// Parts that are shorter than this, over the distance from the light and in
/// optical depth, are integrated: most of the light is behind their end.
pub(super) const NEAR: f32 = 0.25;

/// The length of a part, where it ends, and the distances of both its ends from
/// the light.
#[inline(always)]
pub(super) fn distances<T: Real>(s: T, h: T, length: T) -> [T; 4] {
    let far = T::from(FAR);
    let length = if length > far { far } else { length };
    let end = s + length;
    let h2 = h * h;
    [
        length,
        end,
        (s * s + h2).square_root(),
        (end * end + h2).square_root(),
    ]
}

/// Half of the optical depth over ln 2; more than any exponent for numbers
/// that are no depth.
#[inline(always)]
pub(super) fn half_depth<T: Real>(octaves: T, x: T, d: T) -> T {
    let depth = T::from(0.5) * octaves * (x + d);
    if depth >= T::from(0.0) {
        depth
    } else {
        T::from(1e3)
    }
}

/// What lookups into one table for one extinction have in common, small enough
/// to be kept in registers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lookup {
    pub(super) axes: Axes,
    pub(super) units: [f32; 3],
    pub(super) extinction: Extinction,
}

impl Lookup {
    /// Whether a part is so short that there is no need to look.
    #[inline(always)]
    pub(super) fn is_near(&self, segment: &Segment) -> bool {
        let Segment { s, h, length, .. } = *segment;
        // The way by the end is at most two lengths longer.
        length * length < (NEAR * NEAR) * (s * s + h * h)
            && 2.0 * self.extinction.octaves * length < NEAR
    }

    #[inline(always)]
    pub(super) fn ends(&self, segment: &Segment) -> Ends {
        let extinction = self.extinction;
        let [length, end, d_start, d_end] = distances(segment.s, segment.h, segment.length);
        let h = segment.h.abs();
        // In this order: the difference of the distances is at most the
        // length, and added to it as exactly as it is known.
        let growth = extinction.octaves * (length + (d_end - d_start));
        Ends {
            start: self.end(segment.s, h, d_start),
            end: self.end(end, h, d_end),
            depth: half_depth(extinction.octaves, segment.x, d_start),
            growth: if growth > 0.0 { growth } else { 0.0 },
            known: known(segment),
            is_near: self.is_near(segment),
        }
    }

    #[inline(always)]
    fn end(&self, s: f32, h: f32, d: f32) -> End {
        let behind = s >= 0.0;
        let q = s.abs() + d;
        let longer = if behind { q } else { h };
        let v = self.extinction.sigma_t * longer;
        End {
            place: self.axes.place(v, self.axes.row(h, q, behind)),
            scale: 1.0 / (longer * (1.0 + v)),
        }
    }

    /// The airlight, and whether too much of it was lost in the difference:
    /// then it has to be integrated as a short part.
    #[inline(always)]
    pub(super) fn difference(&self, ends: &Ends, cells: [[f32; 4]; 2]) -> (f32, bool) {
        let Ends { start, end, .. } = ends;
        let at = |place: &Place, cell| cells::value(cell, self.units, place.alpha, place.beta);
        let from = at(&start.place, cells[0]);
        let to = at(&end.place, cells[1]);
        let fall = (to - from) + (to - from) - ends.growth;
        let rest = end.scale * crate::simd::exp2(fall);
        let root = crate::simd::exp2(from - ends.depth);
        let airlight = root * (root * (start.scale - rest));
        // Not the same as `rest >= …`: on the axis both are infinite, and
        // short parts cope with that and with NaN.
        let keeps_digits = rest < super::LARGEST_REST * start.scale;
        (airlight, ends.is_near || !keeps_digits)
    }
}

/// The airlight of segments for which there is nothing to compute: +∞ with the
/// light on the segment, 0 for a length of 0 and for what is no length. NaN
/// for all others.
#[inline(always)]
pub(crate) fn known(segment: &Segment) -> f32 {
    let Segment { s, h, length, .. } = *segment;
    let meets_light = h == 0.0 && s <= 0.0 && s + length >= 0.0;
    let known = if meets_light { f32::INFINITY } else { f32::NAN };
    if h >= 0.0 && length > 0.0 { known } else { 0.0 }
}

/// The airlight that is known, or else the one that was computed, if it is a
/// number.
#[inline(always)]
pub(crate) fn settle(known: f32, computed: f32) -> f32 {
    let computed = if computed > 0.0 { computed } else { 0.0 };
    if known >= 0.0 { known } else { computed }
}

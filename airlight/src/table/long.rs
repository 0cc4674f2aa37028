//! Parts that hold much of the light of the ray behind their start: the
//! difference of two lookups.

use super::axes::{Axes, Place};
use crate::{Real, Segment};

/// One end of a segment, as a lookup needs it, without its cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    pub(super) place: Place,
    /// `w (1 + v)` with `w = max(s + d, h)`, m: the divisor of what the table gives. v is
    /// clamped to the end of the table, where nothing is left.
    pub(super) divisor: f32,
}

/// A segment, as a lookup needs it, without its cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ends {
    pub(super) start: End,
    pub(super) end: End,
    /// Half the optical depth from the light by the start to the eye, over ln 2.
    pub(super) depth: f32,
    /// How much more optical depth the way by the end has, over ln 2.
    pub(super) growth: f32,
}

/// The result of a lookup at an end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// The polynomial of its cell.
    pub(super) value: f32,
    /// As in [`End`].
    pub(super) divisor: f32,
}

/// An end on the way to its place.
#[derive(Debug, Clone, Copy)]
struct Way {
    behind: bool,
    v: f32,
    /// See [`Axes::along`].
    along: f32,
    divisor: f32,
}

/// Extinction in the two forms that lookups need.
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

/// Lengths above this, m, count as this, so that squares stay in range.
const FAR: f32 = 1e18;

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

/// Half of the optical depth over ln 2. For NaN and negative numbers it is 1000, which
/// leaves no light.
#[inline(always)]
pub(super) fn half_depth<T: Real>(octaves: T, x: T, d: T) -> T {
    let depth = T::from(0.5) * octaves * (x + d);
    if depth >= T::from(0.0) {
        depth
    } else {
        T::from(1e3)
    }
}

/// Values that lookups into one table for one extinction have in common, few enough to be kept in
/// registers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lookup {
    pub(super) axes: Axes,
    pub(super) extinction: Extinction,
}

impl Lookup {
    #[inline(always)]
    pub(super) fn ends(&self, segment: &Segment) -> Ends {
        let extinction = self.extinction;
        let [length, end, d_start, d_end] = distances(segment.s, segment.h, segment.length);
        let h = segment.h.abs();
        // Summed in this order nothing cancels badly, because the difference of the distances
        // is at most the length.
        let growth = extinction.octaves * (length + (d_end - d_start));
        // One division for both ends: these products are in range for every
        // segment that is not close, see `close`.
        let (from, to) = (self.way(segment.s, h, d_start), self.way(end, h, d_end));
        let quotient = h / (from.along * to.along);
        Ends {
            start: self.end(from, quotient * to.along),
            end: self.end(to, quotient * from.along),
            depth: half_depth(extinction.octaves, segment.x, d_start),
            growth: if growth > 0.0 { growth } else { 0.0 },
        }
    }

    /// One end by itself.
    #[inline(always)]
    pub(super) fn end_at(&self, s: f32, h: f32, d: f32) -> End {
        let way = self.way(s, h, d);
        self.end(way, h / way.along)
    }

    #[inline(always)]
    fn way(&self, s: f32, h: f32, d: f32) -> Way {
        let behind = s >= 0.0;
        let q = s.abs() + d;
        let longer = if behind { q } else { h };
        let v = self.axes.within(self.extinction.sigma_t * longer);
        Way {
            behind,
            v,
            along: self.axes.along(h, q, behind),
            divisor: longer * (1.0 + v),
        }
    }

    #[inline(always)]
    fn end(&self, way: Way, quotient: f32) -> End {
        End {
            place: self
                .axes
                .place(way.v, self.axes.row_at(quotient, way.behind)),
            divisor: way.divisor,
        }
    }

    /// The airlight, and whether too much of it was lost in the difference:
    /// then it has to be integrated as a short part.
    #[inline(always)]
    pub(super) fn difference(
        &self,
        [start, end]: [Found; 2],
        depth: f32,
        growth: f32,
    ) -> (f32, bool) {
        let half_fall = end.value - start.value;
        let fall = half_fall + half_fall - growth;
        // The share of the light behind the start that is left behind the end, times the end's
        // divisor.
        let rest = start.divisor * crate::simd::exp2(fall);
        let root = crate::simd::exp2(start.value - depth);
        // The start's divisor is divided by in two steps, first its mantissa and later its
        // power of two, so that no product leaves the range.
        let power =
            f32::from_bits((254_u32 << 23).wrapping_sub(start.divisor.to_bits() & 0x7f80_0000));
        let share = (end.divisor - rest) / (end.divisor * (start.divisor * power));
        let airlight = root * (root * (share * power));
        // If the comparison is false, the part is a short one. Short parts also cope with NaN and
        // with the axis in front of the light, where both sides are 0.
        let keeps_digits = rest < super::LARGEST_REST * end.divisor;
        (airlight, !keeps_digits)
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

/// The airlight that is known, or else the one that was computed; 0 if that is NaN or
/// negative.
#[inline(always)]
pub(crate) fn settle(known: f32, computed: f32) -> f32 {
    let computed = if computed > 0.0 { computed } else { 0.0 };
    if known >= 0.0 { known } else { computed }
}

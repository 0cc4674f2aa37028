//! A segment in a unit of length in which its squares are in range.

use crate::Segment64;

/// A segment in units of the distance of its start from the light, so that
/// squares stay in range.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scaled {
    /// The unit, m.
    pub(crate) unit: f64,
    /// Extinction per unit.
    pub(crate) sigma: f64,
    /// Start, end and the distance between ray and light.
    pub(crate) s: f64,
    pub(crate) end: f64,
    pub(crate) h: f64,
    pub(crate) length: f64,
    /// Distance of the end from the light.
    pub(crate) end_distance: f64,
    /// Optical depth of the way from the light by the start to the eye.
    pub(crate) depth: f64,
}

/// The part of a segment that has to be integrated.
#[derive(Debug)]
pub(crate) enum Extent {
    /// Nothing: a length of 0, numbers that are no lengths, or no light.
    Empty,
    /// The light is on the segment.
    MeetsLight,
    /// Anything else.
    Ordinary(Scaled),
}

/// Distance from the light, relative to that of the start, below which its
/// square is no longer a number.
const NEAREST: f64 = 1e-150;

/// Optical depth that leaves nothing, even of the smallest f64.
const OPAQUE: f64 = 750.0;

impl Scaled {
    /// `segment` in units of the distance of its start from the light; empty
    /// if no light is left at its start.
    pub(crate) fn of(sigma_t: f64, segment: &Segment64) -> Extent {
        match Self::of_lengths(sigma_t, segment) {
            Extent::Ordinary(scaled) if !(scaled.depth < OPAQUE) => Extent::Empty,
            extent => extent,
        }
    }

    /// The same however little light is left at the start.
    pub(crate) fn of_lengths(sigma_t: f64, segment: &Segment64) -> Extent {
        let Segment64 { x, s, h, length } = *segment;
        let lengths = x.is_finite() && s.is_finite() && h >= 0.0 && h.is_finite() && length > 0.0;
        if !(lengths && sigma_t >= 0.0 && sigma_t.is_finite()) {
            return Extent::Empty;
        }
        // The sum comes before the division, because it is exact where the end is close to the
        // light. h loses its sign, because a quotient by −0 would have the wrong one.
        let (end, h) = (s + length, h.abs());
        let unit = distance(s, h);
        if h <= NEAREST * unit && s <= 0.0 && end >= 0.0 {
            return Extent::MeetsLight;
        }
        let depth = sigma_t * x + sigma_t * unit;
        if !unit.is_finite() {
            return Extent::Empty;
        }
        let (end, h) = (end / unit, h / unit);
        // If the end is out of range, the segment counts as endless: the light from there is
        // nothing.
        let length = if end.is_finite() {
            length / unit
        } else {
            f64::INFINITY
        };
        Extent::Ordinary(Self {
            unit,
            sigma: sigma_t * unit,
            s: s / unit,
            end,
            h,
            length,
            end_distance: distance(end, h),
            depth,
        })
    }
}

impl Scaled {
    /// `segment`, which comes from single precision so that its squares are in range. For a
    /// segment that has no airlight the result means nothing. There are no branches, so that
    /// loops over segments become vector instructions.
    #[inline(always)]
    pub(crate) fn of_singles(sigma_t: f64, segment: &Segment64) -> Self {
        let Segment64 { x, s, h, length } = *segment;
        let unit = (s * s + h * h).sqrt();
        let per_unit = 1.0 / unit;
        // The sum comes first and h loses its sign, as above.
        let (end, h) = ((s + length) * per_unit, h.abs() * per_unit);
        Self {
            unit,
            sigma: sigma_t * unit,
            s: s * per_unit,
            end,
            h,
            length: length * per_unit,
            end_distance: (end * end + h * h).sqrt(),
            depth: sigma_t * x + sigma_t * unit,
        }
    }
}

/// `√(s² + h²)`; in the usual range it does not need `hypot`, which is slower.
fn distance(s: f64, h: f64) -> f64 {
    let square = s * s + h * h;
    if square > 1e-280 && square < 1e280 {
        square.sqrt()
    } else {
        s.hypot(h)
    }
}

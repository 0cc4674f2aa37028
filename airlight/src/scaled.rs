//! A segment in a unit of length in which its squares are in range.

use crate::Segment64;
use crate::emission::Part;

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

/// The least distance from the light, relative to that of the start, at which single precision
/// can go along the ray; see [`Scaled::in_singles`].
pub(crate) const NEAREST_OF_SINGLES: f64 = 1e-16;

/// The least length, relative to the distance of the start from the light, whose products with
/// other numbers are full ones in single precision.
pub(crate) const SHORTEST_OF_SINGLES: f64 = 1e-25;

/// Smaller distances of a ray count as this one, so that none is divided by 0.
const SMALLEST: f64 = 1e-300;

/// Optical depth that leaves nothing, even of the smallest f64.
const OPAQUE: f64 = 750.0;

impl Extent {
    /// Empty if no light is left at its start.
    fn unless_opaque(self) -> Self {
        match self {
            Self::Ordinary(scaled) if !(scaled.depth < OPAQUE) => Self::Empty,
            extent => extent,
        }
    }
}

impl Scaled {
    /// `segment` in units of the distance of its start from the light; empty
    /// if no light is left at its start.
    pub(crate) fn of(sigma_t: f64, segment: &Segment64) -> Extent {
        Self::of_lengths(sigma_t, segment).unless_opaque()
    }

    /// The same for a part of a segment.
    pub(crate) fn of_part(sigma_t: f64, part: &Part) -> Extent {
        Self::of_ends(sigma_t, &part.segment, part.end).unless_opaque()
    }

    /// [`Scaled::of`] however little light is left at the start.
    pub(crate) fn of_lengths(sigma_t: f64, segment: &Segment64) -> Extent {
        // The sum comes before the division, because it is exact where the end is close to the
        // light.
        Self::of_ends(sigma_t, segment, segment.s + segment.length)
    }

    /// [`Scaled::of_lengths`] of a segment with this end.
    pub(crate) fn of_ends(sigma_t: f64, segment: &Segment64, end: f64) -> Extent {
        let Segment64 { x, s, h, length } = *segment;
        let lengths = x.is_finite() && s.is_finite() && h >= 0.0 && h.is_finite() && length > 0.0;
        if !(lengths && sigma_t >= 0.0 && sigma_t.is_finite()) {
            return Extent::Empty;
        }
        // It loses its sign, because a quotient by −0 would have the wrong one.
        let h = h.abs();
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

impl Scaled {
    /// The same segment, or one that comes less close to the light if for this one what is near
    /// the light and what is far are not both numbers in single precision, and one that is longer
    /// if this one is too short for it; and the airlight of this one over that of the other.
    ///
    /// What is near the light is enlarged then. Its airlight is an integral over angles, which do
    /// not change, over a distance. What comes from elsewhere is a share of 1e-16 of it, or 1e-7
    /// with the sharpest of peaks. All of a short segment is as bright as its start.
    #[inline(always)]
    pub(crate) fn in_singles(self) -> (Self, f64) {
        let Self { s, end, h, .. } = self;
        let nearest = if -end > h { -end } else { h };
        let passes = (nearest < NEAREST_OF_SINGLES) & (s <= 0.0);
        let nearest = if nearest > SMALLEST {
            nearest
        } else {
            SMALLEST
        };
        let growth = if passes {
            NEAREST_OF_SINGLES / nearest
        } else {
            1.0
        };
        // An end that is not near stays where it is, or comes no farther away than the start.
        let (enlarged, most) = (end * growth, if end > 1.0 { end } else { 1.0 });
        let enlarged = if enlarged < most { enlarged } else { most };
        let end = if passes { enlarged } else { end };
        let h = h * growth;
        let length = if passes { end - s } else { self.length };
        let longer = if length < SHORTEST_OF_SINGLES {
            SHORTEST_OF_SINGLES
        } else {
            length
        };
        let of_other = Self {
            h,
            end,
            length: longer,
            end_distance: if passes {
                (end * end + h * h).sqrt()
            } else {
                self.end_distance
            },
            ..self
        };
        // An endless segment is not divided by itself, which would give no number.
        let shortened = if length < longer {
            length / longer
        } else {
            1.0
        };
        (of_other, growth * shortened)
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

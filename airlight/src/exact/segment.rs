//! A part of an eye ray in double precision.

use crate::Segment;

/// A [`Segment`] in double precision: the same four lengths.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Segment64 {
    /// Way from the eye to the start of the part, at least 0.
    pub x: f64,
    /// Position of the start behind the foot point of the light.
    pub s: f64,
    /// Distance between the light and the line of the ray, at least 0.
    pub h: f64,
    /// Length of the part, at least 0, may be infinite.
    pub length: f64,
}

/// A segment in units of the distance of its start from the light, so that
/// squares stay in range.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scaled {
    /// The unit, m.
    pub(super) unit: f64,
    /// Extinction per unit.
    pub(super) sigma: f64,
    /// Start, end and the distance between ray and light.
    pub(super) s: f64,
    pub(super) end: f64,
    pub(super) h: f64,
    pub(super) length: f64,
    /// Distance of the end from the light.
    pub(super) end_distance: f64,
    /// Optical depth of the way from the light by the start to the eye.
    pub(super) depth: f64,
}

/// What there is to integrate.
#[derive(Debug)]
pub(super) enum Extent {
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
pub(super) const OPAQUE: f64 = 750.0;

impl Segment64 {
    /// In units of the distance of its start from the light.
    pub(super) fn scaled(&self, sigma_t: f64) -> Extent {
        let Self { x, s, h, length } = *self;
        let lengths = x.is_finite() && s.is_finite() && h >= 0.0 && h.is_finite() && length > 0.0;
        if !(lengths && sigma_t >= 0.0 && sigma_t.is_finite()) {
            return Extent::Empty;
        }
        // The sum first: it is exact where the end is next to the light.
        let end = s + length;
        let unit = s.hypot(h);
        if h <= NEAREST * unit && s <= 0.0 && end >= 0.0 {
            return Extent::MeetsLight;
        }
        let depth = sigma_t * x + sigma_t * unit;
        if !(unit.is_finite() && depth < OPAQUE) {
            return Extent::Empty;
        }
        let (end, h) = (end / unit, h / unit);
        // An end that is out of range has no inverse square that counts.
        let length = if end.is_finite() {
            length / unit
        } else {
            f64::INFINITY
        };
        Extent::Ordinary(Scaled {
            unit,
            sigma: sigma_t * unit,
            s: s / unit,
            end,
            h,
            length,
            end_distance: end.hypot(h),
            depth,
        })
    }
}

impl From<Segment> for Segment64 {
    fn from(segment: Segment) -> Self {
        Self {
            x: segment.x.into(),
            s: segment.s.into(),
            h: segment.h.into(),
            length: segment.length.into(),
        }
    }
}

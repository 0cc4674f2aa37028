//! The parts of a segment over which an emission is smooth.

use super::{Emission, Pattern};
use crate::{ScatteringAngle, Segment64};

/// A part of a segment that is lit and over which the emission is smooth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    pub(crate) segment: Segment64,
    /// Where it ends, behind the foot point; the sum of its start and length rounds what is close
    /// to the light.
    pub(crate) end: f64,
    /// Whether the emission does not depend on the direction in it.
    pub(crate) is_full: bool,
}

impl Emission {
    /// The parts of a segment that are lit and over which the emission is
    /// smooth, in order.
    pub(crate) fn parts(&self, segment: &Segment64) -> impl Iterator<Item = Part> + use<> {
        let emission = *self;
        let segment = *segment;
        let cuts = emission.cuts(&segment);
        cuts.into_iter()
            .zip(cuts.into_iter().skip(1))
            .filter(|(start, end)| start < end)
            .filter_map(move |(start, end)| {
                let is_full = emission.lights(start, end, segment.h)?;
                let segment = Segment64 {
                    x: segment.x + (start - segment.s),
                    s: start,
                    length: if start == segment.s && end == segment.s + segment.length {
                        segment.length
                    } else {
                        end - start
                    },
                    ..segment
                };
                Some(Part {
                    segment,
                    end,
                    is_full,
                })
            })
    }

    /// Whether the middle of a part is fully lit, and with it all of it; `None`
    /// where it is dark.
    fn lights(&self, start: f64, end: f64, h: f64) -> Option<bool> {
        let middle = if end == f64::INFINITY {
            start + start.abs() + h + 1.0
        } else {
            start + 0.5 * (end - start)
        };
        let angle = ScatteringAngle::from_foot(middle, h);
        if !(middle.hypot(h) <= self.range) {
            return None;
        }
        match self.pattern {
            Pattern::Isotropic => Some(true),
            Pattern::Cosine => (self.above(0.0, angle) > 0.0).then_some(false),
            Pattern::Spot { outer, slope } => {
                let ramp = self.above(outer, angle) * slope;
                // A ray that only touches the full cone is at one point in it, which
                // can be the middle.
                let is_crossed = outer + 1.0 / slope < self.along.hypot(self.across);
                (ramp > 0.0).then_some(ramp >= 1.0 && is_crossed)
            }
        }
    }

    /// Ends of smooth parts, rising: positions behind the foot point.
    fn cuts(&self, segment: &Segment64) -> [f64; 9] {
        let Segment64 { s, h, length, .. } = *segment;
        let end = s + length;
        // Cuts that do not apply are put at the end.
        let mut cuts = [end; 9];
        cuts[0] = s;
        // On a line through the light, the light is a cut.
        cuts[1] = if h == 0.0 { 0.0 } else { end };
        if self.range.is_finite() && self.range > h {
            let reach = ((self.range - h) * (self.range + h)).sqrt();
            (cuts[2], cuts[3]) = (-reach, reach);
        }
        match self.pattern {
            Pattern::Isotropic => {}
            Pattern::Cosine => [cuts[4], cuts[5]] = self.crossings(0.0, h, end),
            Pattern::Spot { outer, slope } => {
                [cuts[4], cuts[5]] = self.crossings(outer, h, end);
                [cuts[6], cuts[7]] = self.crossings(outer + 1.0 / slope, h, end);
            }
        }
        for cut in &mut cuts {
            // NaN, which lengths that are none give, goes to the end.
            *cut = if *cut >= s && *cut <= end { *cut } else { end };
        }
        cuts.sort_by(f64::total_cmp);
        cuts
    }

    /// Where `cos θ_l` is `cosine`; `none` where it nowhere is.
    fn crossings(&self, cosine: f64, h: f64, none: f64) -> [f64; 2] {
        let (along, across) = (self.along, self.across);
        let length = along.hypot(across);
        if !(cosine.abs() < length) {
            return [none; 2];
        }
        // The axis turned by the angle of the cone, either way.
        let cosine = cosine / length;
        let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
        [sine, -sine].map(|sine| {
            let s = along * cosine - across * sine;
            let up = across * cosine + along * sine;
            if up > 0.0 { h * (s / up) } else { none }
        })
    }
}

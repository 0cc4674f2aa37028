//! One side of the foot point in a variable that no limit spoils.

use crate::scaled::Scaled;

/// Which variable a [`Side`] has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// `q`, in front of the foot point.
    Front,
    /// `t`, behind it.
    Behind,
    /// `1/t`, behind it and without absorption; `b` is 0 in the backward
    /// direction.
    Thin,
}

/// The part of a segment on one side of the foot point, as an integral over
/// `o` from 0 to `extent`, in units of the distance of the segment's start:
///
/// ```text
/// ∫ p e^{−Y} dx / d² = ∫ 2 scale p e^{−Y} / (a² + b²) do
/// b = unit (base + o),   tan(θ/2) = b/a (or a/b),   Y = depth + rate o
/// ```
///
/// Behind the foot point `1 + o` is the growth of `t = s + d` from its first
/// value, with `b/a = t/h`: since `dx / d² = 2 dt / (h² + t²)` and `x + d`
/// grows as `t` does, the inverse square and the exponent are both elementary
/// in it. In front, where `t = h² / (d − s)` tells nothing if `h` is 0, it is
/// the growth of `q = 1 / (d − s)`, with `b = h q` and `a = 1`. Without
/// absorption a far end need not be cut off; there it is the growth of `1/t`
/// from the far end on, against the direction of the ray, with `b = h/t`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    pub(crate) a: f64,
    pub(crate) unit: f64,
    pub(crate) base: f64,
    pub(crate) kind: Kind,
    pub(crate) scale: f64,
    pub(crate) depth: f64,
    pub(crate) rate: f64,
    /// May be infinite if `rate` is positive.
    pub(crate) extent: f64,
    /// The scale of `b` below which the integrand no longer changes.
    pub(crate) finest: f64,
    /// Way from the start of the segment to the start of the side.
    pub(crate) offset: f64,
    /// `base + o` below which the light fades with the distance; 0 if it does
    /// not. See [`Side::fading`].
    pub(crate) faded: f64,
}

/// Width of the sharpest peak that is looked for; it is as sharp as g next to 1
/// in single precision.
pub(crate) const SHARPEST: f64 = 1e-9;

fn sharpest(peak: f64) -> f64 {
    if peak > SHARPEST { peak } else { SHARPEST }
}

impl Side {
    /// The sides of a segment; `peaks` as in
    /// [`Phase::peaks`](crate::Phase::peaks). Absorption behind the foot point
    /// is ignored if `sigma` of the segment is below `thin`, which changes the
    /// result by about `−thin ln(thin)` of itself.
    pub(crate) fn both(
        segment: &Scaled,
        peaks: [f64; 2],
        thin: f64,
    ) -> impl Iterator<Item = Self> + use<> {
        let sides = [
            Self::front(segment, peaks),
            Self::behind(segment, peaks, thin),
        ];
        sides.into_iter().filter(|side| side.extent > 0.0)
    }

    /// The side in front of the foot point, with an extent of 0 if there is none. Neither
    /// side has branches, so that loops over segments become vector instructions.
    #[inline(always)]
    pub(crate) fn front(segment: &Scaled, peaks: [f64; 2]) -> Self {
        let Scaled {
            sigma,
            s,
            end,
            h,
            length,
            end_distance,
            ..
        } = *segment;
        let ends = end < 0.0;
        let length = if ends { length } else { -s };
        let (end, distance) = (
            if ends { end } else { 0.0 },
            if ends { end_distance } else { h },
        );
        let first = 1.0 / (1.0 - s);
        let ratio = (1.0 - s) / (distance - end);
        let extent = length * ((1.0 + ratio) / (1.0 + distance));
        Self {
            a: 1.0,
            unit: h * first,
            base: 1.0,
            kind: Kind::Front,
            scale: first,
            depth: 0.0,
            rate: sigma * h * h * first,
            extent: if s < 0.0 { extent } else { 0.0 },
            finest: sharpest(peaks[0]),
            offset: 0.0,
            faded: 0.0,
        }
    }

    /// The side behind the foot point.
    #[inline(always)]
    pub(crate) fn behind(segment: &Scaled, peaks: [f64; 2], thin: f64) -> Self {
        let Scaled {
            sigma,
            s,
            end,
            h,
            length,
            end_distance,
            ..
        } = *segment;
        let front = Self::front(segment, peaks);
        let crosses = s < 0.0;
        let finite = length < f64::INFINITY;
        let length = if crosses { end } else { length };
        let distance = if crosses { h } else { 1.0 };
        let first = if crosses { h } else { s + 1.0 };
        let is_thin = sigma < thin;
        let per_first = 1.0 / first;
        let along = length / (distance + end_distance);
        let base = first / (end + end_distance);
        let growth = along * (1.0 + (end + end_distance) / first);
        let thin_extent = if finite { along * (base + 1.0) } else { 1.0 };
        let extent = if finite { growth } else { f64::INFINITY };
        let extent = if is_thin { thin_extent } else { extent };
        let base = if finite { base } else { 0.0 };
        Self {
            a: if is_thin { 1.0 } else { h / first },
            unit: if is_thin { h / first } else { 1.0 },
            base: if is_thin { base } else { 1.0 },
            kind: if is_thin { Kind::Thin } else { Kind::Behind },
            scale: per_first,
            depth: if crosses {
                front.rate * front.extent
            } else {
                0.0
            },
            rate: if is_thin { 0.0 } else { sigma * first },
            extent: if end > 0.0 { extent } else { 0.0 },
            finest: if is_thin { sharpest(peaks[1]) } else { 0.0 },
            offset: if crosses { -s } else { 0.0 },
            faded: 0.0,
        }
    }

    /// Cuts the side off at this optical depth, or where the distance from the light has
    /// grown by the factor `far`: nothing that counts is left behind.
    #[inline(always)]
    pub(crate) fn reach(&mut self, opacity: f64, far: f64) {
        let opaque = (opacity - self.depth) / self.rate;
        let limit = if self.rate > 0.0 {
            opaque
        } else {
            f64::INFINITY
        };
        let limit = if self.kind == Kind::Behind && far < limit {
            far
        } else {
            limit
        };
        self.extent = if limit < self.extent {
            limit
        } else {
            self.extent
        };
    }

    /// `b` at `o`.
    #[inline(always)]
    pub(crate) fn b(&self, o: f64) -> f64 {
        self.unit * (self.base + o)
    }

    /// The same side of a light that fades towards a range, in units of the
    /// segment, and is undiminished up to a `share` of it.
    ///
    /// The distance from the light is `d = (a² + b²) / (2 scale (base + o))`:
    /// a light that fades with a power of it has a pole where `base + o` is 0,
    /// which phase functions do not have in front of the foot point.
    pub(crate) fn fading(self, range: f64, share: f64) -> Self {
        let faded = if self.kind == Kind::Behind {
            // Behind the foot point pieces keep away from the pole in any case.
            0.0
        } else {
            0.5 / (self.scale * share * range)
        };
        Self { faded, ..self }
    }

    /// The distance from the light at `o`.
    #[inline(always)]
    pub(crate) fn distance(&self, o: f64) -> f64 {
        let b = self.b(o);
        (self.a * self.a + b * b) / (2.0 * self.scale * (self.base + o))
    }

    /// Whether the light still fades at `o`, where pieces have to keep away from
    /// the pole.
    pub(crate) fn fades(&self, o: f64) -> bool {
        self.base + o < self.faded
    }

    /// The end of a piece from `o` on over which the integrand is smooth.
    ///
    /// Poles of the integrand have `b` imaginary, so that `b` may change by a
    /// factor of `growth` over a piece; below the width of the sharpest peak
    /// it does not matter any more. The exponent may grow by `fade`, or, where
    /// nothing much is left of the exponential, by a factor of 2.
    pub(crate) fn next(&self, o: f64, growth: f64, fade: f64) -> f64 {
        let mut width = if self.fades(o) {
            (growth - 1.0) * (self.base + o)
        } else {
            (growth - 1.0) * (self.b(o) + self.finest) / self.unit
        };
        if self.rate > 0.0 {
            width = width.min((self.rate * o).max(fade) / self.rate);
        }
        // The last piece may be a tenth longer, so that no sliver is left.
        if width > 0.0 && self.extent - o > 1.1 * width {
            o + width
        } else {
            self.extent
        }
    }

    /// An upper bound of the light from behind `o` if p is 1 there; infinite on sides
    /// without absorption.
    pub(crate) fn left(&self, o: f64) -> f64 {
        if self.kind != Kind::Behind {
            return f64::INFINITY;
        }
        let b = self.b(o);
        let fall = (-(self.depth + self.rate * o)).exp();
        2.0 * self.scale * fall / (self.rate * (self.a * self.a + b * b))
    }

    /// Whether the side goes on at `o` and the optical depth there is below `opacity`.
    pub(crate) fn reaches(&self, o: f64, opacity: f64) -> bool {
        o < self.extent && self.depth + self.rate * o < opacity
    }
}

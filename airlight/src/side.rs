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
        let Scaled {
            sigma,
            s,
            end,
            h,
            length,
            end_distance,
            ..
        } = *segment;
        let peaks = peaks.map(|peak| if peak > SHARPEST { peak } else { SHARPEST });

        let mut depth = 0.0;
        let front = (s < 0.0).then(|| {
            let (length, end, distance) = if end < 0.0 {
                (length, end, end_distance)
            } else {
                (-s, 0.0, h)
            };
            let first = 1.0 / (1.0 - s);
            let ratio = (1.0 - s) / (distance - end);
            let extent = length * ((1.0 + ratio) / (1.0 + distance));
            let rate = sigma * h * h * first;
            depth = rate * extent;
            Self {
                a: 1.0,
                unit: h * first,
                base: 1.0,
                kind: Kind::Front,
                scale: first,
                depth: 0.0,
                rate,
                extent,
                finest: peaks[0],
                offset: 0.0,
                faded: 0.0,
            }
        });

        let behind = (end > 0.0).then(|| {
            let (length, start, distance, offset) = if s < 0.0 {
                (end, 0.0, h, -s)
            } else {
                (length, s, 1.0, 0.0)
            };
            let first = start + distance;
            let finite = length.is_finite();
            if sigma < thin {
                let (base, extent) = if finite {
                    let base = first / (end + end_distance);
                    (base, length * ((base + 1.0) / (distance + end_distance)))
                } else {
                    (0.0, 1.0)
                };
                return Self {
                    a: 1.0,
                    unit: h / first,
                    base,
                    kind: Kind::Thin,
                    scale: 1.0 / first,
                    depth,
                    rate: 0.0,
                    extent,
                    finest: peaks[1],
                    offset,
                    faded: 0.0,
                };
            }
            let extent = if finite {
                length * ((1.0 + (end + end_distance) / first) / (distance + end_distance))
            } else {
                f64::INFINITY
            };
            Self {
                a: h / first,
                unit: 1.0,
                base: 1.0,
                kind: Kind::Behind,
                scale: 1.0 / first,
                depth,
                rate: sigma * first,
                extent,
                finest: 0.0,
                offset,
                faded: 0.0,
            }
        });
        front.into_iter().chain(behind)
    }

    /// `b` at `o`.
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
            // Pieces are as short as that in any case.
            0.0
        } else {
            0.5 / (self.scale * share * range)
        };
        Self { faded, ..self }
    }

    /// The distance from the light at `o`.
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
        // A little more at the end, to leave no sliver.
        if width > 0.0 && self.extent - o > 1.1 * width {
            o + width
        } else {
            self.extent
        }
    }

    /// Whether light is left at `o`, of which `opacity` leaves nothing.
    pub(crate) fn reaches(&self, o: f64, opacity: f64) -> bool {
        o < self.extent && self.depth + self.rate * o < opacity
    }
}

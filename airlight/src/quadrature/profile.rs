//! What a light with a pattern adds to the integrand of a piece.
//!
//! With `tan(θ/2) = b/a` the cosine between the axis of the light and the
//! direction to a point of the ray is a quotient of quadratic polynomials of b,
//!
//! ```text
//! cos θ_l − c = (A b² + 2 B a b + C a²) / (a² + b²),    A = n·ω − c,  B = n·ĥ,  C = −n·ω − c
//! ```
//!
//! so that between two rims the emission is `r` (a cosine) or `r²` (a spot) with
//! such a quotient `r`. Its poles are those of `1 / (a² + b²)`, which the
//! integrand has anyway: the ellipse around a piece that is free of poles is the
//! same as without a pattern, and so is the factor `ρ^{−2n}` by which n nodes
//! bring the error down. The numerator is a polynomial of degree 2 or 4 in the
//! variable of the nodes, over a power of its denominator, and grows by `ρ²` or
//! `ρ⁴` between the piece and the ellipse. A node more makes up for a factor of
//! `ρ²`, so that one or two more bring the error down to that of a plain light,
//! relative to the largest emission on the piece. What counts is the error relative
//! to the mean, which is smaller: for `r²` that starts at a rim it is a third, and
//! less where the rest of the integrand falls. For `r` the margin of the plain
//! rules is enough, `r²` takes a third node. Hence [`COSINE`] and [`SPOT`].
//!
//! A light that fades like `1 − (d/range)⁴`, with `d = (a² + b²) / (2 scale q)`
//! where `b = unit q`, has a pole of fourth order where q is 0. Behind the foot
//! point pieces keep away from that in any case, as the inverse square has its
//! pole there if the ray meets the light. In front of it they do only where the
//! light fades noticeably, beyond a fiftieth of the range. Seen from the start of a
//! piece, whose distance from the light changes by no more than a factor, the fading has
//! the degree of a few powers only, and falls to 0 like the distance: [`FADING`]
//! more.
//!
//! With these numbers no case of the tests misses a tolerance; with two nodes
//! between the rims of a spot a few in ten thousand missed 1e-6 by up to 2.4 times.
//!
//! Nothing is formed as a difference of cosines: the quadratic is shifted to the
//! start of the piece in double precision, and is 0 there if that is a rim.

use crate::Segment64;
use crate::emission::{Emission, Part};
use crate::side::{Kind, Side};

/// More nodes on each piece for an emission that is proportional to a cosine.
pub const COSINE: usize = 1;
/// The same between the rims of a spot.
pub const SPOT: usize = 3;
/// The same for a light that fades towards its range.
pub const FADING: usize = 1;

/// The most nodes that a pattern asks for on a piece, and what else is smooth.
pub(super) const MOST: usize = SPOT + FADING + 2;

/// The share of the range of a light up to which fading by its fourth power does
/// not matter for a tolerance of 1e-6.
pub(crate) const UNFADED: f64 = 0.02;

/// How much larger the optical depth is at which a segment is cut off than for a plain light.
/// Where a light begins at a rim like the square of the depth, what lies behind the depth τ
/// is larger by the factor τ²/2, which is up to e^6 for tolerances down to 1e-6.
pub(crate) const DEEPER: f64 = 6.0;

/// The emission over a part without a rim inside.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pattern {
    ramp: Option<([f64; 3], bool)>,
    fading: Option<Fading>,
    /// Nodes more on each piece.
    pub(super) extra: usize,
}

/// `(1 − (d/range)²) (1 + (d/range)²)`, in metres.
#[derive(Debug, Clone, Copy)]
struct Fading {
    range: f64,
    h: f64,
    s: f64,
    /// The distance from the start of the part to where the ray leaves the range, and the
    /// distance to the start from where it enters the range.
    left: f64,
    gone: f64,
}

/// The emission over a piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct Profile {
    /// Of the position in the piece from 0 to 1.
    ramp: Option<([f64; 3], bool)>,
    fading: Option<Fading>,
}

impl Pattern {
    pub(super) fn new(emission: &Emission, part: &Part) -> Self {
        let Segment64 { s, h, .. } = part.segment;
        let ramp = emission.ramp().filter(|_| !part.is_full);
        let range = emission.fading_range();
        let fading = (range < f64::INFINITY).then(|| {
            let reach = ((range - h) * (range + h)).max(0.0).sqrt();
            Fading {
                range,
                h,
                s,
                left: reach - s,
                gone: reach + s,
            }
        });
        let for_ramp = ramp.map_or(0, |ramp| if ramp.squared { SPOT } else { COSINE });
        Self {
            ramp: ramp.map(|ramp| (ramp.quadratic, ramp.squared)),
            fading,
            extra: for_ramp + if fading.is_some() { FADING } else { 0 },
        }
    }

    /// Between two offsets of a side.
    pub(super) fn on(&self, side: &Side, start: f64, end: f64) -> Profile {
        let ramp = self.ramp.map(|([mut first, aside, mut last], squared)| {
            if side.kind == Kind::Thin {
                // tan(θ/2) = a/b
                std::mem::swap(&mut first, &mut last);
            }
            let (a, b) = (side.a, side.b(start));
            let change = side.unit * (end - start);
            let coefficients = [
                first * b * b + 2.0 * aside * a * b + last * a * a,
                2.0 * change * (first * b + aside * a),
                first * change * change,
            ];
            (coefficients, squared)
        });
        Profile {
            ramp,
            fading: self.fading,
        }
    }
}

impl Profile {
    /// At the share `f` of the piece, which is `way` from the start of the part,
    /// m, and with `a² + b²` there.
    pub(super) fn at(&self, f: f32, squares: f32, way: f32) -> f32 {
        let mut value = 1.0;
        if let Some(([constant, linear, square], squared)) = self.ramp {
            let f = f64::from(f);
            let ramp = (constant + f * (linear + f * square)).max(0.0) / f64::from(squares);
            value = if squared { ramp * ramp } else { ramp };
        }
        if let Some(fading) = self.fading {
            let way = f64::from(way);
            let s = fading.s + way;
            let per_square = 1.0 / (fading.range * fading.range);
            let inside = ((fading.left - way) * (fading.gone + way)).max(0.0) * per_square;
            let square = (s * s + fading.h * fading.h) * per_square;
            value *= inside * (1.0 + square);
        }
        value as f32
    }
}

//! Lights that are not equally bright in all directions.

mod parts;
#[cfg(test)]
mod tests;

pub(crate) use parts::Part;

use crate::{Error, Real, ScatteringAngle};

/// What a light emits towards the points of one ray, relative to its
/// intensity, and how far.
///
/// With `n` the axis of the light, `ω` the direction of the ray and `ĥ` the
/// unit vector from the light to the foot point (any that is normal to `ω` if
/// the ray meets the light),
///
/// ```text
/// cos θ_l = ((n·ω) s + (n·ĥ) h) / d
/// ```
///
/// is the cosine between the axis and the direction from the light to a point
/// of the ray: an emission is the same function of the angle of scattering for
/// all parts of a ray. It is kept in double precision, because the cosines of
/// narrow cones have few digits in single precision: 1 − cos is 3.8e-7 at half
/// an angle of 0.1°.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emission {
    pattern: Pattern,
    /// n·ω and n·ĥ.
    along: f64,
    across: f64,
    range: f64,
    fades: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Pattern {
    Isotropic,
    Cosine,
    /// Cosine at the rim, and one over how much larger it is where the
    /// emission is full.
    Spot {
        outer: f64,
        slope: f64,
    },
}

/// The least difference of the cosines of a spot, of the glTF extension
/// KHR_lights_punctual.
const LEAST_RIM: f64 = 0.001;

impl Default for Emission {
    fn default() -> Self {
        Self::isotropic()
    }
}

impl Emission {
    /// The same everywhere: 1.
    pub fn isotropic() -> Self {
        Self {
            pattern: Pattern::Isotropic,
            along: 0.0,
            across: 0.0,
            range: f64::INFINITY,
            fades: false,
        }
    }

    /// `max(0, cos θ_l)`: a small diffuse surface, with `along = n·ω` and
    /// `across = n·ĥ`.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless these are parts of a unit vector.
    pub fn cosine(along: f64, across: f64) -> Result<Self, Error> {
        let length = along.hypot(across);
        // A unit vector in single precision, with its rounding.
        if !(length <= 1.000_01) {
            return Err(Error::bad_value(
                "the length of an axis in the plane of the ray",
                length,
                "at most 1",
            ));
        }
        Ok(Self {
            pattern: Pattern::Cosine,
            along,
            across,
            ..Self::isotropic()
        })
    }

    /// `saturate((cos θ_l − cos o) / max(0.001, cos i − cos o))²`: a spot of
    /// glTF with inner and outer half-angles `i` and `o`, given as cosines.
    ///
    /// # Errors
    /// [`Error::BadValue`] as for [`Emission::cosine`], or unless
    /// -1 ≤ cos o ≤ cos i ≤ 1.
    pub fn spot(along: f64, across: f64, inner: f64, outer: f64) -> Result<Self, Error> {
        if !(-1.0..=1.0).contains(&inner) {
            let what = "the cosine of the inner cone of a spot";
            return Err(Error::bad_value(what, inner, "-1 to 1"));
        }
        if !(-1.0..=inner).contains(&outer) {
            let what = "the cosine of the outer cone of a spot";
            return Err(Error::bad_value(what, outer, "-1 to that of the inner one"));
        }
        let slope = 1.0 / (inner - outer).max(LEAST_RIM);
        Ok(Self {
            pattern: Pattern::Spot { outer, slope },
            ..Self::cosine(along, across)?
        })
    }

    /// The same light, which does not shine farther than `range`, m, and is
    /// undiminished up to there.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless the range is positive.
    pub fn within(self, range: f64) -> Result<Self, Error> {
        if range > 0.0 {
            Ok(Self { range, ..self })
        } else {
            let what = "the range of a light";
            Err(Error::bad_value(what, range, "a positive length"))
        }
    }

    /// The same light, which fades towards its `range`, m:
    /// `max(1 − (d / range)⁴, 0)`, the window that KHR_lights_punctual
    /// recommends. An infinite range fades nothing.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless the range is positive.
    pub fn fading_within(self, range: f64) -> Result<Self, Error> {
        let fades = range < f64::INFINITY;
        self.within(range).map(|light| Self { fades, ..light })
    }

    /// What is emitted towards the point of the ray at which light is
    /// scattered by `angle`, at the distance `d` from the light, m.
    ///
    /// Absolutely within some roundings of its precision over the width of a rim,
    /// `cos i − cos o`: next to the rim of a light it has no small relative
    /// error.
    pub fn factor<T: Real>(&self, angle: ScatteringAngle<T>, d: T) -> T {
        let (zero, one) = (T::from(0.0), T::from(1.0));
        let fading = if !(d <= T::of(self.range)) {
            return zero;
        } else if self.fades {
            let square = (d / T::of(self.range)) * (d / T::of(self.range));
            (one - square) * (one + square)
        } else {
            one
        };
        let level = match self.pattern {
            Pattern::Isotropic => one,
            Pattern::Cosine => self.above(0.0, angle),
            Pattern::Spot { outer, slope } => {
                let ramp = self.above(outer, angle) * T::of(slope);
                if ramp >= one {
                    one
                } else if ramp > zero {
                    ramp * ramp
                } else {
                    zero
                }
            }
        };
        if level > zero { level * fading } else { zero }
    }

    /// `cos θ_l − cosine`.
    fn above<T: Real>(&self, cosine: f64, angle: ScatteringAngle<T>) -> T {
        // s/d = −cos θ and h/d = sin θ.
        let [forward, aside, backward] = self.quadratic(cosine).map(|c| T::of(0.5 * c));
        forward * angle.one_minus_cos()
            + (aside + aside) * angle.sin()
            + backward * angle.one_plus_cos()
    }

    /// `[A, B, C]` with which `cos θ_l − cosine` is
    /// `(A b² + 2 B a b + C a²) / (a² + b²)` where `tan(θ/2) = b/a`.
    fn quadratic(&self, cosine: f64) -> [f64; 3] {
        [self.along - cosine, self.across, -(self.along + cosine)]
    }

    /// The range if the light fades towards it; else infinite.
    pub(crate) fn fading_range(&self) -> f64 {
        if self.fades {
            self.range
        } else {
            f64::INFINITY
        }
    }

    /// Between the rims of the light, where it is neither dark nor full: how the
    /// emission follows from a polynomial along the ray. None where it does not
    /// depend on the direction.
    pub(crate) fn ramp(&self) -> Option<Ramp> {
        let (cosine, slope, squared) = match self.pattern {
            Pattern::Isotropic => return None,
            Pattern::Cosine => (0.0, 1.0, false),
            Pattern::Spot { outer, slope } => (outer, slope, true),
        };
        let quadratic = self.quadratic(cosine).map(|c| slope * c);
        Some(Ramp { quadratic, squared })
    }
}

/// An emission that is `r`, or `r²` if `squared`, with
/// `r = (A b² + 2 B a b + C a²) / (a² + b²)` and `quadratic = [A, B, C]`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ramp {
    pub(crate) quadratic: [f64; 3],
    pub(crate) squared: bool,
}

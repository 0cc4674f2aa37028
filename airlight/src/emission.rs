//! Lights that are not equally bright in all directions.

use crate::{Error, Real, ScatteringAngle, Segment64};

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
/// all parts of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emission {
    pattern: Pattern,
    /// n·ω and n·ĥ.
    along: f32,
    across: f32,
    range: f32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Pattern {
    Isotropic,
    Cosine,
    /// Cosine at the rim, and one over how much larger it is where the
    /// emission is full.
    Spot {
        outer: f32,
        slope: f32,
    },
}

/// The least difference of the cosines of a spot, of the glTF extension
/// KHR_lights_punctual.
const LEAST_RIM: f32 = 0.001;

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
            range: f32::INFINITY,
        }
    }

    /// `max(0, cos θ_l)`: a small diffuse surface, with `along = n·ω` and
    /// `across = n·ĥ`.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless these are parts of a unit vector.
    pub fn cosine(along: f32, across: f32) -> Result<Self, Error> {
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
            range: f32::INFINITY,
        })
    }

    /// `saturate((cos θ_l − cos o) / max(0.001, cos i − cos o))²`: a spot of
    /// glTF with inner and outer half-angles `i` and `o`, given as cosines.
    ///
    /// # Errors
    /// [`Error::BadValue`] as for [`Emission::cosine`], or unless
    /// -1 ≤ cos o ≤ cos i ≤ 1.
    pub fn spot(along: f32, across: f32, inner: f32, outer: f32) -> Result<Self, Error> {
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

    /// The same light, which does not shine farther than `range`, m.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless the range is positive.
    pub fn within(self, range: f32) -> Result<Self, Error> {
        if range > 0.0 {
            Ok(Self { range, ..self })
        } else {
            let what = "the range of a light";
            Err(Error::bad_value(what, range, "a positive length"))
        }
    }

    /// What is emitted towards the point of the ray at which light is
    /// scattered by `angle`, if it is in range.
    pub fn factor<T: Real>(&self, angle: ScatteringAngle<T>) -> T {
        // s/d = −cos θ and h/d = sin θ.
        let cosine = || T::from(self.across) * angle.sin() - T::from(self.along) * angle.cos();
        let (zero, one) = (T::from(0.0), T::from(1.0));
        match self.pattern {
            Pattern::Isotropic => one,
            Pattern::Cosine => {
                let cosine = cosine();
                if cosine > zero { cosine } else { zero }
            }
            Pattern::Spot { outer, slope } => {
                let ramp = (cosine() - T::from(outer)) * T::from(slope);
                if ramp >= one {
                    one
                } else if ramp > zero {
                    ramp * ramp
                } else {
                    zero
                }
            }
        }
    }

    /// The parts of a segment that are lit and over which the emission is
    /// smooth, in order.
    pub fn parts(&self, segment: &Segment64) -> impl Iterator<Item = Segment64> {
        let emission = *self;
        let segment = *segment;
        let cuts = emission.cuts(&segment);
        cuts.into_iter()
            .zip(cuts.into_iter().skip(1))
            .filter(move |&(start, end)| emission.lights(start, end, segment.h))
            .map(move |(start, end)| Segment64 {
                x: segment.x + (start - segment.s),
                s: start,
                length: if start == segment.s && end == segment.s + segment.length {
                    segment.length
                } else {
                    end - start
                },
                ..segment
            })
    }

    /// Whether the middle of a part is lit, and with it all of it.
    fn lights(&self, start: f64, end: f64, h: f64) -> bool {
        let middle = if end == f64::INFINITY {
            start + start.abs() + h + 1.0
        } else {
            start + 0.5 * (end - start)
        };
        let range = f64::from(self.range);
        let lit = || self.factor(ScatteringAngle::from_foot(middle, h)) > 0.0;
        start < end && middle.hypot(h) <= range && lit()
    }

    /// Ends of smooth parts, rising: positions behind the foot point.
    fn cuts(&self, segment: &Segment64) -> [f64; 9] {
        let Segment64 { s, h, length, .. } = *segment;
        let end = s + length;
        // What does not apply is the end, too.
        let mut cuts = [end; 9];
        cuts[0] = s;
        // On a line through the light, the light.
        cuts[1] = if h == 0.0 { 0.0 } else { end };
        let range = f64::from(self.range);
        if range.is_finite() && range > h {
            let reach = ((range - h) * (range + h)).sqrt();
            (cuts[2], cuts[3]) = (-reach, reach);
        }
        match self.pattern {
            Pattern::Isotropic => {}
            Pattern::Cosine => [cuts[4], cuts[5]] = self.crossings(0.0, h, end),
            Pattern::Spot { outer, slope } => {
                let outer = f64::from(outer);
                let full = outer + 1.0 / f64::from(slope);
                [cuts[4], cuts[5]] = self.crossings(outer, h, end);
                [cuts[6], cuts[7]] = self.crossings(full, h, end);
            }
        }
        for cut in &mut cuts {
            // NaN from lengths that are none goes to the end.
            *cut = if *cut >= s && *cut <= end { *cut } else { end };
        }
        cuts.sort_by(f64::total_cmp);
        cuts
    }

    /// Where `cos θ_l` is `cosine`; `none` where it nowhere is.
    fn crossings(&self, cosine: f64, h: f64, none: f64) -> [f64; 2] {
        let (along, across) = (f64::from(self.along), f64::from(self.across));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Exact, Phase, PhaseFunction, Quadrature, Segment, stiff};

    /// Lights of all kinds, turned in all ways.
    fn lights() -> Vec<Emission> {
        let mut lights = Vec::new();
        for k in 0..8 {
            let turn = 0.8 * k as f32 + 0.1;
            let (across, along) = turn.sin_cos();
            let tilt = 1.0 - 0.1 * k as f32;
            let axis = (tilt * along, tilt * across);
            lights.push(Emission::cosine(axis.0, axis.1).unwrap());
            lights.push(Emission::spot(axis.0, axis.1, 0.9, 0.5).unwrap());
            lights.push(Emission::spot(along, across, 0.5, 0.5).unwrap());
            lights.push(Emission::spot(along, across, 1.0, -1.0).unwrap());
        }
        lights
    }

    /// The midpoint rule in the defining variable.
    fn sum(phase: PhaseFunction, sigma_t: f64, segment: &Segment64, emission: &Emission) -> f64 {
        let steps = 40_000;
        let step = segment.length / f64::from(steps);
        (0..steps)
            .map(|i| (f64::from(i) + 0.5) * step)
            .map(|x| {
                let s = segment.s + x;
                let d = s.hypot(segment.h);
                let angle = ScatteringAngle::from_cos(-s / d);
                let lit = f64::from(u8::from(d <= f64::from(emission.range)));
                let source = lit * phase.value_f64(angle) * emission.factor(angle);
                source * (-sigma_t * (segment.x + x + d)).exp() / (d * d) * step
            })
            .sum()
    }

    #[test]
    fn the_airlight_of_every_light_is_its_integral() {
        let phase = PhaseFunction::HenyeyGreenstein { g: 0.5 };
        let exact = Exact::new(phase).unwrap();
        let segment = Segment64 {
            x: 0.5,
            s: -2.0,
            h: 0.75,
            length: 5.0,
        };
        for light in lights() {
            for range in [f32::INFINITY, 1.5, 0.5] {
                let light = light.within(range).unwrap();
                let expected = sum(phase, 0.3, &segment, &light);
                let value = exact.estimate_of(0.3, &segment, &light).value;
                // The hard edges fall into one step of the sum.
                assert!(
                    (value - expected).abs() < 2e-4 * (1e-3 + expected),
                    "{light:?}: {value} {expected}"
                );
            }
        }
    }

    #[test]
    fn quadrature_keeps_its_tolerance_for_every_light() {
        for phase in [
            PhaseFunction::Isotropic,
            PhaseFunction::HenyeyGreenstein { g: 0.9 },
        ] {
            let exact = Exact::new(phase).unwrap();
            let quadrature = Quadrature::with_tolerance(phase, 1e-4).unwrap();
            let cases = stiff::cases(300);
            for light in lights() {
                for (sigma_t, segment) in &cases {
                    let truth = exact.estimate_of((*sigma_t).into(), &(*segment).into(), &light);
                    let bright = exact.airlight((*sigma_t).into(), &(*segment).into());
                    let value = quadrature.airlight_of(*sigma_t, segment, &light);
                    if bright > 1e-33 && bright < 1e38 {
                        // Relative to the light itself and to full emission:
                        // next to its rim a light has lost digits.
                        let allowed = 1e-4 * truth.value + 1e-6 * bright;
                        let error = (f64::from(value) - truth.value).abs();
                        assert!(
                            error < allowed,
                            "{light:?} {sigma_t} {segment:?}: {value} {truth:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn an_isotropic_light_is_one_part() {
        let exact = Exact::new(PhaseFunction::Rayleigh).unwrap();
        for (sigma_t, segment) in stiff::cases(200) {
            let segment = Segment64::from(segment);
            let light = Emission::isotropic();
            // One part per side of the light if the line meets it.
            assert!(light.parts(&segment).count() == 1 || segment.h == 0.0);
            let estimate = exact.estimate_of(sigma_t.into(), &segment, &light);
            assert_eq!(estimate, exact.estimate(sigma_t.into(), &segment));
        }
    }

    #[test]
    fn a_spot_that_covers_the_ray_is_isotropic_and_one_that_misses_it_dark() {
        let exact = Exact::new(PhaseFunction::Isotropic).unwrap();
        // Seen from the light the segment spans 45° either side of ĥ.
        let segment = Segment64 {
            x: 0.0,
            s: -1.0,
            h: 1.0,
            length: 2.0,
        };
        let full = Emission::spot(0.0, 1.0, 0.7, 0.6).unwrap();
        let bright = exact.estimate_of(0.2, &segment, &full).value;
        assert!((bright / exact.airlight(0.2, &segment) - 1.0).abs() < 1e-12);
        let away = Emission::spot(0.0, -1.0, 0.7, 0.6).unwrap();
        assert_eq!(exact.estimate_of(0.2, &segment, &away).value, 0.0);
        assert_eq!(away.parts(&segment).count(), 0);
    }

    #[test]
    fn a_range_ends_the_segment() {
        let exact = Exact::new(PhaseFunction::Isotropic).unwrap();
        let segment = Segment64 {
            x: 0.0,
            s: 0.0,
            h: 3.0,
            length: f64::INFINITY,
        };
        let light = Emission::isotropic().within(5.0).unwrap();
        let short = Segment64 {
            length: 4.0,
            ..segment
        };
        let value = exact.estimate_of(0.2, &segment, &light).value;
        assert!((value / exact.airlight(0.2, &short) - 1.0).abs() < 1e-12);
        let dark = Emission::isotropic().within(3.0).unwrap();
        assert_eq!(dark.parts(&segment).count(), 0);
    }

    #[test]
    fn on_a_line_through_the_light_each_side_counts_by_itself() {
        let exact = Exact::new(PhaseFunction::Isotropic).unwrap();
        let quadrature = Quadrature::fixed(PhaseFunction::Isotropic, 8).unwrap();
        // Shines along the ray: only what is behind the light is lit.
        let light = Emission::cosine(1.0, 0.0).unwrap();
        let front = Segment {
            x: 0.0,
            s: -2.0,
            h: 0.0,
            length: 1.5,
        };
        let through = Segment {
            length: 4.0,
            ..front
        };
        assert_eq!(exact.estimate_of(0.2, &front.into(), &light).value, 0.0);
        assert_eq!(quadrature.airlight_of(0.2, &front, &light), 0.0);
        assert_eq!(
            exact.estimate_of(0.2, &through.into(), &light).value,
            f64::INFINITY
        );
        assert_eq!(quadrature.airlight_of(0.2, &through, &light), f32::INFINITY);
    }

    #[test]
    fn bad_lights_are_named() {
        assert!(Emission::cosine(1.0, 1.0).is_err());
        assert!(Emission::cosine(f32::NAN, 0.0).is_err());
        assert!(Emission::spot(1.0, 0.0, 0.5, 0.6).is_err());
        assert!(Emission::spot(1.0, 0.0, 2.0, 0.6).is_err());
        assert!(Emission::spot(1.0, 0.0, f32::NAN, 0.6).is_err());
        for range in [0.0, -1.0, f32::NAN] {
            assert!(Emission::isotropic().within(range).is_err());
        }
    }
}

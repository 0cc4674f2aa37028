//! The airlight of parallel light: in closed form, and for marches by the midpoint rule.

use glam::Vec3;
use wide::{CmpEq, CmpLt};

use crate::path::{LANES, Lanes};
use crate::scene::{DirectionalEmitter, Medium};
use crate::{Interval, LightPath};

/// The airlight of a directional light over `interval`, in closed form and exact to rounding.
///
/// The optical path `(x − x_entry) + l(x)` is piecewise linear in `x`. So the interval is split
/// at the [kinks](LightPath::kinks), and the light of each part is the integral of one
/// exponential. In a bounded medium `l` is a difference of f32 coordinates: the relative error
/// is about their rounding times σ_t.
pub fn directional(path: &LightPath<'_>, sun: &DirectionalEmitter, interval: Interval) -> Vec3 {
    if !(interval.start < interval.end) {
        return Vec3::ZERO;
    }
    let medium = path.medium();
    let light = medium.sigma_s() * (sun.irradiance() * medium.phase().value(path.sun_angle(sun)));
    let sigma_t = medium.sigma_t();
    let piece = |start: f32, end: f32| {
        // The optical length over σ_t is linear between the two ends. It may decrease where the
        // sun is behind the eye; so the exponential is taken of the smaller end.
        let at = |x: f32| (x - path.entry()) + path.sun_leg(sun, x);
        let first = at(start);
        sigma_t.map(|sigma| {
            if end.is_finite() {
                let last = at(end);
                let least = (-sigma * first.min(last)).exp();
                least * mean_exponential(sigma * (last - first).abs()) * (end - start)
            } else if sigma > 0.0 {
                (-sigma * first).exp() / sigma
            } else {
                // A channel without extinction and an infinite length: it does not scatter
                // either.
                0.0
            }
        })
    };

    light
        * path
            .without_kinks(interval)
            .fold(Vec3::ZERO, |sum, part| sum + piece(part.start, part.end))
}

/// Appends the airlight of parts of paths that all have this light, eight at a time: that of
/// [`directional`] to 2e-6, and 0 beyond optical lengths of 87. A result does not depend on the
/// other parts.
pub(super) fn directionals(
    sun: &DirectionalEmitter,
    paths: &[LightPath<'_>],
    parts: &[(usize, Interval)],
    radiances: &mut Vec<Vec3>,
) {
    let pieces = Pieces::new(sun, paths, parts, |path, interval| {
        path.without_kinks(interval).map(move |part| {
            let at = |x: f32| (x - path.entry()) + path.sun_leg(sun, x);
            let ends = [part.start, part.end];
            let [from, to] = ends.map(|x| if x.is_finite() { at(x) } else { f32::INFINITY });
            [from, to, part.end - part.start]
        })
    });
    pieces.append(radiances, |sigma, [from, to, length]| {
        let endless = length.cmp_eq(f32::INFINITY);
        let (least, across) = (from.fast_min(to), (to - from).abs());
        let through = (-sigma * least).exp();
        // A channel without extinction does not scatter either.
        let rest = if sigma > 0.0 { 1.0 / sigma } else { 0.0 };
        let depth = endless.blend(Lanes::ZERO, sigma * across);
        through * endless.blend(rest.into(), mean_exponentials(depth) * length)
    });
}

/// Appends the airlight of the same parts by the midpoint rule, that of
/// [`Midpoint`](super::Midpoint) to 2e-6, and 0 beyond optical lengths of 87: the light in the
/// middle of a part times its length. A part that is longer than `longest`, in metres, ends there.
pub(super) fn midpoints(
    sun: &DirectionalEmitter,
    paths: &[LightPath<'_>],
    parts: &[(usize, Interval)],
    longest: f32,
    radiances: &mut Vec<Vec3>,
) {
    let pieces = Pieces::new(sun, paths, parts, |path, interval| {
        let length = interval.end.min(interval.start + longest) - interval.start;
        let x = interval.start + 0.5 * length;
        (length > 0.0).then(|| [(x - path.entry()) + path.sun_leg(sun, x), length])
    });
    pieces.append(radiances, |sigma, [way, length]| {
        (-sigma * way).exp() * length
    });
}

/// Pieces of parts of paths that all have the light of one sun. Each has `N` numbers, of which
/// [`Pieces::append`] is told the integral.
struct Pieces<'a, const N: usize> {
    sun: &'a DirectionalEmitter,
    medium: Option<&'a Medium>,
    parts: usize,
    /// The numbers of a piece with that of its part and the value of the phase function.
    pieces: Vec<(usize, f32, [f32; N])>,
}

impl<'a, const N: usize> Pieces<'a, N> {
    /// The pieces into which `divide` cuts each part that is not empty.
    fn new<'s, P: IntoIterator<Item = [f32; N]>>(
        sun: &'a DirectionalEmitter,
        paths: &'s [LightPath<'a>],
        parts: &[(usize, Interval)],
        divide: impl Fn(&'s LightPath<'a>, Interval) -> P,
    ) -> Self {
        let mut pieces = Vec::with_capacity(parts.len());
        // Parts of one path mostly follow each other.
        let mut last = (usize::MAX, 0.0);
        for (number, (index, interval)) in parts.iter().enumerate() {
            let path = &paths[*index];
            if !(interval.start < interval.end) {
                continue;
            }
            if last.0 != *index {
                last = (*index, path.medium().phase().value(path.sun_angle(sun)));
            }
            let phase = last.1;
            let of_part = divide(path, *interval).into_iter();
            pieces.extend(of_part.map(|piece| (number, phase, piece)));
        }
        Self {
            sun,
            medium: paths.first().map(LightPath::medium),
            parts: parts.len(),
            pieces,
        }
    }

    /// Appends the light of each part: of its pieces, the sum of σ_s p E times the integral of
    /// the transmittance, which `integral` gives for an extinction.
    fn append(&self, radiances: &mut Vec<Vec3>, integral: impl Fn(f32, [Lanes; N]) -> Lanes) {
        let first = radiances.len();
        radiances.resize(first + self.parts, Vec3::ZERO);
        let Some(medium) = self.medium else {
            return;
        };
        let sigma_t = medium.sigma_t().to_array();
        let scattered = (medium.sigma_s() * self.sun.irradiance()).to_array();
        for pieces in self.pieces.chunks(LANES) {
            let piece = |i: usize| pieces.get(i).unwrap_or(&pieces[0]);
            let phase = Lanes::new(std::array::from_fn(|i| piece(i).1));
            let columns =
                std::array::from_fn(|k| Lanes::new(std::array::from_fn(|i| piece(i).2[k])));
            let mut through = Lanes::ZERO;
            for channel in 0..3 {
                // Grey media are common, and exponentials are most of the work.
                if channel == 0 || sigma_t[channel] != sigma_t[channel - 1] {
                    through = integral(sigma_t[channel], columns);
                }
                let lights = (phase * scattered[channel]) * through;
                for ((number, ..), light) in pieces.iter().zip(lights.to_array()) {
                    radiances[first + number][channel] += light;
                }
            }
        }
    }
}

/// [`mean_exponential`] of eight numbers, with a relative error of 6e-7.
fn mean_exponentials(x: Lanes) -> Lanes {
    // The power series up to x⁷/8!: the next term is 1.1e-8 of the sum at ½.
    let z = 1.0 / 720.0 - x * (1.0 / 5040.0 - x * (1.0 / 40_320.0));
    let z = 1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x * z));
    let series = 1.0 - x * (0.5 - x * z);
    let quotient = (1.0 - (-x).exp()) / x;
    x.cmp_lt(0.5).blend(series, quotient)
}

/// The mean of `exp(−y)` for `y` from 0 to `x ≥ 0`: `(1 − exp(−x)) / x`
/// without cancellation.
pub(crate) fn mean_exponential(x: f32) -> f32 {
    if x < 1e-6 {
        1.0 - 0.5 * x
    } else {
        -(-x).exp_m1() / x
    }
}

#[cfg(test)]
mod tests {
    use reference::random::noise;

    use super::*;
    use crate::scene::{Bounds, PhaseFunction};
    use crate::{Emitter, Ray};

    fn sun(direction: Vec3) -> Emitter {
        Emitter::directional(direction, Vec3::splat(3.0)).unwrap()
    }

    fn evaluate(path: &LightPath<'_>, interval: Interval) -> Vec3 {
        match path.emitter() {
            Emitter::Directional(sun) => directional(path, sun, interval),
            Emitter::Point(_) => unreachable!("these tests have suns only"),
        }
    }

    #[test]
    fn means_of_exponentials_keep_their_accuracy_in_lanes() {
        for i in 0..4000 {
            let x = 1e-9 * (0.0065 * i as f32).exp();
            let exact = f64::from(x);
            let expected = -(-exact).exp_m1() / exact;
            for found in [
                mean_exponentials(x.into()).to_array()[3],
                mean_exponential(x),
            ] {
                let error = (f64::from(found) / expected - 1.0).abs();
                assert!(error < 6e-7, "{x}: {found} {expected}");
            }
        }
        assert_eq!(mean_exponentials(Lanes::ZERO).to_array(), [1.0; LANES]);
    }

    #[test]
    fn in_the_open_it_is_one_exponential() {
        let medium = Medium::new(
            Vec3::new(0.1, 0.2, 1e-7),
            Vec3::new(0.05, 0.0, 0.0),
            PhaseFunction::Isotropic,
        )
        .unwrap();
        let ray = Ray::new(Vec3::ZERO, Vec3::X, f32::INFINITY).unwrap();
        let sun = sun(Vec3::NEG_Y);
        let path = LightPath::new(&ray, &sun, &medium).unwrap();
        let value = evaluate(&path, Interval::new(2.0, 5.0));
        let p = 3.0 / (4.0 * std::f64::consts::PI);
        let expected = |s: f64, t: f64| p * s / t * ((-2.0 * t).exp() - (-5.0 * t).exp());
        assert!((f64::from(value.x) / expected(0.1, 0.15) - 1.0).abs() < 1e-6);
        assert!((f64::from(value.y) / expected(0.2, 0.2) - 1.0).abs() < 1e-6);
        assert!((f64::from(value.z) / (p * 3e-7) - 1.0).abs() < 1e-5);
        let whole = evaluate(&path, path.span());
        assert!((f64::from(whole.y) / p - 1.0).abs() < 1e-6, "albedo 1 in y");
    }

    #[test]
    fn a_deep_box_with_the_sun_behind_is_finite_and_bright_near_the_sun() {
        let bounds = Bounds::new(Vec3::splat(-50.0), Vec3::splat(50.0)).unwrap();
        let medium = Medium::new(Vec3::splat(10.0), Vec3::ZERO, PhaseFunction::Isotropic)
            .unwrap()
            .within(bounds);
        // Towards the sun, from a box of optical depth 1000.
        let ray = Ray::new(Vec3::ZERO, Vec3::X, f32::INFINITY).unwrap();
        for direction in [Vec3::NEG_X, Vec3::X, Vec3::new(-1.0, -0.3, 0.2)] {
            let sun = sun(direction);
            let path = LightPath::new(&ray, &sun, &medium).unwrap();
            let value = evaluate(&path, path.span());
            assert!(value.is_finite() && value.min_element() >= 0.0, "{value}");
        }
        // From outside, with the sun behind the eye: σ_s / 2σ_t of it.
        let ray = Ray::new(Vec3::X * -60.0, Vec3::X, f32::INFINITY).unwrap();
        let sun = sun(Vec3::X);
        let path = LightPath::new(&ray, &sun, &medium).unwrap();
        let expected = 3.0 / (8.0 * std::f32::consts::PI);
        assert!((evaluate(&path, path.span()).x / expected - 1.0).abs() < 1e-5);
    }

    #[test]
    fn in_a_box_it_matches_a_fine_sum_and_is_additive() {
        let bounds = Bounds::new(Vec3::ZERO, Vec3::new(3.0, 2.0, 1.0)).unwrap();
        let medium = Medium::new(Vec3::ONE, Vec3::splat(0.5), PhaseFunction::Isotropic)
            .unwrap()
            .within(bounds);
        for k in 0..40_u32 {
            let unit = |i: u32| noise(u64::from(k * 12 + i));
            let origin = Vec3::new(4.0 * unit(0) - 0.5, 3.0 * unit(1) - 0.5, -1.0);
            let target = Vec3::new(3.0 * unit(2), 2.0 * unit(3), 0.9 * unit(4) + 0.05);
            let sun = sun(Vec3::new(unit(5) - 0.5, unit(6) - 0.5, unit(7) - 0.5));
            let ray = Ray::new(origin, target - origin, 50.0).unwrap();
            let Some(path) = LightPath::new(&ray, &sun, &medium) else {
                continue;
            };
            let span = path.span();
            let value = evaluate(&path, span);
            let steps = 20_000;
            let width = f64::from(span.length()) / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|i| f64::from(span.start) + (f64::from(i) + 0.5) * width)
                .map(|x| f64::from(path.source(x as f32).x) * width)
                .sum();
            assert!(
                (f64::from(value.x) / sum - 1.0).abs() < 1e-4,
                "{k}: {value} {sum}"
            );
            let middle = span.start + 0.3 * span.length();
            let parts = evaluate(&path, Interval::new(span.start, middle))
                + evaluate(&path, Interval::new(middle, span.end));
            assert!((parts.x / value.x - 1.0).abs() < 1e-5, "{k}");
        }
    }

    #[test]
    fn sunlight_along_the_faces_of_a_box_and_corners_keep_their_accuracy() {
        let bounds = Bounds::new(Vec3::new(-3.0, -1.0, -8.0), Vec3::new(4.0, 3.0, 1.0)).unwrap();
        let medium = Medium::new(Vec3::splat(0.3), Vec3::splat(0.1), PhaseFunction::Isotropic)
            .unwrap()
            .within(bounds);
        let suns = [
            Vec3::NEG_Y,
            Vec3::new(0.3, -1.0, 0.2),
            Vec3::new(0.0, -1.0, 0.2),
        ];
        for k in 0..3000_u32 {
            let unit = |i: u32| noise(u64::from(k * 12 + i));
            let origin = 10.0 * Vec3::new(unit(0) - 0.5, unit(1) - 0.5, unit(2) - 0.5);
            let direction = Vec3::new(unit(3) - 0.5, unit(4) - 0.5, unit(5) - 0.5);
            let sun = sun(suns[k as usize % 3]);
            let ray = Ray::new(origin, direction, 50.0).unwrap();
            let Some(path) = LightPath::new(&ray, &sun, &medium) else {
                continue;
            };
            let span = path.span();
            let value = evaluate(&path, span);
            let steps = 500;
            let width = f64::from(span.length()) / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|i| f64::from(span.start) + (f64::from(i) + 0.5) * width)
                .map(|x| f64::from(path.source(x as f32).x) * width)
                .sum();
            assert!(
                (f64::from(value.x) / sum - 1.0).abs() < 1e-3,
                "{k}: {value} {sum} {ray:?}"
            );
        }
    }
}

//! The airlight of a spotlight with a cookie: texel by texel.
//!
//! The ray is seen in the cookie at column and row
//!
//! ```text
//! (c₀ + c₁ s) / (z₀ + z₁ s)
//! ```
//!
//! with s the distance behind the foot point, so the image of the ray in the cookie is a
//! straight line. Between the lines through the centres of texels the cookie is bilinear, and
//! the integrand is smooth between two crossings of these lines. Crossings are roots of linear
//! equations and come in order along either axis. On each piece between them the variable is
//! the position t along the chord between the unit vectors to its ends. Column and row are
//! quotients of linear functions of t too, and
//!
//! ```text
//! ds / d² = (s_b − s_a) / (d_a d_b) · dt / |q|²,    q = (1−t) p_a/d_a + t p_b/d_b
//! ```
//!
//! needs no trigonometry. A piece ends earlier where something else changes too much for a few
//! nodes: the distance from the light, the optical depth, the angle next to a peak of the phase
//! function, or the tilt against the cookie.
//!
//! A ray that crosses more than [`MOST_COOKIE_LINES`](crate::scene::MOST_COOKIE_LINES) of those
//! lines, over all intervals together, is evaluated in coarser levels of the cookie, so that no
//! ray has more than three times as many pieces. The number of lines decides, and its rounding
//! does not matter: the share of the coarser level grows continuously with it.

use airlight::{Phase, PhaseFunction, ScatteringAngle};
use glam::{BVec3, DVec3, Vec3};

use super::lamp::Lamp;
use crate::scene::{SpotEmission, Texture};
use crate::{Interval, LightPath};

/// Light behind this optical depth does not count beside the light in front of it.
const OPAQUE: f64 = 30.0;
/// At this optical depth the transmittance is 0 in an `f32`.
const DARK: f64 = 104.0;
/// Where the distance from the light has grown by this factor, the remaining light is lost in
/// rounding.
const FAR: f64 = 1e8;
/// Limits on the length of a piece: the distance from the light changes at most by this share
/// of itself.
const DISTANCE: f64 = 0.5;
/// The optical depth changes at most by this.
const DEPTH: f64 = 1.5;
/// The angle of scattering changes at most by this, in units of the width of a peak plus the
/// angle to it.
const PEAK: f64 = 0.5;
/// The cosine to the axis of the cookie changes at most by this share of itself.
const TILT: f64 = 0.3;
/// The share of the tolerance that the estimated error of a piece may take. Tuned on cookies of
/// noise in cones of 2° to 86°.
const SHARE: f64 = 0.1;

/// The radiance of an interval that has no kink inside, apart from those of the cookie.
pub(super) fn radiance(
    rule: &airlight::Quadrature<PhaseFunction>,
    path: &LightPath<'_>,
    lamp: &Lamp<'_>,
    interval: Interval,
) -> Vec3 {
    if !(interval.start < interval.end) {
        return Vec3::ZERO;
    }
    if path.meets_light(interval) {
        return Vec3::INFINITY;
    }
    let Some((spot, cookie)) = lamp.cookie() else {
        return Vec3::ZERO;
    };
    let all = Walk::new(rule, path, lamp, (spot, cookie));
    let (level, share) = match spot.mip_levels() {
        [] => (0, 0.0),
        _ => spot.mip(all.lines(path.span())),
    };
    let sum = |level: usize| match level.checked_sub(1) {
        None => all.sum(interval),
        Some(level) => {
            let level = &spot.mip_levels()[level];
            Walk::new(rule, path, lamp, (spot, level)).sum(interval)
        }
    };
    if share > 0.0 {
        sum(level).lerp(sum(level + 1), share as f32)
    } else {
        sum(level)
    }
}

struct Walk<'a> {
    rule: &'a airlight::Quadrature<PhaseFunction>,
    path: &'a LightPath<'a>,
    lamp: &'a Lamp<'a>,
    texture: &'a Texture,
    /// Numerators of column and row, and their common denominator, which is the distance along
    /// the axis. Each has its value at the foot point and its slope per metre behind it.
    column: [f64; 2],
    row: [f64; 2],
    front: [f64; 2],
    h: f64,
    sigma_t: Vec3,
    is_grey: bool,
    is_immersed: bool,
    /// Widths of the forward and the backward peak of the phase function, as angles.
    peaks: [f64; 2],
    /// The reciprocal of the change of the cosine over the rim of the cone.
    slope: f64,
}

/// An end of a piece.
#[derive(Clone, Copy)]
struct End {
    s: f64,
    d: f64,
    /// The square root of the emission relative to its maximum, 0 to 1.
    ramp: f64,
}

impl<'a> Walk<'a> {
    fn new(
        rule: &'a airlight::Quadrature<PhaseFunction>,
        path: &'a LightPath<'a>,
        lamp: &'a Lamp<'a>,
        (spot, texture): (&SpotEmission, &'a Texture),
    ) -> Self {
        let rotation = spot.rotation().as_dquat().normalize();
        let back = rotation.inverse();
        let (foot, along) = (back * lamp.to_foot * lamp.h, back * lamp.direction);
        let tan = f64::from(spot.tan_outer());
        let [width, height] = [texture.width(), texture.height()].map(f64::from);
        let front = [-foot.z, -along.z];
        let axis = |size: f64, side: [f64; 2]| {
            [0, 1].map(|i| 0.5 * ((size - 1.0) * front[i] + size / tan * side[i]))
        };
        let sigma_t = path.medium().sigma_t();
        Self {
            rule,
            path,
            lamp,
            texture,
            column: axis(width, [foot.x, along.x]),
            row: axis(height, [-foot.y, -along.y]),
            front,
            h: lamp.h,
            sigma_t,
            is_grey: sigma_t == Vec3::splat(sigma_t.x),
            is_immersed: path.is_immersed(),
            peaks: rule.phase().peaks().map(|tangent| 2.0 * tangent),
            slope: 1.0 / f64::from(spot.rim()),
        }
    }

    /// Both ends relative to the foot point, cut off where no light is left. An end behind the
    /// apex of the cone, where rounding may put it on rays that all but meet the light, moves to
    /// the plane through the apex: nothing shines there, and nothing can be seen in the cookie.
    fn ends(&self, interval: Interval) -> [f64; 2] {
        let [start, end] = [interval.start, interval.end].map(|x| f64::from(x) - self.lamp.foot);
        let end = end.min(start + FAR * start.hypot(self.h));
        let [at_foot, slope] = self.front;
        let apex = -at_foot / slope;
        if slope > 0.0 {
            [start.max(apex), end]
        } else if slope < 0.0 {
            [start, end.min(apex)]
        } else if at_foot > 0.0 {
            [start, end]
        } else {
            [end; 2]
        }
    }

    /// How many lines through the centres of texels an interval crosses, with fractions.
    fn lines(&self, interval: Interval) -> f64 {
        let [from, to] = self.ends(interval);
        let crossed = |at: [f64; 2], size: u32| {
            let last = f64::from(size - 1);
            let place = |s| place(at, self.front, s, last).clamp(0.0, last);
            (place(to) - place(from)).abs()
        };
        crossed(self.column, self.texture.width()) + crossed(self.row, self.texture.height())
    }

    fn sum(&self, interval: Interval) -> Vec3 {
        let [start, end] = self.ends(interval);
        let mut from = self.end(start);
        let first = from;
        let mut columns = Lines::new(self.column, self.front, [start, end], self.texture.width());
        let mut rows = Lines::new(self.row, self.front, [start, end], self.texture.height());
        let mut total = Vec3::ZERO;
        while from.s < end {
            // Optical depth per metre, in the channels that are not used up yet.
            let used = self.used_up(&first, &from);
            if used.all() {
                break;
            }
            let sigma = DVec3::select(used, DVec3::ZERO, self.sigma_t.as_dvec3());
            let sigma = sigma.max_element();
            let next = from.s + self.step(&from, sigma);
            let crossing = columns.position.min(rows.position);
            let to = self.end(next.min(crossing).min(end));
            if columns.position <= to.s {
                columns.advance();
            }
            if rows.position <= to.s {
                rows.advance();
            }
            if from.s < to.s {
                total += self.piece(&from, &to, sigma);
                from = to;
            }
        }
        total
    }

    /// The channels that are too dark to count from here on.
    fn used_up(&self, first: &End, here: &End) -> BVec3 {
        let sigma = self.sigma_t.as_dvec3();
        let x = here.s + self.lamp.foot - f64::from(self.path.entry());
        if !self.is_immersed {
            return (sigma * x).cmpge(DVec3::splat(DARK));
        }
        // The distance travelled by this position, along the ray and from the light, never
        // decreases.
        let way = (here.s - first.s) + (here.d - first.d);
        (sigma * way).cmpge(DVec3::splat(OPAQUE)) | (sigma * (x + here.d)).cmpge(DVec3::splat(DARK))
    }

    fn end(&self, s: f64) -> End {
        let d = s.hypot(self.h);
        let angle = ScatteringAngle::from_foot(s, self.h);
        End {
            s,
            d,
            ramp: self.lamp.emission.factor(angle, d).sqrt(),
        }
    }

    /// The longest piece that may start here.
    fn step(&self, from: &End, sigma: f64) -> f64 {
        let End { s, d, .. } = *from;
        let aside = self.h / d;
        let per_angle = d / aside;
        let tilt = (self.front[1] / self.front_at(s) - s / (d * d)).abs();
        (DISTANCE * d)
            .min(DEPTH / (2.0 * sigma))
            .min(PEAK * (self.peak(s) + aside) * per_angle)
            .min(TILT / tilt)
            // At least a step that rounding does not swallow, so that the walk ends.
            .max(1e-9 * d)
    }

    fn front_at(&self, s: f64) -> f64 {
        (self.front[0] + self.front[1] * s).max(f64::MIN_POSITIVE)
    }

    /// The width of the phase function's peak on this side of the foot point.
    fn peak(&self, s: f64) -> f64 {
        self.peaks[usize::from(s >= 0.0)]
    }

    /// The number of Gauss nodes that a piece needs.
    fn nodes(&self, from: &End, to: &End, sigma: f64) -> usize {
        let tolerance = SHARE * f64::from(self.rule.tolerance());
        let ratio = (to.d / from.d).max(from.d / to.d);
        let depth = sigma * ((to.s - from.s) + (to.d - from.d).abs()) * ratio;
        let angle = (to.s - from.s) * self.h / (from.d * to.d);
        let tilt = (self.front_at(to.s) * from.d) / (self.front_at(from.s) * to.d);
        let tilt = tilt.max(1.0 / tilt) - 1.0;
        let peak = self.peak(from.s).min(self.peak(to.s)) + self.h / from.d.max(to.d);
        // The factors that are the inverse square or cube of a linear function.
        let power = tilt.max(angle * (0.8 / peak).max(0.4));
        // The square of the ramp times the cookie, relative to its maximum: by how much it
        // changes over the piece, and how much of that is curvature.
        let (low, high) = (from.ramp.min(to.ramp), from.ramp.max(to.ramp));
        let (ramp, curved) = if low == 1.0 {
            (0.0, 0.0)
        } else {
            let curved = 0.25 * self.slope * angle * angle;
            let most = high.max(0.5 * (low + high + curved));
            ((high - low + curved) / most, curved / most)
        };
        let [fading, fading_curved] = self.fading(from, to);
        let ramp = ramp + fading;
        // The derivatives of the integrand over the constants in the errors of Gauss rules:
        // (2n)! (2n+1)! / (n!)⁴.
        let [depth2, power2, ramp2, curved2] = [depth, power, ramp, curved].map(|x| x * x);
        // For two nodes: the cookie is quadratic along the piece, and every curved factor adds
        // to it.
        let bent = angle * angle + 3.0 * power2 + 0.5 * depth2 + fading_curved;
        let two = depth2.powi(2) / 4320.0 + power2.powi(2) / 36.0 + (3.0 * ramp2 + bent) / 180.0;
        let three = bent * bent / 2800.0
            + depth2.powi(3) / 2.0e6
            + power2.powi(3) / 400.0
            + (curved2 + 0.5 * ramp2 * power2) / 100.0;
        // For four: a ramp or its curvature counts times a power of the factor that curves most.
        let four = bent.powi(3) / 44100.0
            + depth2.powi(4) / 1.8e9
            + power2.powi(4) / 4900.0
            + (curved2 * (angle * angle).powi(2) + 0.5 * ramp2 * power2.powi(2)) / 1000.0;
        if four > tolerance {
            6
        } else if three > tolerance {
            4
        } else if two > tolerance {
            3
        } else {
            2
        }
    }

    /// By how much the window of a fading light changes over a piece, and how much of that is
    /// curvature.
    fn fading(&self, from: &End, to: &End) -> [f64; 2] {
        if !self.lamp.point.fades() {
            return [0.0; 2];
        }
        let range = f64::from(self.lamp.point.range());
        // (1 − (d/range)⁴) is a polynomial in s² + h².
        let [a, b] = [from.d, to.d].map(|d| (1.0 - (d / range).powi(4)).max(0.0));
        let most = a.max(b).max(f64::MIN_POSITIVE);
        let (length, d) = ((to.s - from.s) / range, from.d.max(to.d) / range);
        let curved = 6.0 * length * length * d * d / most;
        [(a - b).abs() / most + curved, curved]
    }

    fn piece(&self, from: &End, to: &End, sigma: f64) -> Vec3 {
        let medium = self.path.medium();
        let blend = Bilinear::new(self, 0.5 * (from.s + to.s));
        let [far_a, far_b] = [1.0 / from.d, 1.0 / to.d];
        let chord = (to.s - from.s) * far_a * far_b;
        let is_full = from.ramp == 1.0 && to.ramp == 1.0;
        let mut sum = Vec3::ZERO;
        for &(t, weight) in self.rule.rule(self.nodes(from, to, sigma)) {
            let t = f64::from(t);
            let (a, b) = ((1.0 - t) * far_a, t * far_b);
            let s = (a * from.s + b * to.s) / (a + b);
            let d = (s * s + self.h * self.h).sqrt();
            let q = d * (a + b);
            let angle = ScatteringAngle::from_foot(s as f32, self.h as f32);
            let emitted = if is_full {
                1.0
            } else {
                self.lamp
                    .emission
                    .factor(ScatteringAngle::from_foot(s, self.h), d)
            };
            let share = (f64::from(weight) * emitted / (q * q)) as f32;
            let x = s + self.lamp.foot;
            let leg = if self.is_immersed {
                d
            } else {
                let (direction, d) = self.path.from_light(s as f32);
                f64::from(medium.length_inside(self.path.ray().at(x as f32), -direction, d))
            };
            let length = (x - f64::from(self.path.entry()) + leg) as f32;
            let transmittance = if self.is_grey {
                Vec3::splat((-self.sigma_t.x * length).exp())
            } else {
                (-self.sigma_t * length).exp()
            };
            sum += blend.at(self, s) * transmittance * (share * medium.phase().value(angle));
        }
        medium.sigma_s() * self.lamp.point.intensity() * sum * chord as f32
    }
}

/// The column or row in which the ray is seen at a position.
fn place(at: [f64; 2], front: [f64; 2], s: f64, last: f64) -> f64 {
    let place = (at[0] + at[1] * s) / (front[0] + front[1] * s);
    // At the apex of the cone the direction is undefined.
    if place.is_nan() { 0.5 * last } else { place }
}

/// The cookie between the centres of four texels.
struct Bilinear {
    left: f64,
    top: f64,
    /// The coefficients of 1, of x (to the right), of y (down), and of x y.
    terms: [Vec3; 4],
}

impl Bilinear {
    /// The cell in which the ray is seen at a position.
    fn new(walk: &Walk<'_>, s: f64) -> Self {
        let per_front = 1.0 / walk.front_at(s);
        let [(left, right), (top, bottom)] = [
            (walk.column, walk.texture.width()),
            (walk.row, walk.texture.height()),
        ]
        .map(|([at, change], size)| {
            let last = f64::from(size - 1);
            let low = ((at + change * s) * per_front).floor();
            (low.clamp(0.0, last), (low + 1.0).clamp(0.0, last))
        });
        let width = walk.texture.width() as usize;
        let texel =
            |column: f64, row: f64| walk.texture.texels()[row as usize * width + column as usize];
        let (a, b) = (texel(left, top), texel(right, top));
        let (c, d) = (texel(left, bottom), texel(right, bottom));
        Self {
            left,
            top,
            terms: [a, b - a, c - a, (d - c) - (b - a)],
        }
    }

    fn at(&self, walk: &Walk<'_>, s: f64) -> Vec3 {
        let per_front = 1.0 / walk.front_at(s);
        let right = ((walk.column[0] + walk.column[1] * s) * per_front - self.left) as f32;
        let down = ((walk.row[0] + walk.row[1] * s) * per_front - self.top) as f32;
        let [constant, across, along, both] = self.terms;
        constant + across * right + (along + both * right) * down
    }
}

/// The lines through the centres of texels along one axis that a ray crosses, in their order on
/// the ray.
struct Lines {
    at: [f64; 2],
    front: [f64; 2],
    number: f64,
    step: f64,
    left: u32,
    /// Position of the next crossing; infinite if there is none.
    position: f64,
}

impl Lines {
    fn new(at: [f64; 2], front: [f64; 2], ends: [f64; 2], texels: u32) -> Self {
        let last = f64::from(texels - 1);
        let [from, to] = ends.map(|s| place(at, front, s, last));
        let (number, until, step) = if from <= to {
            (
                (from.floor() + 1.0).max(0.0),
                (to.ceil() - 1.0).min(last),
                1.0,
            )
        } else {
            (
                (from.ceil() - 1.0).min(last),
                (to.floor() + 1.0).max(0.0),
                -1.0,
            )
        };
        let mut lines = Self {
            at,
            front,
            number,
            step,
            left: (step * (until - number) + 1.0).max(0.0) as u32,
            position: 0.0,
        };
        lines.find();
        lines
    }

    fn advance(&mut self) {
        self.number += self.step;
        self.left -= 1;
        self.find();
    }

    fn find(&mut self) {
        let [base, slope] = [0, 1].map(|i| self.at[i] - self.number * self.front[i]);
        let position = -base / slope;
        self.position = if self.left == 0 || position.is_nan() {
            f64::INFINITY
        } else {
            position
        };
    }
}

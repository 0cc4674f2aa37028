//! Light that fog scatters along parts of a ray into the eye, with a bound on
//! the error.
//!
//! For a point light at distance `h` from the ray, with `s` measured from its
//! foot point and `d² = s² + h²`,
//!
//! ```text
//! L = ∫ σ_s p(cos θ) I e(x) exp(−σ_t (x_fog + d_fog)) / d² dx
//! ```
//!
//! is integrated on either side of the foot point in `w = φ/h`, where `φ` in
//! (0, π/2] is the angle at the light between the ray's line and the point:
//! `|s| = h / tan(h w)`, `d = h / sin(h w)`, `dx / d² = |dw|`. The inverse
//! square is gone, the sky is `w = 0`, and `h = 0` is the limit `|s| = 1/w`.
//! The integral is cut where the integrand has a kink: edges of the cone, of
//! the texels of a cookie, of the medium's box.
//!
//! For a sun the optical path is linear between the kinks and the integral
//! elementary.

use glam::DVec3;

use super::lamp::for_each_piece;
use super::quadrature::{Piece, integrate};
use super::{Fog, Lamp, Line, PointLamp, Span, Sun};

pub use super::quadrature::{Estimate, Tolerance};

/// Rays that pass a point light closer than this, relative to the distance
/// between eye and light, count as passing at this distance in an image.
pub const NEAREST: f64 = 1e-4;

/// The same in metres, for an eye at the light itself.
pub const NEAREST_METRES: f64 = 1e-12;

/// The part of `line` that `lamp` could light in `fog` if nothing were in the
/// way: in the medium, in range, in the cone. All of these are convex, so it
/// is one part; `None` if it is empty.
pub fn reach(line: &Line, lamp: &Lamp, fog: &Fog) -> Option<Span> {
    let inside = fog.inside(line)?;
    let Lamp::Point(point) = lamp else {
        return Some(inside);
    };
    let mut edges = Vec::new();
    point.edges(line, &mut edges);
    let mut reach: Option<Span> = None;
    for_each_piece(inside, &mut edges, |piece, middle| {
        if point.reaches(line.at(middle)) {
            let start = reach.map_or(piece.start, |reach| reach.start);
            reach = Some(Span::new(start, piece.end));
        }
    });
    reach
}

/// The airlight of one line, a sum over lights and lit parts.
#[derive(Debug)]
pub struct Airlight<'a> {
    line: Line,
    fog: &'a Fog,
    points: Vec<NearLight>,
    pieces: Vec<Piece>,
    suns: Estimate,
}

impl<'a> Airlight<'a> {
    /// Nothing yet.
    pub fn new(line: &Line, fog: &'a Fog) -> Self {
        Self {
            line: *line,
            fog,
            points: Vec::new(),
            pieces: Vec::new(),
            suns: Estimate::default(),
        }
    }

    /// Adds the light of `lamp` from the parts `lit` of the line, each within
    /// `reach(line, lamp, fog)`.
    ///
    /// If the line runs through a point light inside of such a part, the
    /// result is infinite; but see [`Airlight::add_off_the_light`].
    pub fn add(&mut self, lamp: &Lamp, lit: &[Span]) {
        let Some(inside) = self.fog.inside(&self.line) else {
            return;
        };
        match lamp {
            Lamp::Sun(sun) => self.add_sun(sun, inside.start, lit),
            Lamp::Point(point) => {
                self.add_point(NearLight::new(&self.line, point, inside.start), lit);
            }
        }
    }

    /// The same for an image: where the part `reach` contains the foot point
    /// of a point light, and the line passes it closer than [`NEAREST`] times
    /// its distance from the eye, the light is moved away from the line, to
    /// that distance, before its light is summed over the same parts.
    pub fn add_off_the_light(&mut self, lamp: &Lamp, reach: Span, lit: &[Span]) {
        if let (Lamp::Point(point), Some(inside)) = (lamp, self.fog.inside(&self.line)) {
            let (foot, offset) = self.line.nearest(point.position);
            let h = offset.length();
            let nearest = (NEAREST * foot.hypot(h)).max(NEAREST_METRES);
            if reach.start <= foot && foot <= reach.end && h < nearest {
                let aside = offset
                    .try_normalize()
                    .unwrap_or_else(|| self.line.direction.any_orthonormal_vector());
                let near = NearLight {
                    lamp: point.moved_to(self.line.at(foot) - nearest * aside),
                    foot,
                    // Coordinates would round it.
                    h: nearest,
                    aside,
                    entry: inside.start,
                };
                return self.add_point(near, lit);
            }
        }
        self.add(lamp, lit);
    }

    /// The sum so far to within `tolerance`, or as near as 16384 pieces get.
    pub fn total(&mut self, tolerance: Tolerance) -> Estimate {
        let (points, line, fog) = (&self.points, &self.line, self.fog);
        let quadrature = integrate(&mut self.pieces, tolerance, |term, t| {
            points[term].integrand(line, fog, t)
        });
        Estimate {
            value: self.suns.value + quadrature.value,
            bound: self.suns.bound + quadrature.bound,
        }
    }

    fn add_point(&mut self, near: NearLight, lit: &[Span]) {
        let line = self.line;
        let (foot, term) = (near.foot, self.points.len());
        self.points.push(near);
        let (points, fog) = (&self.points, self.fog);
        let lamp = &points[term].lamp;
        let (pieces, suns) = (&mut self.pieces, &mut self.suns);
        let mut edges = Vec::new();
        for part in lit {
            edges.clear();
            edges.push(foot);
            lamp.edges(&line, &mut edges);
            lamp.cookie_edges(&line, &mut edges);
            fog.point_edges(&line, lamp.position, &mut edges);
            for_each_piece(*part, &mut edges, |piece, middle| {
                if !lamp.reaches(line.at(middle)) {
                    return;
                }
                let [a, b] = points[term].variable(piece);
                if a.is_infinite() || b.is_infinite() {
                    suns.value += DVec3::INFINITY;
                    return;
                }
                points[term].layers(fog, a, b, |a, b| {
                    pieces.push(Piece::new(term, a, b, &|term, t| {
                        points[term].integrand(&line, fog, t)
                    }));
                });
            });
        }
    }

    fn add_sun(&mut self, sun: &Sun, entry: f64, lit: &[Span]) {
        let (line, fog) = (self.line, self.fog);
        // The angle between light and its way on to the eye, halved.
        let sin2 = 0.25 * (sun.toward - line.direction).length_squared();
        let cos2 = 0.25 * (sun.toward + line.direction).length_squared();
        let source = fog.sigma_s * sun.irradiance * fog.phase(sin2, cos2);
        let depth =
            |x: f64| fog.sigma_t * (x - entry + fog.sunlight_inside(sun.toward, line.at(x)));
        let mut edges = Vec::new();
        for part in lit {
            edges.clear();
            fog.sun_edges(&line, sun.toward, &mut edges);
            for_each_piece(*part, &mut edges, |piece, _| {
                let (near, far) = (depth(piece.start), piece.end);
                let integral = if far.is_finite() {
                    let far = depth(far);
                    let length = piece.end - piece.start;
                    DVec3::from_array([0, 1, 2].map(|c| length * decay(near[c], far[c])))
                } else {
                    // Only an unbounded medium, where sunlight arrives undimmed.
                    (-near).exp() / fog.sigma_t.max(DVec3::splat(f64::MIN_POSITIVE))
                };
                let value =
                    DVec3::select(source.cmpgt(DVec3::ZERO), source * integral, DVec3::ZERO);
                let depth = near.max_element().min(700.0);
                self.suns.value += value;
                self.suns.bound += 1e-15 * (8.0 + depth) * value.max_element();
            });
        }
    }
}

/// The mean of `exp(−τ)` while `τ` runs linearly from `a` to `b`.
fn decay(a: f64, b: f64) -> f64 {
    let (least, difference) = (a.min(b), (a - b).abs());
    let mean = if difference > 0.0 {
        -(-difference).exp_m1() / difference
    } else {
        1.0
    };
    (-least).exp() * mean
}

/// A point light as seen from a line.
#[derive(Debug)]
struct NearLight {
    lamp: PointLamp,
    /// Distance of the foot point along the line, and of the light from it.
    foot: f64,
    h: f64,
    /// From the light to the foot point, a unit vector.
    aside: DVec3,
    /// Where the line enters the medium.
    entry: f64,
}

impl NearLight {
    fn new(line: &Line, lamp: &PointLamp, entry: f64) -> Self {
        let (foot, offset) = line.nearest(lamp.position);
        Self {
            lamp: lamp.clone(),
            foot,
            h: offset.length(),
            aside: offset.normalize_or_zero(),
            entry,
        }
    }

    /// The range of the variable over a piece on one side of the foot point:
    /// ±w, negative in front of the light. (Rounding may leave the piece a hair
    /// over the foot point.)
    fn variable(&self, piece: Span) -> [f64; 2] {
        let w = |distance: f64| {
            let distance = distance.max(0.0);
            if self.h > 0.0 {
                self.h.atan2(distance) / self.h
            } else {
                1.0 / distance
            }
        };
        let (a, b) = (piece.start - self.foot, piece.end - self.foot);
        if b <= 0.0 || -a > b {
            [-w(-b), -w(-a)]
        } else {
            [w(b), w(a)]
        }
    }

    /// Divides a range of the variable so that extinction far from a light that
    /// is near the line, at `|w|` from about σ_t on downwards, is not a layer
    /// too thin to be noticed: its deficit falls like σ_t / w.
    fn layers(&self, fog: &Fog, a: f64, b: f64, mut part: impl FnMut(f64, f64)) {
        const RATIO: f64 = 32.0;
        const MOST: usize = 8;
        let (low, high) = (a.abs().min(b.abs()), a.abs().max(b.abs()));
        let mut part = |low: f64, high: f64| {
            if a < 0.0 {
                part(-high, -low);
            } else {
                part(low, high);
            }
        };
        let thinnest = low.max(0.3 * fog.sigma_t.min_element());
        let mut top = high;
        for _ in 0..MOST {
            if top < RATIO * thinnest {
                break;
            }
            part(top / RATIO, top);
            top /= RATIO;
        }
        part(low, top);
    }

    /// `L = ∫ integrand |dw|`.
    fn integrand(&self, line: &Line, fog: &Fog, t: f64) -> DVec3 {
        let (w, behind) = (t.abs(), t > 0.0);
        let angle = self.h * w;
        let (along, d) = if angle < 1e-4 {
            let a2 = angle * angle;
            ((1.0 - a2 / 3.0) / w, (1.0 + a2 / 6.0) / w)
        } else {
            (self.h / angle.tan(), self.h / angle.sin())
        };
        let s = if behind { along } else { -along };
        let x = self.foot + s;
        let to_point = s * line.direction + self.h * self.aside;
        let leg = d * fog.share_inside(self.lamp.position, self.lamp.position + to_point);
        // Light that goes on in its direction turns by the angle φ in front of
        // the light and by π − φ behind it.
        let narrow = 0.5 * self.h * self.h / (d * (d + along));
        let wide = 0.5 * (d + along) / d;
        let (sin2, cos2) = if behind {
            (wide, narrow)
        } else {
            (narrow, wide)
        };
        let depth = (x - self.entry).max(0.0) + leg;
        fog.sigma_s
            * self.lamp.intensity
            * self.lamp.emission(to_point / d)
            * self.lamp.fading(d)
            * (fog.phase(sin2, cos2) * (-fog.sigma_t * depth).exp())
    }
}

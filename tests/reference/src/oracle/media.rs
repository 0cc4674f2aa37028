//! How much light comes along a ray through media that are not uniform: single
//! scattering and emission, with a bound on the error.
//!
//! ```text
//! L = ∫ T(0, x) [ Σ σ_s p(cos θ) V(x) T(x, light) E(x) + ε ] dx
//! ```
//!
//! summed over the lights and over the media at x: a homogeneous one, fog that thins
//! out with altitude, density grids and particles. The light towards x is dimmed by all
//! of them, and by strands, which are not seen themselves. The quadrature is adaptive
//! along the ray; each of its points has the exact optical depth to the eye and to the
//! light. It is cut wherever a coefficient, the visibility or the emission of a light has
//! a kink, and in dense media where the optical depth has grown by 1, 8 and 64.

use glam::DVec3;
use rayon::prelude::*;
use scene::{Emitter, Geometry, HeightFog, Medium, Ray, Translucent};

use super::airlight::{NEAREST, NEAREST_METRES};
use super::image::Reference;
use super::quadrature::{Estimate, Piece, Tolerance, integrate};
use super::translucent::Translucency;
use super::visibility::{Blockers, Search};
use super::{Fog, Lamp, Line, Phase, Span};

/// All that fills the air, the lights in it, and the solid triangles that cast shadows.
#[derive(Debug)]
pub struct MediaWorld {
    fog: Option<Fog>,
    height: Option<Height>,
    translucency: Translucency,
    lamps: Vec<Lamp>,
    blockers: Blockers,
}

/// What is in the air.
#[derive(Debug, Clone, Copy, Default)]
pub struct Air<'a> {
    /// A homogeneous medium.
    pub medium: Option<&'a Medium>,
    /// Fog that thins out with altitude.
    pub height_fog: Option<&'a HeightFog>,
    /// Grids, particles, strands.
    pub translucent: &'a [Translucent],
}

/// Fog that thins out with altitude.
#[derive(Debug, Clone, Copy)]
struct Height {
    sigma_s: DVec3,
    sigma_t: DVec3,
    altitude: f64,
    scale: f64,
    phase: Phase,
}

impl Height {
    fn density(&self, y: f64) -> f64 {
        (-(y - self.altitude) / self.scale).exp()
    }

    /// ∫ density along a way, by Gauss's rule on parts of half a scale height.
    fn column(&self, y: f64, slope: f64, distance: f64) -> f64 {
        if slope < 0.0 {
            // The same from its other end, if it has one.
            return if distance.is_finite() {
                self.column(y + slope * distance, -slope, distance)
            } else {
                f64::INFINITY
            };
        }
        // What is more than 60 scale heights above counts for nothing.
        let end = distance.min(60.0 * self.scale / slope);
        if !end.is_finite() {
            return f64::INFINITY;
        }
        let parts = (2.0 * end * slope / self.scale).ceil().max(1.0);
        let step = end / parts;
        let at = |t: f64| self.density(y + slope * t);
        let sums = (0..parts as u32).map(|part| gauss(f64::from(part) * step, step, at));
        sums.sum()
    }
}

/// Five nodes: exact to 1e-13 for an exponential that falls by half an e-fold.
fn gauss(start: f64, length: f64, f: impl Fn(f64) -> f64) -> f64 {
    const NODES: [(f64, f64); 3] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let (middle, half) = (start + 0.5 * length, 0.5 * length);
    let sides = NODES[1..].iter();
    let sum: f64 = sides
        .map(|(node, weight)| weight * (f(middle - half * node) + f(middle + half * node)))
        .sum();
    half * (NODES[0].1 * f(middle) + sum)
}

/// What is integrated on a piece of the ray.
#[derive(Debug, Clone)]
enum Term {
    /// The light of a lamp, over the angle at the lamp: x = foot + h tan η.
    Point { lamp: Lamp, foot: f64, h: f64 },
    /// Light from infinitely far away, or, without a lamp, emission: over x, or over
    /// u = (x − start) / (x − start + scale) towards infinity.
    Even {
        lamp: Option<Lamp>,
        endless: Option<(f64, f64)>,
    },
}

impl Term {
    /// Position, and dx per step of the variable.
    fn position(&self, t: f64) -> (f64, f64) {
        match *self {
            Self::Point { foot, h, .. } => {
                let tan = t.tan();
                (foot + h * tan, h * (1.0 + tan * tan))
            }
            Self::Even {
                endless: Some((start, scale)),
                ..
            } => {
                let rest = 1.0 - t;
                (start + scale * t / rest, scale / (rest * rest))
            }
            Self::Even { .. } => (t, 1.0),
        }
    }

    /// The variable at a position, for a part that ends at infinity or not.
    fn variable(&self, x: f64) -> f64 {
        match *self {
            Self::Point { foot, h, .. } => ((x - foot) / h).atan(),
            Self::Even {
                endless: Some((start, scale)),
                ..
            } => {
                if x.is_finite() {
                    (x - start) / (x - start + scale)
                } else {
                    1.0
                }
            }
            Self::Even { .. } => x,
        }
    }

    fn lamp(&self) -> Option<&Lamp> {
        match self {
            Self::Point { lamp, .. } => Some(lamp),
            Self::Even { lamp, .. } => lamp.as_ref(),
        }
    }
}

impl MediaWorld {
    /// Reads a scene. Of the triangles only the solid ones count.
    pub fn new(air: Air<'_>, emitters: &[Emitter], geometry: &Geometry) -> Self {
        Self {
            fog: air.medium.map(Fog::new),
            height: air.height_fog.map(|fog| Height {
                sigma_s: fog.sigma_s().as_dvec3(),
                sigma_t: fog.sigma_s().as_dvec3() + fog.sigma_a().as_dvec3(),
                altitude: fog.altitude().into(),
                scale: fog.scale_height().into(),
                phase: fog.phase().into(),
            }),
            translucency: Translucency::new(air.translucent),
            lamps: emitters.iter().map(Lamp::new).collect(),
            blockers: Blockers::new(geometry),
        }
    }

    /// The optical depth over `distance` from `origin` along a unit vector.
    pub fn optical_depth(&self, origin: DVec3, direction: DVec3, distance: f64) -> DVec3 {
        let mut depth = self
            .translucency
            .optical_depths(origin, direction, distance);
        if let Some(fog) = &self.fog {
            let line = Line {
                origin,
                direction,
                length: distance,
            };
            if let Some(inside) = fog.inside(&line) {
                depth += times(fog.sigma_t, inside.end - inside.start);
            }
        }
        if let Some(height) = &self.height {
            let column = height.column(origin.y, direction.y, distance);
            depth += times(height.sigma_t, column);
        }
        depth
    }

    /// `Σ σ_s p` at a point for the half angles of the phase functions, and what is
    /// emitted there.
    fn source(&self, point: DVec3, sin2: f64, cos2: f64) -> (DVec3, DVec3) {
        let (mut scattering, emission) = self.translucency.source(point, sin2, cos2);
        if let Some(fog) = &self.fog
            && fog.contains(point)
        {
            scattering += fog.sigma_s * fog.phase(sin2, cos2);
        }
        if let Some(height) = &self.height {
            let density = height.density(point.y) * height.phase.at(sin2, cos2);
            scattering += times(height.sigma_s, density);
        }
        (scattering, emission)
    }

    /// The light from `x` of the line per metre.
    fn light(&self, line: &Line, lamp: Option<&Lamp>, x: f64) -> DVec3 {
        let seen = (-self.optical_depth(line.origin, line.direction, x)).exp();
        if seen == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let point = line.at(x);
        let Some(lamp) = lamp else {
            return seen * self.source(point, 0.0, 1.0).1;
        };
        let (toward, distance, irradiance) = match lamp {
            Lamp::Sun(sun) => (sun.toward, f64::INFINITY, sun.irradiance),
            Lamp::Point(lamp) => {
                let offset = lamp.position - point;
                let distance = offset.length();
                if !lamp.reaches(point) {
                    return DVec3::ZERO;
                }
                let toward = offset / distance;
                let emitted = lamp.intensity * lamp.emission(-toward) * lamp.fading(distance);
                (toward, distance, emitted / (distance * distance))
            }
        };
        // The angle between light and its way on to the eye, halved.
        let sin2 = 0.25 * (toward - line.direction).length_squared();
        let cos2 = 0.25 * (toward + line.direction).length_squared();
        let scattering = self.source(point, sin2, cos2).0;
        if scattering == DVec3::ZERO {
            return DVec3::ZERO;
        }
        // A sun in fog that is everywhere counts as shining from its edge.
        let depth = match (&self.fog, lamp) {
            (Some(fog), Lamp::Sun(sun)) if fog.contains(point) => {
                let inside = fog.sunlight_inside(sun.toward, point);
                self.without_fog_depth(point, toward, distance) + fog.sigma_t * inside
            }
            _ => self.optical_depth(point, toward, distance),
        };
        let passed = self.translucency.passed(point, toward, distance);
        seen * scattering * irradiance * (-depth).exp() * passed
    }

    fn without_fog_depth(&self, point: DVec3, toward: DVec3, distance: f64) -> DVec3 {
        let smoke = self.translucency.optical_depths(point, toward, distance);
        let height = self.height.map_or(DVec3::ZERO, |height| {
            let column = height.column(point.y, toward.y, distance);
            times(height.sigma_t, column)
        });
        smoke + height
    }

    /// The light that comes along the ray into its origin, within `tolerance`, or as
    /// near as 16384 pieces get.
    ///
    /// A line through a point light passes it at a distance of 1e-4 of that of the eye,
    /// as in [`reference`](super::image::reference).
    pub fn radiance(&self, ray: &Ray, tolerance: Tolerance) -> Estimate {
        let line = Line::new(ray);
        let mut cuts = vec![0.0, line.length];
        self.translucency.edges(&line, &mut cuts);
        if let Some(inside) = self.fog.as_ref().and_then(|fog| fog.inside(&line)) {
            cuts.extend([inside.start, inside.end]);
        }
        cuts.retain(|cut| (0.0..=line.length).contains(cut));
        self.add_layers(&line, &mut cuts);
        let mut terms = Vec::new();
        let mut pieces = Vec::new();
        for lamp in &self.lamps {
            self.add_lamp(&line, lamp, &cuts, &mut terms, &mut pieces);
        }
        if self.translucency.emits() {
            let whole = Span::new(0.0, line.length);
            self.add_term(&line, None, &[whole], &cuts, &mut terms, &mut pieces);
        }
        let f = |term: usize, t: f64| self.integrand(&line, &terms, term, t);
        let mut pieces: Vec<Piece> = pieces
            .into_iter()
            .map(|(term, start, end)| Piece::new(term, start, end, &f))
            .collect();
        integrate(&mut pieces, tolerance, f)
    }

    fn integrand(&self, line: &Line, terms: &[Term], term: usize, t: f64) -> DVec3 {
        let (x, per_step) = terms[term].position(t);
        if !(x.is_finite() && per_step.is_finite()) {
            return DVec3::ZERO;
        }
        self.light(line, terms[term].lamp(), x) * per_step
    }

    fn add_lamp(
        &self,
        line: &Line,
        lamp: &Lamp,
        cuts: &[f64],
        terms: &mut Vec<Term>,
        pieces: &mut Vec<(usize, f64, f64)>,
    ) {
        let mut lamp = lamp.clone();
        let mut cuts = cuts.to_vec();
        let mut lit = Vec::new();
        let whole = Span::new(0.0, line.length);
        self.blockers
            .lit(line, &lamp, whole, Search::Tree, &mut lit);
        if let Lamp::Point(point) = &lamp {
            let (foot, offset) = line.nearest(point.position);
            let h = offset.length();
            let nearest = (NEAREST * foot.hypot(h)).max(NEAREST_METRES);
            if h < nearest {
                let aside = offset
                    .try_normalize()
                    .unwrap_or_else(|| line.direction.any_orthonormal_vector());
                lamp = Lamp::Point(point.moved_to(line.at(foot) - nearest * aside));
            }
        }
        if let Lamp::Point(point) = &lamp {
            cuts.push(line.nearest(point.position).0);
            point.edges(line, &mut cuts);
            point.cookie_edges(line, &mut cuts);
        }
        self.add_term(line, Some(&lamp), &lit, &cuts, terms, pieces);
    }

    fn add_term(
        &self,
        line: &Line,
        lamp: Option<&Lamp>,
        parts: &[Span],
        cuts: &[f64],
        terms: &mut Vec<Term>,
        pieces: &mut Vec<(usize, f64, f64)>,
    ) {
        let mut cuts = cuts.to_vec();
        cuts.sort_by(f64::total_cmp);
        for part in parts {
            let inner = cuts
                .iter()
                .filter(|&&cut| part.start < cut && cut < part.end);
            let ends: Vec<f64> = std::iter::once(part.start)
                .chain(inner.copied())
                .chain([part.end])
                .collect();
            for pair in ends.windows(2) {
                let (start, end) = (pair[0], pair[1]);
                if !(start < end) {
                    continue;
                }
                let term = match lamp {
                    Some(Lamp::Point(point)) => {
                        let (foot, offset) = line.nearest(point.position);
                        Term::Point {
                            lamp: Lamp::Point(point.clone()),
                            foot,
                            h: offset.length(),
                        }
                    }
                    other => Term::Even {
                        lamp: other.cloned(),
                        endless: end.is_infinite().then_some((start, self.reach())),
                    },
                };
                pieces.push((terms.len(), term.variable(start), term.variable(end)));
                terms.push(term);
            }
        }
    }

    /// A length over which what is endless fades.
    fn reach(&self) -> f64 {
        let even = self.fog.map_or(DVec3::ZERO, |fog| fog.sigma_t);
        let height = self.height.map_or(DVec3::ZERO, |height| height.sigma_t);
        let thinnest = even.to_array().into_iter().chain(height.to_array());
        let thinnest = thinnest.filter(|&sigma| sigma > 0.0);
        let thinnest = thinnest.fold(f64::INFINITY, f64::min);
        // Without fog nothing is endless.
        let path = if thinnest.is_finite() {
            1.0 / thinnest.max(1e-9)
        } else {
            1.0
        };
        self.height.map_or(path, |height| path.min(height.scale))
    }

    /// Cuts where the optical depth has grown by 1, 8 and 64 behind a cut.
    fn add_layers(&self, line: &Line, cuts: &mut Vec<f64>) {
        cuts.sort_by(f64::total_cmp);
        let mut more = Vec::new();
        for pair in cuts.windows(2) {
            let (start, end) = (pair[0], pair[1].min(1e12));
            let from = line.at(start);
            let depth = |x: f64| {
                let depth = self.optical_depth(from, line.direction, x - start);
                depth.max_element()
            };
            if !(start < end && depth(end) > 1.0) {
                continue;
            }
            for grown in [1.0, 8.0, 64.0] {
                let (mut low, mut high) = (start, end);
                if depth(end) <= grown {
                    break;
                }
                for _ in 0..100 {
                    let middle = 0.5 * (low + high);
                    if depth(middle) < grown {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                more.push(high);
            }
        }
        cuts.extend(more);
    }
}

/// The image of [`MediaWorld::radiance`]: the errors are relative to the brightest
/// channel of each pixel, and to 1e-3 of the mean of pixels darker than that.
///
/// The result does not depend on the number of threads.
pub fn reference(world: &MediaWorld, rays: &[Ray], tolerance: f64) -> Reference {
    let rough: Vec<f64> = rays
        .par_iter()
        .step_by(rays.len().div_ceil(500).max(1))
        .map(|ray| {
            let unrefined = Tolerance::relative(f64::INFINITY);
            world.radiance(ray, unrefined).value.element_sum() / 3.0
        })
        .collect();
    let mean = rough.iter().sum::<f64>() / rough.len().max(1) as f64;
    let tolerance = Tolerance {
        relative: tolerance,
        absolute: tolerance * crate::metrics::DARKEST * mean,
    };
    let estimates: Vec<Estimate> = rays
        .par_iter()
        .map(|ray| world.radiance(ray, tolerance))
        .collect();
    Reference {
        radiance: estimates.iter().map(|e| e.value.to_array()).collect(),
        bound: estimates.iter().map(|e| e.bound).collect(),
    }
}

/// A coefficient times a length that may be infinite.
fn times(sigma: DVec3, length: f64) -> DVec3 {
    DVec3::from_array(
        sigma
            .to_array()
            .map(|sigma| if sigma == 0.0 { 0.0 } else { sigma * length }),
    )
}

#[cfg(test)]
mod tests;

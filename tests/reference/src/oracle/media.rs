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
mod tests {
    use std::f64::consts::PI;

    use glam::{Affine3A, Quat, Vec3};
    use scene::{
        Bounds, DensityGrid, Instance, Interpolation, Mesh, Particle, Particles, PhaseFunction,
        Profile, Scene,
    };

    use super::*;
    use crate::oracle::image::{self, Options};

    const TOLERANCE: f64 = 1e-7;

    fn geometry(triangles: &[[Vec3; 3]]) -> Geometry {
        let mut scene = Scene::default();
        for (index, corners) in triangles.iter().enumerate() {
            scene.meshes.push(Mesh {
                positions: corners.to_vec(),
                triangles: vec![[0, 1, 2]],
                ..Mesh::default()
            });
            scene.instances.push(Instance {
                mesh: index,
                ..Instance::default()
            });
        }
        Geometry::new(&scene).expect("triangles")
    }

    /// Nothing that casts a shadow here.
    fn far_away() -> Geometry {
        let corner = Vec3::new(0.0, -1e4, 0.0);
        geometry(&[[corner, corner + Vec3::X, corner + Vec3::Z]])
    }

    /// A plate above the origin, between the lights and a part of each ray.
    fn plate() -> Geometry {
        geometry(&[[
            Vec3::new(-0.6, 1.5, -1.0),
            Vec3::new(0.8, 1.5, -1.0),
            Vec3::new(0.1, 1.5, 2.0),
        ]])
    }

    fn lights() -> [Emitter; 3] {
        let even = scene::Emission::Isotropic;
        let cone = scene::Cone {
            inner: 0.2,
            outer: 0.6,
        };
        let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let spot = scene::Emission::spot(down, cone, None).expect("a cone");
        let colour = Vec3::new(3.0, 2.0, 1.0);
        [
            Emitter::point(Vec3::new(0.2, 3.0, 0.3), colour, f32::INFINITY, even).expect("a lamp"),
            Emitter::point(Vec3::new(-0.1, 2.5, 0.0), colour, 9.0, spot).expect("a spot"),
            Emitter::directional(Vec3::new(0.2, -1.0, 0.1), colour).expect("a sun"),
        ]
    }

    fn rays() -> Vec<Ray> {
        let ray = |origin: Vec3, target: Vec3, length| {
            Ray::new(origin, target - origin, length).expect("a sound ray")
        };
        vec![
            ray(Vec3::new(-4.0, 0.3, 0.1), Vec3::new(0.0, 0.2, 0.0), 9.0),
            ray(Vec3::new(0.1, 0.4, 0.2), Vec3::new(3.0, 1.0, 0.5), 4.0),
            ray(
                Vec3::new(0.5, -3.0, 4.0),
                Vec3::new(0.1, 0.0, 0.0),
                f32::INFINITY,
            ),
        ]
    }

    fn fog(sigma_s: f32, g: f32) -> Medium {
        let phase = PhaseFunction::HenyeyGreenstein { g };
        Medium::new(Vec3::new(1.0, 0.8, 0.5) * sigma_s, Vec3::splat(0.02), phase).expect("fog")
    }

    fn smoke(interpolation: Interpolation, scale: f32) -> DensityGrid {
        let bounds = Bounds::new(Vec3::new(-1.0, -0.7, -0.8), Vec3::new(1.2, 0.9, 0.7));
        let density = (0..60).map(|i| (i * 7 % 11) as f32).collect();
        DensityGrid::new(
            bounds.expect("a box"),
            [5, 4, 3],
            density,
            scale,
            interpolation,
        )
        .expect("smoke")
    }

    fn of(air: Air<'_>, emitters: &[Emitter], geometry: &Geometry, ray: &Ray) -> Estimate {
        let world = MediaWorld::new(air, emitters, geometry);
        world.radiance(ray, Tolerance::relative(TOLERANCE))
    }

    fn assert_same(one: Estimate, other: Estimate, relative: f64) {
        let error = (one.value - other.value).abs().max_element();
        let allowed = one.bound + other.bound + relative * other.value.max_element();
        assert!(error <= allowed, "{one:?} {other:?}");
    }

    #[test]
    fn homogeneous_media_are_those_of_the_reference_image() {
        let bounds = Bounds::new(Vec3::new(-2.0, -1.0, -2.0), Vec3::new(2.5, 4.0, 2.0));
        let whole = fog(0.2, 0.5);
        let boxed = whole.within(bounds.expect("a box"));
        let mut lit = 0;
        for medium in [whole, boxed] {
            for geometry in [far_away(), plate()] {
                for emitter in lights() {
                    let emitters = [emitter];
                    let rays = rays();
                    let options = Options {
                        tolerance: 1e-8,
                        ..Options::default()
                    };
                    let truth = image::reference(&rays, &emitters, &medium, &geometry, options);
                    let air = Air {
                        medium: Some(&medium),
                        ..Air::default()
                    };
                    for (index, ray) in rays.iter().enumerate() {
                        let expected = Estimate {
                            value: DVec3::from_array(truth.radiance[index]),
                            bound: truth.bound[index],
                        };
                        lit += u32::from(expected.value.min_element() > 0.0);
                        assert_same(of(air, &emitters, &geometry, ray), expected, 1e-12);
                    }
                }
            }
        }
        assert!(lit > 24, "{lit} of 36");
    }

    #[test]
    fn a_constant_grid_is_a_homogeneous_medium_and_an_empty_one_is_nothing() {
        let bounds = Bounds::new(Vec3::new(-2.0, -1.0, -2.0), Vec3::new(2.5, 4.0, 2.0));
        let bounds = bounds.expect("a box");
        let medium = fog(0.2, 0.5).within(bounds);
        let sigma_t = medium.sigma_t();
        let grid = DensityGrid::new(bounds, [3, 2, 4], vec![1.0; 24], 1.0, Interpolation::Linear)
            .and_then(|grid| grid.with_tint(sigma_t))
            .and_then(|grid| grid.with_albedo(medium.sigma_s() / sigma_t))
            .and_then(|grid| grid.with_phase(medium.phase()))
            .expect("a grid");
        let empty = smoke(Interpolation::Constant, 0.0);
        let casters: [Translucent; 2] = [grid.into(), empty.into()];
        let (as_grid, as_medium) = (
            Air {
                translucent: &casters,
                ..Air::default()
            },
            Air {
                medium: Some(&medium),
                ..Air::default()
            },
        );
        let geometry = plate();
        for emitter in lights() {
            for ray in rays() {
                let emitters = [emitter.clone()];
                let found = of(as_grid, &emitters, &geometry, &ray);
                let expected = of(as_medium, &emitters, &geometry, &ray);
                // The products of tint and albedo are rounded to f32.
                assert_same(found, expected, 3e-7);
            }
        }
    }

    #[test]
    fn split_rays_add_up_and_lights_do() {
        let medium = fog(0.05, 0.0);
        let height = HeightFog::new(
            Vec3::splat(0.1),
            Vec3::splat(0.05),
            0.0,
            1.5,
            PhaseFunction::Rayleigh,
        )
        .expect("fog");
        let turned = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.5), Vec3::Y);
        let grid = smoke(Interpolation::Constant, 0.05).with_transform(turned);
        let puff = Particle {
            centre: Vec3::new(0.3, 0.2, 0.0),
            radius: 0.7,
            sigma_t: 1.0,
        };
        let puffs = Particles::new(vec![puff], Profile::Soft).expect("a puff");
        let glowing = smoke(Interpolation::Linear, 0.1)
            .with_emission((0..60).map(|i| Vec3::splat(i as f32)).collect());
        let casters: [Translucent; 3] = [
            grid.expect("a grid").into(),
            puffs.into(),
            glowing.expect("a grid").into(),
        ];
        let air = Air {
            medium: Some(&medium),
            height_fog: Some(&height),
            translucent: &casters,
        };
        let geometry = plate();
        let emitters = lights();
        let world = MediaWorld::new(air, &emitters, &geometry);
        let light = |ray: &Ray| world.radiance(ray, Tolerance::relative(1e-6));
        for ray in rays() {
            let whole = light(&ray);
            let cut = 4.2_f32.min(0.5 * ray.length());
            let line = Line::new(&ray);
            let near = light(&ray.with_length(cut));
            let point = line.at(cut.into()).as_vec3();
            let rest = Ray::new(point, ray.direction(), ray.length() - cut).expect("a ray");
            let passed = (-world.optical_depth(line.origin, line.direction, cut.into())).exp();
            let far = light(&rest);
            let sum = Estimate {
                value: near.value + passed * far.value,
                bound: near.bound + far.bound,
            };
            // The second part begins at a point that was rounded to f32.
            assert_same(sum, whole, 3e-6);
            let unlit = MediaWorld::new(air, &[], &geometry);
            let mut each = unlit.radiance(&ray, Tolerance::relative(1e-6));
            assert!(each.value.x > 0.0, "it glows");
            for emitter in &emitters {
                // What glows would be counted again with each light.
                let with = of(air, std::slice::from_ref(emitter), &geometry, &ray);
                each.value += with.value - unlit.radiance(&ray, Tolerance::relative(1e-7)).value;
                each.bound += with.bound;
            }
            assert_same(each, whole, 1e-5);
        }
    }

    #[test]
    fn thin_smoke_scatters_in_proportion_to_what_there_is_of_it() {
        let geometry = far_away();
        let emitters = &lights()[2..];
        let ray = rays()[0];
        let light = |scale: f32| {
            let casters = [smoke(Interpolation::Linear, scale).into()];
            let air = Air {
                translucent: &casters,
                ..Air::default()
            };
            let world = MediaWorld::new(air, emitters, &geometry);
            let line = Line::new(&ray);
            let depth = world
                .optical_depth(line.origin, line.direction, line.length)
                .x;
            (of(air, emitters, &geometry, &ray), depth)
        };
        // An albedo of 1, evenly spread: E τ / 4π, less what is lost on the way.
        let (found, depth) = light(1e-6);
        let irradiance = DVec3::new(3.0, 2.0, 1.0);
        let expected = irradiance * (depth / (4.0 * PI));
        assert!(depth > 1e-6 && (found.value / expected - 1.0).abs().max_element() < 1e-4);
        assert!((found.value.cmple(expected)).all());
        let (half, _) = light(5e-7);
        assert!((2.0 * half.value / found.value - 1.0).abs().max_element() < 1e-4);
    }

    #[test]
    fn no_more_light_comes_out_than_went_in() {
        // Parallel light through smoke of any thickness: what is scattered towards one
        // side, summed over a plane across it, is less than what was taken from the light.
        let geometry = far_away();
        let sun = [Emitter::directional(Vec3::NEG_Y, Vec3::ONE).expect("a sun")];
        for scale in [1e-3, 0.1, 10.0, 1e6] {
            let casters = [smoke(Interpolation::Constant, scale).into()];
            let air = Air {
                translucent: &casters,
                ..Air::default()
            };
            let world = MediaWorld::new(air, &sun, &geometry);
            let (mut scattered, mut taken) = (0.0, 0.0);
            let count = 12;
            for i in 0..count {
                for j in 0..count {
                    let at = |index: i32| (f64::from(index) + 0.5) / f64::from(count);
                    let origin =
                        Vec3::new(-5.0, -0.7 + 1.6 * at(i) as f32, -0.8 + 1.5 * at(j) as f32);
                    let ray = Ray::new(origin, Vec3::X, f32::INFINITY).expect("a ray");
                    let light = world.radiance(&ray, Tolerance::relative(1e-4));
                    assert!(light.value.is_finite() && light.bound <= 2e-4 * light.value.x + 1e-30);
                    scattered += light.value.x * 4.0 * PI * 1.6 * 1.5;
                    let above = DVec3::new(-1.0 + 2.2 * at(i), 5.0, -0.8 + 1.5 * at(j));
                    let depth = world.optical_depth(above, DVec3::NEG_Y, 9.0).x;
                    taken += -(-depth).exp_m1() * 2.2 * 1.5;
                }
            }
            assert!(
                (scattered > 0.0 || scale > 10.0) && scattered < 1.02 * taken,
                "{scale}: {scattered} {taken}"
            );
            // In the densest smoke only a skin is lit, which these lines pass below.
            if scale < 0.01 {
                // Nothing is lost in thin smoke; two sums over 144 lines.
                assert!(scattered > 0.85 * taken, "{scattered} {taken}");
            }
        }
    }

    #[test]
    fn fog_that_thins_out_has_its_closed_form_and_its_limits() {
        let geometry = far_away();
        let up = Ray::new(Vec3::ZERO, Vec3::Y, f32::INFINITY).expect("a ray");
        let sun = [Emitter::directional(Vec3::NEG_Y, Vec3::ONE).expect("a sun")];
        let fog = |height| {
            let phase = PhaseFunction::Isotropic;
            HeightFog::new(Vec3::splat(0.1), Vec3::splat(0.1), 0.0, height, phase).expect("fog")
        };
        let thins = fog(3.0);
        let air = Air {
            height_fog: Some(&thins),
            ..Air::default()
        };
        // The way to the eye and that to the sun make up the whole of the fog.
        let found = of(air, &sun, &geometry, &up).value.x;
        let (sigma_s, sigma_t) = (f64::from(0.1_f32), 2.0 * f64::from(0.1_f32));
        let expected = sigma_s * 3.0 * (-sigma_t * 3.0).exp() / (4.0 * PI);
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        // Hardly thinner over the length of the ray: as if it were even.
        let (deep, even) = (fog(1e7), {
            let phase = PhaseFunction::Isotropic;
            Medium::new(Vec3::splat(0.1), Vec3::splat(0.1), phase).expect("fog")
        });
        let lamp = &lights()[..1];
        let slanted = rays()[0];
        let deep = Air {
            height_fog: Some(&deep),
            ..Air::default()
        };
        let even = Air {
            medium: Some(&even),
            ..Air::default()
        };
        let (found, expected) = (
            of(deep, lamp, &geometry, &slanted),
            of(even, lamp, &geometry, &slanted),
        );
        assert_same(found, expected, 2e-6);
    }
}

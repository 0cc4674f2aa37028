//! How much of a light gets through hair and smoke to a point, exactly, and the
//! image that follows.
//!
//! Between a point and a light, with the path from one to the other:
//!
//! * a piece of strand that the path crosses within its outline, as the light
//!   sees it, lets `1 − opacity` pass;
//! * particles and grids let `exp(−∫ σ_t)` pass;
//! * what is opaque is the affair of [`Blockers`].
//!
//! The image is the airlight of the lit parts of a ray, cut into short ones,
//! each times the mean transmittance at two of its points. Parts are short where
//! the shadows of casters can be, and whole elsewhere.

mod strands;

use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;
use scene::{DensityGrid, Emitter, Geometry, Interpolation, Medium, Profile, Ray, Translucent};

use super::airlight::{Airlight, Tolerance, reach};
use super::image::Reference;
use super::shades::Shades;
use super::visibility::{Blockers, Search};
use super::{Fog, Lamp, Line, Phase, Span};
use strands::{Hair, Plane, Ribbon};

/// Hair and smoke in f64.
#[derive(Debug, Clone, Default)]
pub struct Translucency {
    hair: Hair,
    balls: Vec<Ball>,
    boxes: Vec<SmokeBox>,
}

/// A particle.
#[derive(Debug, Clone, Copy)]
struct Ball {
    centre: DVec3,
    radius: f64,
    sigma_t: f64,
    profile: Profile,
    albedo: DVec3,
    phase: Phase,
}

/// A density grid.
#[derive(Debug, Clone)]
struct SmokeBox {
    /// In the space of the box.
    min: DVec3,
    max: DVec3,
    /// From the world to that space.
    turn: DMat3,
    shift: DVec3,
    samples: DensityGrid,
}

impl Translucency {
    /// Reads the casters.
    pub fn new(casters: &[Translucent]) -> Self {
        let mut translucency = Self::default();
        let mut ribbons = Vec::new();
        for caster in casters {
            match caster {
                Translucent::Strands(strands) => {
                    let pieces = (0..strands.piece_count()).map(|index| strands.piece(index));
                    ribbons.extend(pieces.map(Ribbon::from));
                }
                Translucent::Particles(particles) => {
                    translucency
                        .balls
                        .extend(particles.all().iter().map(|ball| Ball {
                            centre: ball.centre.as_dvec3(),
                            radius: ball.radius.into(),
                            sigma_t: ball.sigma_t.into(),
                            profile: particles.profile(),
                            albedo: particles.albedo().as_dvec3(),
                            phase: particles.phase().into(),
                        }));
                }
                Translucent::Grid(grid) => translucency.boxes.push(SmokeBox::new(grid)),
            }
        }
        translucency.hair = Hair::new(ribbons);
        translucency
    }

    /// What may lie between the line and the lamp: all that is not entirely on
    /// one side of their common plane.
    #[must_use]
    pub fn between(&self, line: &Line, lamp: &Lamp) -> Self {
        let Some(plane) = Plane::new(line, lamp) else {
            return self.clone();
        };
        let balls = self.balls.iter();
        Self {
            hair: Hair::new(self.hair.near(Some(plane)).copied().collect()),
            balls: balls
                .filter(|ball| plane.touches((ball.centre, ball.radius)))
                .copied()
                .collect(),
            boxes: self.boxes.clone(),
        }
    }

    /// Balls around all of its parts.
    pub(super) fn balls_around(&self) -> impl Iterator<Item = (DVec3, f64)> {
        let ribbons = self.hair.ribbons().iter().map(Ribbon::ball_around);
        ribbons.chain(self.balls_around_media())
    }

    /// Those around all but strands.
    pub(super) fn balls_around_media(&self) -> impl Iterator<Item = (DVec3, f64)> {
        let balls = self.balls.iter().map(|ball| (ball.centre, ball.radius));
        let boxes = self.boxes.iter().map(|smoke| {
            let bounds = smoke.samples.bounds();
            let (min, max) = (bounds.min().as_dvec3(), bounds.max().as_dvec3());
            (0.5 * (min + max), 0.5 * min.distance(max))
        });
        balls.chain(boxes)
    }

    /// Share of the light of `lamp` that gets as far as `point`, from 0 to 1, where grids
    /// have no tint; see also [`transmittances`](Translucency::transmittances).
    pub fn transmittance(&self, lamp: &Lamp, point: DVec3) -> f64 {
        let (towards, distance) = lamp.seen_from(point);
        let depth = self.optical_depths_of(point, towards, distance, |_| DVec3::ONE);
        self.passed(point, towards, distance) * (-depth.x).exp()
    }

    /// The same in each colour channel.
    pub fn transmittances(&self, lamp: &Lamp, point: DVec3) -> DVec3 {
        let (towards, distance) = lamp.seen_from(point);
        let depth = self.optical_depths(point, towards, distance);
        self.passed(point, towards, distance) * (-depth).exp()
    }

    /// Where on a part of a line pieces of strand are in front of a lamp, and what share of
    /// its light each of them lets pass.
    pub(super) fn strand_shadows(&self, line: &Line, lamp: &Lamp, span: Span) -> Vec<(Span, f64)> {
        self.hair.shadows(line, lamp, span)
    }

    /// Share of light that strands let pass over `distance` from a point.
    pub fn passed(&self, point: DVec3, towards: DVec3, distance: f64) -> f64 {
        self.hair.passed(point, towards, distance)
    }

    /// The optical depth of grids and particles over `distance` from a point.
    pub fn optical_depths(&self, point: DVec3, towards: DVec3, distance: f64) -> DVec3 {
        self.optical_depths_of(point, towards, distance, |smoke| {
            smoke.samples.tint().as_dvec3()
        })
    }

    fn optical_depths_of(
        &self,
        point: DVec3,
        towards: DVec3,
        distance: f64,
        tint: impl Fn(&SmokeBox) -> DVec3,
    ) -> DVec3 {
        let balls = self.balls.iter();
        let mut depth = DVec3::splat(
            balls
                .map(|ball| ball.optical_depth(point, towards, distance))
                .sum(),
        );
        for smoke in &self.boxes {
            depth += tint(smoke) * smoke.optical_depth(point, towards, distance);
        }
        depth
    }

    /// Scattering coefficients times phase functions of half angles, and what is emitted
    /// per metre, at a point.
    pub fn source(&self, point: DVec3, sin2: f64, cos2: f64) -> (DVec3, DVec3) {
        let (mut scattering, mut emission) = (DVec3::ZERO, DVec3::ZERO);
        for ball in &self.balls {
            let share2 = (point - ball.centre).length_squared() / (ball.radius * ball.radius);
            if share2 < 1.0 {
                let density = match ball.profile {
                    Profile::Constant => ball.sigma_t,
                    Profile::Soft => ball.sigma_t * (1.0 - share2),
                };
                scattering += ball.albedo * (density * ball.phase.at(sin2, cos2));
            }
        }
        for smoke in &self.boxes {
            let local = smoke.turn * (point - smoke.shift);
            if local.cmplt(smoke.min).any() || local.cmpgt(smoke.max).any() {
                continue;
            }
            let grid = &smoke.samples;
            let extinction = f64::from(grid.scale()) * smoke.density(local);
            let mut albedo = grid.albedo().as_dvec3();
            if !grid.albedo_samples().is_empty() {
                albedo *= smoke.mean(local, |index| grid.albedo_samples()[index].as_dvec3());
            }
            let phase = Phase::from(grid.phase()).at(sin2, cos2);
            scattering += albedo * grid.tint().as_dvec3() * (extinction * phase);
            if !grid.emission().is_empty() {
                emission += smoke.mean(local, |index| grid.emission()[index].as_dvec3());
            }
        }
        (scattering, emission)
    }

    /// Whether anything emits light.
    pub fn emits(&self) -> bool {
        let mut boxes = self.boxes.iter();
        boxes.any(|smoke| !smoke.samples.emission().is_empty())
    }

    /// Appends where along a line the coefficients of grids and particles have a kink.
    pub fn edges(&self, line: &Line, edges: &mut Vec<f64>) {
        for ball in &self.balls {
            let (middle, offset) = line.nearest(ball.centre);
            let half2 = ball.radius * ball.radius - offset.length_squared();
            if half2 > 0.0 {
                edges.extend([middle - half2.sqrt(), middle + half2.sqrt()]);
            }
        }
        for smoke in &self.boxes {
            let origin = smoke.turn * (line.origin - smoke.shift);
            smoke.crossings(origin, smoke.turn * line.direction, line.length, edges);
        }
    }
}

impl Ball {
    fn optical_depth(&self, point: DVec3, towards: DVec3, distance: f64) -> f64 {
        let offset = self.centre - point;
        let middle = offset.dot(towards);
        let b2 = towards.cross(offset).length_squared();
        let h2 = self.radius * self.radius - b2;
        if h2 <= 0.0 {
            return 0.0;
        }
        let half = h2.sqrt();
        let (from, to) = ((middle - half).max(0.0), (middle + half).min(distance));
        if from >= to {
            return 0.0;
        }
        let density = |t: f64| {
            let r2 = (b2 + (t - middle) * (t - middle)) / (self.radius * self.radius);
            match self.profile {
                Profile::Constant => 1.0,
                Profile::Soft => 1.0 - r2,
            }
        };
        self.sigma_t * gauss(from, to, density)
    }
}

impl SmokeBox {
    fn new(grid: &DensityGrid) -> Self {
        let matrix = grid.transform().matrix3;
        let [x, y, z] = [0, 1, 2].map(|axis| Vec3::from(matrix.col(axis)).as_dvec3());
        Self {
            min: grid.local_bounds().min().as_dvec3(),
            max: grid.local_bounds().max().as_dvec3(),
            turn: DMat3::from_cols(x, y, z).inverse(),
            shift: Vec3::from(grid.transform().translation).as_dvec3(),
            samples: grid.clone(),
        }
    }

    fn optical_depth(&self, point: DVec3, towards: DVec3, distance: f64) -> f64 {
        let (point, towards) = (self.turn * (point - self.shift), self.turn * towards);
        let mut crossings = Vec::new();
        self.crossings(point, towards, distance, &mut crossings);
        crossings.sort_by(f64::total_cmp);
        let density = |t: f64| self.density(point + t * towards);
        let parts = crossings.windows(2);
        let sum: f64 = parts.map(|ends| gauss(ends[0], ends[1], density)).sum();
        f64::from(self.samples.scale()) * sum
    }

    /// Appends where a path in the space of the box, of this length, enters and leaves it,
    /// and where it crosses from one cell to another.
    fn crossings(&self, point: DVec3, towards: DVec3, distance: f64, crossings: &mut Vec<f64>) {
        let (mut from, mut to) = (0.0_f64, distance);
        for axis in 0..3 {
            let low = self.min[axis] - point[axis];
            let high = self.max[axis] - point[axis];
            if towards[axis] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return;
                }
                continue;
            }
            let (a, b) = (low / towards[axis], high / towards[axis]);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        if from >= to {
            return;
        }
        crossings.extend([from, to]);
        for axis in 0..3 {
            let samples = self.samples.resolution()[axis];
            let cells = match self.samples.interpolation() {
                Interpolation::Constant => samples,
                Interpolation::Linear => (samples - 1).max(1),
            };
            let size = (self.max[axis] - self.min[axis]) / f64::from(cells);
            for plane in 1..cells {
                let at = self.min[axis] + size * f64::from(plane) - point[axis];
                let t = at / towards[axis];
                if from < t && t < to {
                    crossings.push(t);
                }
            }
        }
    }

    fn density(&self, point: DVec3) -> f64 {
        let density = |index: usize| DVec3::splat(f64::from(self.samples.density()[index]));
        self.mean(point, density).x
    }

    /// The mean of what `value` tells of samples, weighted by hat functions around them, at
    /// a point in the space of the box.
    fn mean(&self, point: DVec3, value: impl Fn(usize) -> DVec3) -> DVec3 {
        let counts = self.samples.resolution().map(|count| count as usize);
        let share = (point - self.min) / (self.max - self.min);
        let value = |x: usize, y: usize, z: usize| value(x + counts[0] * (y + counts[1] * z));
        match self.samples.interpolation() {
            Interpolation::Constant => {
                let cell = |axis: usize| {
                    let cell = (share[axis] * counts[axis] as f64).floor();
                    (cell.max(0.0) as usize).min(counts[axis] - 1)
                };
                value(cell(0), cell(1), cell(2))
            }
            Interpolation::Linear => {
                // Sums of hat functions around the samples.
                let hats = |axis: usize| {
                    let at = (share[axis] * (counts[axis] - 1) as f64).max(0.0);
                    let first = (at.floor() as usize).min(counts[axis] - 1);
                    let last = (first + 1).min(counts[axis] - 1);
                    [(first, 1.0 - at.fract()), (last, at.fract())]
                };
                let mut sum = DVec3::ZERO;
                for (x, wx) in hats(0) {
                    for (y, wy) in hats(1) {
                        for (z, wz) in hats(2) {
                            sum += wx * wy * wz * value(x, y, z);
                        }
                    }
                }
                sum
            }
        }
    }
}

/// The integral by Gauss's rule of three nodes, exact up to degree 5.
fn gauss(from: f64, to: f64, density: impl Fn(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let node = half * 0.6_f64.sqrt();
    let sides = density(middle - node) + density(middle + node);
    half * (5.0 * sides + 8.0 * density(middle)) / 9.0
}

/// The light that `medium` scatters along each ray into its origin, as
/// [`reference`](super::image::reference) has it, but behind translucent
/// `casters` too. The stretches of each ray that the casters may shadow are cut
/// into about `parts`, half of them between the ends of balls around casters
/// and of their shadows, half by length. An endless stretch counts for ten mean
/// free paths, beyond which the share of light in its last part stays.
///
/// The bound is an estimate: the difference between taking the transmittance
/// of each part at its middle, and as the mean of two points. At the edges of
/// strands it is generous.
///
/// `progress` is called from any thread with the number of rays done.
pub fn reference(
    rays: &[Ray],
    emitters: &[Emitter],
    medium: &Medium,
    geometry: &Geometry,
    casters: &[Translucent],
    parts: u32,
    progress: &(dyn Fn(usize) + Sync),
) -> Reference {
    let world = World {
        lamps: emitters.iter().map(Lamp::new).collect(),
        fog: Fog::new(medium),
        blockers: Blockers::new(geometry),
        translucency: Translucency::new(casters),
        parts: parts.max(1),
    };
    let pixels: Vec<(DVec3, f64)> = rays
        .par_chunks(16)
        .flat_map_iter(|chunk| {
            let pixels: Vec<_> = chunk.iter().map(|ray| world.light(ray)).collect();
            progress(chunk.len());
            pixels
        })
        .collect();
    Reference {
        radiance: pixels.iter().map(|pixel| pixel.0.to_array()).collect(),
        bound: pixels.iter().map(|pixel| pixel.1).collect(),
    }
}

struct World {
    lamps: Vec<Lamp>,
    fog: Fog,
    blockers: Blockers,
    translucency: Translucency,
    parts: u32,
}

impl World {
    fn light(&self, ray: &Ray) -> (DVec3, f64) {
        let line = Line::new(ray);
        let (mut sum, mut bound) = (DVec3::ZERO, 0.0);
        if self.fog.sigma_s == DVec3::ZERO {
            return (sum, bound);
        }
        for lamp in &self.lamps {
            let Some(reach) = reach(&line, lamp, &self.fog) else {
                continue;
            };
            let mut lit = Vec::new();
            self.blockers
                .lit(&line, lamp, reach, Search::Tree, &mut lit);
            let translucency = self.translucency.between(&line, lamp);
            let shades = Shades::new(&line, lamp, translucency.balls_around());
            let visit = |part: Span, sampled: Span| {
                let mut airlight = Airlight::new(&line, &self.fog);
                airlight.add_off_the_light(lamp, reach, &[part]);
                let light = airlight.total(Tolerance::relative(1e-6));
                let [first, middle, last] = [0.25, 0.5, 0.75].map(|share| {
                    let x = sampled.start + share * (sampled.end - sampled.start);
                    translucency.transmittances(lamp, line.at(x))
                });
                let mean = 0.5 * (first + last);
                sum += mean * light.value;
                bound += ((mean - middle).abs() * light.value).max_element() + light.bound;
            };
            shades.cut(&lit, self.parts, far(self.fog.sigma_t), visit);
        }
        (sum, bound)
    }
}

/// Ten mean free paths where they are longest, but not endless; a channel
/// without extinction scatters nothing.
fn far(sigma_t: DVec3) -> f64 {
    let channels = sigma_t.to_array().into_iter();
    let least = channels.filter(|&sigma_t| sigma_t > 0.0);
    10.0 / least.fold(f64::INFINITY, f64::min).clamp(1e-50, 1e50)
}

#[cfg(test)]
mod tests {
    use scene::{Particle, Particles, StrandPoint, Strands};

    use super::*;

    #[test]
    fn single_casters_let_pass_what_their_definition_says() {
        let sun = Lamp::new(&Emitter::directional(Vec3::NEG_Y, Vec3::ONE).expect("a sun"));
        let puff = Particle {
            centre: Vec3::ZERO,
            radius: 2.0,
            sigma_t: 0.25,
        };
        for (profile, tau) in [(Profile::Constant, 1.0_f64), (Profile::Soft, 2.0 / 3.0)] {
            let all = Particles::new(vec![puff], profile).expect("a sound puff");
            let translucency = Translucency::new(&[all.into()]);
            let at = |y: f64| translucency.transmittance(&sun, DVec3::new(0.0, y, 0.0));
            assert!((at(-3.0) - (-tau).exp()).abs() < 1e-12);
            assert!((at(0.0) - (-0.5 * tau).exp()).abs() < 1e-12);
            assert_eq!(at(2.0), 1.0);
        }
        let point = |x: f32| StrandPoint {
            position: Vec3::new(x, 1.0, 0.0),
            thickness: 0.2,
            opacity: 0.7,
        };
        let strands = Strands::new(vec![point(-1.0), point(1.0)], vec![2]).expect("a strand");
        let translucency = Translucency::new(&[strands.into()]);
        for (x, z, passed) in [(0.9, 0.09, 0.3), (0.9, 0.11, 1.0), (1.1, 0.0, 1.0)] {
            let found = translucency.transmittance(&sun, DVec3::new(x, 0.0, z));
            assert!((found - passed).abs() < 1e-6, "{x} {z}");
        }
        assert_eq!(
            translucency.transmittance(&sun, DVec3::new(0.0, 1.1, 0.0)),
            1.0
        );
    }

    /// The light of one ray over open ground, without and with a puff between
    /// the lamp and the ray: by 20,000 parts of equal angles, and as the
    /// reference has it.
    fn puffed(emitter: &Emitter, sigma_s: Vec3) -> ([DVec3; 2], Reference) {
        use std::f64::consts::FRAC_PI_2;

        use scene::{Mesh, PhaseFunction, Scene};

        let medium = Medium::new(sigma_s, Vec3::ZERO, PhaseFunction::Isotropic).expect("a fog");
        let ground = Scene::from(Mesh {
            positions: vec![
                Vec3::Y * -9.0,
                Vec3::new(1.0, -9.0, 0.0),
                Vec3::new(0.0, -9.0, 1.0),
            ],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        });
        let geometry = Geometry::new(&ground).expect("a triangle");
        let puff = Particle {
            centre: Vec3::new(1.0, 1.5, 0.0),
            radius: 1.0,
            sigma_t: 2.0,
        };
        let puffs = [Particles::new(vec![puff], Profile::Soft)
            .expect("a puff")
            .into()];
        let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X, f32::INFINITY).expect("a ray");
        let (line, lamp, fog) = (Line::new(&ray), Lamp::new(emitter), Fog::new(&medium));
        let translucency = Translucency::new(&puffs);
        let reach = reach(&line, &lamp, &fog).expect("an endless ray");
        let first = (-5.0_f64 / 3.0).atan();
        let end_of = |step: u32| {
            let share = f64::from(step) / 20_000.0;
            5.0 + 3.0 * (first + share * (FRAC_PI_2 - first)).tan()
        };
        let (mut sums, mut start) = ([DVec3::ZERO; 2], 0.0);
        for step in 1..20_000 {
            let end = end_of(step);
            let mut airlight = Airlight::new(&line, &fog);
            // The last ends in the sky, far behind the shadow.
            let part = Span::new(start, if step == 19_999 { f64::INFINITY } else { end });
            airlight.add_off_the_light(&lamp, reach, &[part]);
            let light = airlight.total(Tolerance::relative(1e-6)).value;
            sums[0] += light;
            sums[1] += light * translucency.transmittance(&lamp, line.at(0.5 * (start + end)));
            start = end;
        }
        let emitters = std::slice::from_ref(emitter);
        let found = super::reference(&[ray], emitters, &medium, &geometry, &puffs, 64, &|_| {});
        (sums, found)
    }

    #[test]
    fn thin_fog_and_fog_of_one_colour_are_sampled_where_the_shadow_is() {
        let position = Vec3::new(0.0, 3.0, 0.0);
        let even = scene::Emission::Isotropic;
        let emitters = [
            Emitter::point(position, Vec3::ONE, f32::INFINITY, even).expect("a lamp"),
            Emitter::directional(Vec3::new(0.3, -1.0, 0.0), Vec3::ONE).expect("a sun"),
        ];
        for emitter in &emitters {
            for sigma_s in [
                Vec3::splat(0.1),
                Vec3::splat(1e-4),
                Vec3::new(0.1, 0.0, 0.02),
            ] {
                let ([clear, truth], found) = puffed(emitter, sigma_s);
                let (radiance, bound) = (DVec3::from_array(found.radiance[0]), found.bound[0]);
                let taken = (clear - truth).max_element();
                let error = (radiance - truth).abs().max_element();
                println!("{clear} {truth} {radiance} {bound}");
                assert!(taken > 0.0 && bound < 0.02 * taken, "{bound} of {taken}");
                assert!(error < 0.01 * taken, "{error} of {taken}");
            }
        }
    }
}

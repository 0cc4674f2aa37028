//! The double march that every renderer begins with: steps along the eye ray, and from each of
//! them steps to the light.

use glam::{Mat3, Vec3};

use super::gather::even_depth;
use crate::scene::{
    Bounds, DensityGrid, Emitter, HeightFog, Interpolation, Media, Medium, Particles,
    PhaseFunction, Profile, Ray, ScatteringAngle, Translucent,
};
use crate::visibility::PointVisibility;
use crate::{Interval, LightPath};

/// A march through the media along the eye ray, with half of its steps in smoke, and from the
/// middle of each step a march of as many steps towards the light. All coefficients are sampled
/// at the middles of steps. Homogeneous fog, and fog that thins out, attenuate light on its way
/// from the lamp in closed form.
///
/// Where steps are longer than the features of the density, in either direction, the error is
/// of first order in their length. Other gathers through smoke are compared with this one. `V`
/// gives the visibility past opaque casters. Strands cast no shadows, and hair in front of the
/// eye does not dim what is behind it.
#[derive(Debug)]
pub struct DoubleMarch<'a, V> {
    emitter: &'a Emitter,
    media: &'a Media<'a>,
    fields: Vec<Field<'a>>,
    /// Number of fields that are fog; the others are grids and particles.
    fogs: usize,
    visibility: V,
    steps: [u32; 2],
}

/// A medium in the form in which it is sampled.
#[derive(Debug)]
struct Field<'a> {
    density: Density<'a>,
    /// The box that it fills; `None` for all of space.
    bounds: Option<Bounds>,
    extinction: Vec3,
    scattering: Vec3,
    phase: PhaseFunction,
}

#[derive(Debug)]
enum Density<'a> {
    Even,
    Height(HeightFog),
    Grid(Samples<'a>),
    Balls(&'a Particles),
}

/// A grid in single precision.
#[derive(Debug)]
struct Samples<'a> {
    grid: &'a DensityGrid,
    corner: Vec3,
    to_cells: Mat3,
    last: [u32; 3],
}

impl<'a> Samples<'a> {
    fn new(grid: &'a DensityGrid) -> Self {
        let (corner, to_cells) = grid.cell_space();
        Self {
            grid,
            corner: corner.as_vec3(),
            to_cells: to_cells.as_mat3(),
            last: grid.cells().map(|count| count - 1),
        }
    }

    fn density(&self, point: Vec3) -> f32 {
        let place = self.to_cells * (point - self.corner);
        let end = Vec3::new(
            self.last[0] as f32 + 1.0,
            self.last[1] as f32 + 1.0,
            self.last[2] as f32 + 1.0,
        );
        if !(place.cmpge(Vec3::ZERO).all() && place.cmple(end).all()) {
            return 0.0;
        }
        let [nx, ny, nz] = self.grid.resolution().map(|count| count as usize);
        let cell = [0, 1, 2].map(|axis| (place[axis] as u32).min(self.last[axis]) as usize);
        let samples = self.grid.density();
        let at = |x: usize, y: usize, z: usize| samples[(z * ny + y) * nx + x];
        let [x, y, z] = cell;
        if self.grid.interpolation() == Interpolation::Constant {
            return at(x, y, z);
        }
        let share = place - Vec3::new(x as f32, y as f32, z as f32);
        let [u, v, w] = [
            (x + 1).min(nx - 1),
            (y + 1).min(ny - 1),
            (z + 1).min(nz - 1),
        ];
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let row = |y: usize, z: usize| mix(at(x, y, z), at(u, y, z), share.x);
        let slice = |z: usize| mix(row(y, z), row(v, z), share.y);
        mix(slice(z), slice(w), share.z)
    }
}

impl Field<'_> {
    fn albedo_of_samples(&self, point: Vec3) -> Vec3 {
        match &self.density {
            Density::Grid(Samples { grid, .. }) if !grid.albedo_samples().is_empty() => grid
                .cell_at(point.as_dvec3())
                .map_or(Vec3::ZERO, |(cell, place)| {
                    grid.albedo_in(cell, place).as_vec3()
                }),
            _ => Vec3::ONE,
        }
    }

    fn density(&self, point: Vec3) -> f32 {
        match &self.density {
            Density::Even => {
                let is_outside = |bounds: Bounds| !bounds.contains(point);
                f32::from(u8::from(!self.bounds.is_some_and(is_outside)))
            }
            Density::Height(fog) => fog.density(point.y.into()) as f32,
            Density::Grid(samples) => samples.density(point),
            Density::Balls(particles) => particles
                .all()
                .iter()
                .map(|ball| {
                    let share = (point - ball.centre).length_squared() / ball.radius.powi(2);
                    let density = match particles.profile() {
                        Profile::Constant => 1.0,
                        Profile::Soft => 1.0 - share,
                    };
                    if share < 1.0 {
                        ball.sigma_t * density
                    } else {
                        0.0
                    }
                })
                .sum(),
        }
    }
}

/// Behind this optical depth nothing can be seen.
const OPAQUE: f32 = 100.0;

impl<'a, V: PointVisibility> DoubleMarch<'a, V> {
    /// `steps` steps along the eye ray, and as many towards the light; 0 counts as 1.
    pub fn new(
        emitter: &'a Emitter,
        media: &'a Media<'a>,
        translucent: &'a [Translucent],
        visibility: V,
        steps: [u32; 2],
    ) -> Self {
        let mut fields = Vec::new();
        if let Some(medium) = media.medium() {
            fields.push(Field {
                density: Density::Even,
                bounds: medium.bounds(),
                extinction: medium.sigma_t(),
                scattering: medium.sigma_s(),
                phase: medium.phase(),
            });
        }
        if let Some(fog) = media.height_fog() {
            fields.push(Field {
                density: Density::Height(*fog),
                bounds: None,
                extinction: fog.sigma_t(),
                scattering: fog.sigma_s(),
                phase: fog.phase(),
            });
        }
        let fogs = fields.len();
        for caster in translucent {
            match caster {
                Translucent::Grid(grid) => {
                    let extinction = grid.scale() * grid.tint();
                    fields.push(Field {
                        density: Density::Grid(Samples::new(grid)),
                        bounds: Some(grid.occupied_bounds()),
                        extinction,
                        // If samples have albedos, these are multiplied by those of the grid.
                        scattering: match grid.albedo_samples() {
                            [] => extinction * grid.albedo(),
                            _ => extinction,
                        },
                        phase: grid.phase(),
                    });
                }
                Translucent::Particles(particles) => fields.push(Field {
                    density: Density::Balls(particles),
                    bounds: particles.bounds(),
                    extinction: Vec3::ONE,
                    scattering: particles.albedo(),
                    phase: particles.phase(),
                }),
                Translucent::Strands(_) => {}
            }
        }
        Self {
            emitter,
            media,
            fogs,
            fields,
            visibility,
            steps: steps.map(|count| count.max(1)),
        }
    }

    /// The part of a line in which there is any medium; a homogeneous medium counts as far as
    /// it can be seen.
    fn extent(fields: &[Field<'_>], origin: Vec3, direction: Vec3, whole: Interval) -> Interval {
        /// How far it can be seen, in mean free paths.
        const SEEN: f32 = 10.0;
        let mut extent: Option<Interval> = None;
        for field in fields {
            let part = match field.bounds {
                Some(bounds) => bounds.clip(origin, direction, whole),
                None => {
                    let sigma = field.extinction.max_element() * field.density(origin).max(1e-30);
                    let end = whole.end.min(whole.start + SEEN / sigma.max(1e-30));
                    Some(Interval::new(whole.start, end))
                }
            };
            extent = match (extent, part) {
                (Some(a), Some(b)) => Some(Interval::new(a.start.min(b.start), a.end.max(b.end))),
                (a, b) => a.or(b),
            };
        }
        extent.unwrap_or(Interval::new(whole.start, whole.start))
    }

    fn extinction(fields: &[Field<'_>], point: Vec3) -> Vec3 {
        let fields = fields.iter();
        fields
            .map(|field| field.extinction * field.density(point))
            .sum()
    }

    /// The optical depth of smoke along a line, by the midpoint rule.
    fn depth(&self, origin: Vec3, direction: Vec3, length: f32) -> Vec3 {
        let smoke = &self.fields[self.fogs..];
        let part = Self::extent(smoke, origin, direction, Interval::new(0.0, length));
        if !(part.end > part.start) {
            return Vec3::ZERO;
        }
        let count = self.steps[1];
        let step = part.length() / count as f32;
        let depth: Vec3 = (0..count)
            .map(|i| origin + direction * (part.start + (i as f32 + 0.5) * step))
            .map(|at| Self::extinction(smoke, at))
            .sum();
        depth * step
    }

    /// The light of the lamp that is scattered towards the eye along a ray.
    pub fn radiance(&self, ray: &Ray) -> Vec3 {
        let Some(path) = LightPath::new(ray, self.emitter, &Medium::VACUUM) else {
            return Vec3::ZERO;
        };
        let path = path.off_the_light();
        let whole = Interval::new(0.0, ray.length());
        let (mut sum, mut depth) = (Vec3::ZERO, Vec3::ZERO);
        for (part, count) in self.parts(ray, whole) {
            let step = part.length() / count as f32;
            for i in 0..count {
                let x = part.start + (i as f32 + 0.5) * step;
                let at = ray.at(x);
                let own = Self::extinction(&self.fields, at) * step;
                if own == Vec3::ZERO {
                    continue;
                }
                if !(own.is_finite() && depth.min_element() < OPAQUE) {
                    // Fog far below the eye may be denser than floats can express.
                    return sum;
                }
                let is_lit = path.span().start <= x && x <= path.span().end;
                if is_lit {
                    let through = (-(depth + 0.5 * own)).exp();
                    sum += through * step * self.scattered(&path, x, at);
                }
                depth += own;
            }
        }
        sum
    }

    /// Parts of a ray, each with a number of steps of equal length: half of all steps in smoke,
    /// the others in front of it and behind it.
    fn parts(&self, ray: &Ray, whole: Interval) -> Vec<(Interval, u32)> {
        let steps = self.steps[0];
        let extent = |fields| Self::extent(fields, ray.origin(), ray.direction(), whole);
        let (all, smoke) = (extent(&self.fields), extent(&self.fields[self.fogs..]));
        let beside = all.length() - smoke.length();
        if !(smoke.length() > 0.0 && beside > 0.0) {
            return vec![(all, steps)];
        }
        let before = Interval::new(all.start, smoke.start);
        let behind = Interval::new(smoke.end, all.end);
        let share = |part: Interval| 0.5 * part.length() / beside;
        [
            (before, share(before)),
            (smoke, 0.5),
            (behind, share(behind)),
        ]
        .into_iter()
        .filter(|(part, _)| part.length() > 0.0)
        .map(|(part, share)| (part, ((steps as f32 * share).round() as u32).max(1)))
        .collect()
    }

    fn scattered(&self, path: &LightPath<'_>, x: f32, at: Vec3) -> Vec3 {
        let (to_light, distance, light, angle) = match self.emitter {
            Emitter::Directional(sun) => {
                let angle = path.sun_angle(sun);
                (-sun.direction(), f32::INFINITY, sun.irradiance(), angle)
            }
            Emitter::Point(point) => {
                let (direction, d) = path.from_light(x - path.foot());
                let mut light = path.intensity(point, direction) / (d * d);
                if point.fades() {
                    light *= point.window_inside(d);
                }
                let angle = ScatteringAngle::from_foot(x - path.foot(), path.h());
                (-direction, d, light, angle)
            }
        };
        let light = self.visibility.visibility(at) * light;
        if light == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let spread: Vec3 = self
            .fields
            .iter()
            .map(|field| {
                let scattering = field.scattering * field.albedo_of_samples(at);
                scattering * (field.density(at) * field.phase.value(angle))
            })
            .sum();
        let fog = even_depth(self.media, at.as_dvec3(), to_light, distance).as_vec3();
        spread * light * (-fog - self.depth(at, to_light, distance)).exp()
    }
}

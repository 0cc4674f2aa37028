//! The rays of a picture, and the light of the surfaces at their ends.

use std::f32::consts::PI;

use glam::Vec3;
use gpu_backend::Cpu;

use crate::Ray;
use crate::emitter::Emitter;
use crate::scene::{Camera, Geometry, Material, Medium, Scene};
use crate::trace::{Hit, Tracer};
use crate::visibility::SurfaceShadow;

/// Largest width and height of a picture.
pub const MAX_SIDE: u32 = 16384;

/// A picture size that is not supported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a picture of {width} x {height} pixels was asked for, expected 1 to {MAX_SIDE} per side")]
pub struct SizeError {
    width: u32,
    height: u32,
}

/// One ray per pixel, through its centre, up to the first surface.
#[derive(Debug, Clone)]
pub struct View {
    width: u32,
    height: u32,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
}

impl View {
    /// The view of `camera`, traced against the scene.
    ///
    /// # Errors
    /// [`SizeError`] if a side is 0 or above [`MAX_SIDE`].
    pub fn new(
        cpu: &Cpu,
        camera: &Camera,
        tracer: &Tracer,
        width: u32,
        height: u32,
    ) -> Result<Self, SizeError> {
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
            return Err(SizeError { width, height });
        }
        let count = width as usize * height as usize;
        let traced: Vec<(Ray, Option<Hit>)> = cpu.map(count, |pixel| {
            let (row, column) = (pixel / width as usize, pixel % width as usize);
            let (x, y) = (column as f32 + 0.5, row as f32 + 0.5);
            let direction = camera.direction(x, y, width, height);
            let ray = Ray::new(camera.eye(), direction, f32::INFINITY)
                .expect("a camera has a finite eye and unit directions");
            match tracer.closest_hit(&ray) {
                Some(hit) => (ray.with_length(hit.distance), Some(hit)),
                None => (ray, None),
            }
        });
        let (rays, hits) = traced.into_iter().unzip();
        Ok(Self {
            width,
            height,
            rays,
            hits,
        })
    }

    /// Pixels per row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// One ray per pixel, row by row from the top.
    pub fn rays(&self) -> &[Ray] {
        &self.rays
    }

    /// What each ray ends on; `None` is the sky.
    pub fn hits(&self) -> &[Option<Hit>] {
        &self.hits
    }

    /// Radiance of the surfaces that reaches the eye through the medium, one
    /// RGB0 per ray:
    ///
    /// ```text
    /// exp(−σ_t D_s) [ L_emitted + albedo/π Σ E(light) cos θ V exp(−σ_t d) ]
    /// ```
    ///
    /// Surfaces are Lambertian and flat per triangle, both sides alike;
    /// shadows are traced. The sky is black. `scene` and `geometry` must be
    /// those the view was made from.
    pub fn surface_radiance(
        &self,
        cpu: &Cpu,
        scene: &Scene,
        geometry: &Geometry,
        tracer: &Tracer,
        emitters: &[Emitter],
        medium: Option<&Medium>,
    ) -> Vec<[f32; 4]> {
        let traced: Vec<Lit<'_>> = emitters.iter().map(|emitter| (emitter, None)).collect();
        self.surface_radiance_with(cpu, scene, geometry, tracer, &traced, medium)
    }

    /// [`View::surface_radiance`] with shadows from the source that belongs to
    /// a light, where it has one.
    pub fn surface_radiance_with(
        &self,
        cpu: &Cpu,
        scene: &Scene,
        geometry: &Geometry,
        tracer: &Tracer,
        lights: &[Lit<'_>],
        medium: Option<&Medium>,
    ) -> Vec<[f32; 4]> {
        self.lit_surfaces(cpu, scene, geometry, medium, |surface| {
            lights.iter().fold(Vec3::ZERO, |sum, &(emitter, shadow)| {
                let reaching = |to_light, distance| match shadow {
                    Some(shadow) => shadow.visibility(surface.point, surface.normal),
                    None => surface.traced(tracer, to_light, distance),
                };
                sum + surface.reflected(emitter, medium, reaching)
            })
        })
    }

    /// [`View::surface_radiance`] behind something translucent: traced shadows,
    /// times the share of each light that the source beside it lets through.
    pub fn surface_radiance_behind(
        &self,
        cpu: &Cpu,
        scene: &Scene,
        geometry: &Geometry,
        tracer: &Tracer,
        lights: &[(&Emitter, &dyn SurfaceShadow)],
        medium: Option<&Medium>,
    ) -> Vec<[f32; 4]> {
        self.lit_surfaces(cpu, scene, geometry, medium, |surface| {
            lights.iter().fold(Vec3::ZERO, |sum, (emitter, shadow)| {
                let reaching = |to_light, distance| {
                    let traced = surface.traced(tracer, to_light, distance);
                    if traced == 0.0 {
                        return 0.0;
                    }
                    traced * shadow.visibility(surface.point, surface.normal)
                };
                sum + surface.reflected(emitter, medium, reaching)
            })
        })
    }

    /// What surfaces emit and reflect, as it reaches the eye.
    fn lit_surfaces(
        &self,
        cpu: &Cpu,
        scene: &Scene,
        geometry: &Geometry,
        medium: Option<&Medium>,
        reflected: impl Fn(&Surface) -> Vec3 + Sync + Send,
    ) -> Vec<[f32; 4]> {
        cpu.map(self.rays.len(), |pixel| {
            let (ray, Some(hit)) = (&self.rays[pixel], self.hits[pixel]) else {
                return [0.0; 4];
            };
            let surface = Surface::new(ray, &hit, scene, geometry);
            let radiance = surface.emitted + reflected(&surface);
            let reaching =
                radiance * transmittance(medium, ray.origin(), ray.direction(), hit.distance);
            [reaching.x, reaching.y, reaching.z, 0.0]
        })
    }
}

fn transmittance(medium: Option<&Medium>, start: Vec3, direction: Vec3, length: f32) -> Vec3 {
    match medium {
        None => Vec3::ONE,
        // 0 · ∞: a medium that extinguishes nothing does so over any length.
        Some(medium) if medium.sigma_t() == Vec3::ZERO => Vec3::ONE,
        Some(medium) => (-medium.sigma_t() * medium.length_inside(start, direction, length)).exp(),
    }
}

/// A light and where its shadows on surfaces come from; traced if from nowhere.
pub type Lit<'a> = (&'a Emitter, Option<&'a dyn SurfaceShadow>);

/// A point of a surface, ready to be lit.
struct Surface {
    point: Vec3,
    /// Towards the eye's side.
    normal: Vec3,
    albedo: Vec3,
    emitted: Vec3,
    /// How far shadow rays start from the surface.
    offset: f32,
}

impl Surface {
    fn new(ray: &Ray, hit: &Hit, scene: &Scene, geometry: &Geometry) -> Self {
        let [a, b, c] = geometry.triangles()[hit.triangle as usize];
        let outside = (b - a)
            .as_dvec3()
            .cross((c - a).as_dvec3())
            .normalize()
            .as_vec3();
        let towards_eye = outside.dot(ray.direction()) < 0.0;
        let normal = if towards_eye { outside } else { -outside };
        let (material, coordinates) = geometry.surface(scene, hit.triangle as usize, hit.u, hit.v);
        let plain = Material::default();
        let material = material.unwrap_or(&plain);
        let texture = match (&material.base_color_texture, coordinates) {
            (Some(texture), Some(uv)) => texture.repeat(uv),
            _ => Vec3::ONE,
        };
        let point = ray.at(hit.distance);
        Self {
            point,
            normal,
            albedo: material.base_color * texture,
            emitted: material.emitted,
            // Far above the rounding of the point, far below any detail.
            offset: 1e-5 * (hit.distance + point.abs().max_element()),
        }
    }

    /// Share of the light that gets here from where it is.
    fn traced(&self, tracer: &Tracer, to_light: Vec3, distance: f32) -> f32 {
        let start = self.point + self.offset * self.normal;
        if tracer.occluded(start, to_light, 0.0, distance) {
            0.0
        } else {
            1.0
        }
    }

    /// `reaching` is asked for the share of the light that is not blocked,
    /// where the rest of it comes to anything, by direction and distance.
    fn reflected(
        &self,
        emitter: &Emitter,
        medium: Option<&Medium>,
        reaching: impl Fn(Vec3, f32) -> f32,
    ) -> Vec3 {
        let (to_light, distance, irradiance) = match emitter {
            Emitter::Directional(sun) => (-sun.direction(), f32::INFINITY, sun.irradiance()),
            Emitter::Point(point) => {
                let offset = point.position() - self.point;
                let distance = offset.length();
                if distance == 0.0 || distance > point.range() {
                    return Vec3::ZERO;
                }
                let to_light = offset / distance;
                let intensity = point.intensity() * point.emission().factor(-to_light);
                (to_light, distance, intensity / (distance * distance))
            }
        };
        let cos = self.normal.dot(to_light);
        if cos <= 0.0 || irradiance == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let share = reaching(to_light, distance);
        if share == 0.0 {
            return Vec3::ZERO;
        }
        // Sunlight in an unbounded medium has been attenuated "before": the
        // irradiance is the one that arrives.
        let through = match (emitter, medium) {
            (Emitter::Directional(_), Some(medium)) if medium.bounds().is_none() => Vec3::ONE,
            _ => transmittance(medium, self.point, to_light, distance),
        };
        self.albedo / PI * irradiance * cos * through * share
    }
}

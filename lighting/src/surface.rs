//! The light of the surfaces of a view that reaches the eye.

use std::f32::consts::PI;

use glam::Vec3;
use gpu_backend::Cpu;

use crate::SurfacePoint;
use crate::culling::{Clusters, RayTiles, TileLights, is_worthwhile};
use crate::scene::trace::{Hit, Pane, Tracer};
use crate::scene::view::View;
use crate::scene::{Emitter, Geometry, Media, Medium, Ray, Scene};
use crate::surface_point::{Arriving, transmittance};
use crate::visibility::SurfaceShadow;

/// Radiance of the surfaces that reaches the eye through the medium, one RGB0 per ray:
///
/// ```text
/// exp(−σ_t D_s) [ L_emitted + albedo/π Σ E(light) cos θ V exp(−σ_t d) ]
/// ```
///
/// Smoke, and fog that thins out with altitude, dim what the eye sees. On the way from a light,
/// such fog is in closed form; smoke is part of V where the shadows know it.
///
/// Surfaces are Lambertian and flat within each triangle, and both sides are alike. Shadows are
/// traced: V is what all triangles on the way let through. Every point asks the lights of its
/// [cluster](crate::culling::Clusters), which changes no bit. Each see-through surface, or
/// [pane](View::panes), adds its own light and multiplies the light from behind by its
/// transmittance. Everything behind the [cover](View::cover) of the view is dimmed by it. The
/// sky is black. `scene` and `geometry` must be those that the view was made from.
pub fn radiance(
    cpu: &Cpu,
    view: &View,
    scene: &Scene,
    geometry: &Geometry,
    tracer: &Tracer,
    emitters: &[Emitter],
    medium: Option<&Medium>,
) -> Vec<[f32; 4]> {
    let traced: Vec<Lit<'_>> = emitters.iter().map(|emitter| (emitter, None)).collect();
    radiance_with(cpu, view, scene, geometry, tracer, &traced, medium)
}

/// [`radiance`] in which opaque casters' shadows come from the source beside a light, if it has
/// one. Shadows of see-through surfaces are traced.
pub fn radiance_with(
    cpu: &Cpu,
    view: &View,
    scene: &Scene,
    geometry: &Geometry,
    tracer: &Tracer,
    lights: &[Lit<'_>],
    medium: Option<&Medium>,
) -> Vec<[f32; 4]> {
    let emitters: Vec<&Emitter> = lights.iter().map(|(emitter, _)| *emitter).collect();
    let lit = LitView {
        view,
        scene,
        geometry,
        emitters: &emitters,
        medium,
    };
    lit.radiance(cpu, |surface, light| {
        let (emitter, shadow) = lights[light];
        surface.reflected(
            emitter,
            (scene, medium),
            |to_light, distance| match shadow {
                Some(shadow) => {
                    let known = shadow.visibility(surface.point, surface.normal);
                    known * surface.through_panes(tracer, to_light, distance)
                }
                None => surface.traced(tracer, to_light, distance),
            },
        )
    })
}

/// [`radiance`] with translucent casters: shadows are traced, and the light is multiplied by
/// the share that the source beside each light lets through.
pub fn radiance_behind(
    cpu: &Cpu,
    view: &View,
    scene: &Scene,
    geometry: &Geometry,
    tracer: &Tracer,
    lights: &[(&Emitter, &dyn SurfaceShadow)],
    medium: Option<&Medium>,
) -> Vec<[f32; 4]> {
    let emitters: Vec<&Emitter> = lights.iter().map(|(emitter, _)| *emitter).collect();
    let lit = LitView {
        view,
        scene,
        geometry,
        emitters: &emitters,
        medium,
    };
    lit.radiance(cpu, |surface, light| {
        let (emitter, shadow) = lights[light];
        surface.reflected(emitter, (scene, medium), |to_light, distance| {
            let traced = surface.traced(tracer, to_light, distance);
            if traced == Vec3::ZERO {
                return traced;
            }
            traced * shadow.visibility(surface.point, surface.normal)
        })
    })
}

/// The surfaces of a view, one per ray, for [`surface_scattering`](crate::surface_scattering)
/// and [`environment`](crate::environment) to light; nothing covers their sky. A ray to the sky
/// has a point that reflects nothing. Surfaces behind [panes](View::panes) are as bright as
/// these let through; the panes themselves are in [`points_of_panes`]. `scene` and `geometry`
/// must be those that the view was made from.
pub fn points(
    cpu: &Cpu,
    view: &View,
    scene: &Scene,
    geometry: &Geometry,
    medium: Option<&Medium>,
) -> Vec<SurfacePoint> {
    let heterogeneous = heterogeneous(scene);
    cpu.map(view.rays().len(), |pixel| {
        let (ray, Some(hit)) = (&view.rays()[pixel], view.hits()[pixel]) else {
            return SurfacePoint::default();
        };
        let through = view.through_panes(pixel)
            * through_heterogeneous(&heterogeneous, ray, &hit)
            * view.cover().share(pixel, hit.distance);
        Surface::new(ray, &hit, scene, geometry).seen(ray, &hit, medium, through)
    })
}

/// The [panes](View::panes) in front of those surfaces, each with the number of its ray: ray
/// after ray, the nearest first, each as bright as those in front of it let through.
pub fn points_of_panes(
    cpu: &Cpu,
    view: &View,
    scene: &Scene,
    geometry: &Geometry,
    medium: Option<&Medium>,
) -> Vec<(usize, SurfacePoint)> {
    let heterogeneous = heterogeneous(scene);
    let of_ray = |pixel: usize| {
        let ray = &view.rays()[pixel];
        let mut through = Vec3::ONE;
        let point = |pane: &Pane| {
            let surface = Surface::new(ray, &pane.hit, scene, geometry);
            let before = through
                * through_heterogeneous(&heterogeneous, ray, &pane.hit)
                * view.cover().share(pixel, pane.hit.distance);
            let point = surface.seen(ray, &pane.hit, medium, before);
            through *= pane.transmittance;
            (pixel, point)
        };
        view.panes(pixel).iter().map(point).collect::<Vec<_>>()
    };
    let points = cpu.map(view.rays().len(), of_ray);
    points.into_iter().flatten().collect()
}

/// The same points with their openness: the share of the sky over each that no triangle covers.
/// It is found by `rays` rays (0 counts as 1), so it is a multiple of `1/rays`, with an error
/// of at most about `0.5/√rays`. A see-through surface covers the share of the light that it
/// holds back, in the mean of the colour channels.
///
/// The rays of a point are distributed by the cosine to its normal, and rotated from pixel to
/// pixel. Cost: `rays` shadow rays per point.
pub fn with_openness(
    cpu: &Cpu,
    points: &[SurfacePoint],
    tracer: &Tracer,
    rays: u32,
) -> Vec<SurfacePoint> {
    let rays = rays.max(1);
    cpu.map(points.len(), |index| {
        let point = points[index];
        if !point.reflects() {
            return point;
        }
        let (position, normal) = (point.position(), point.normal());
        let start = position + 1e-5 * (1.0 + position.abs().max_element()) * normal;
        let (u, v) = normal.any_orthonormal_pair();
        let turn = (index as f64 * GOLDEN_RATIO).fract() as f32;
        let open = (0..rays).map(|ray| {
            // A spiral over the disc under the hemisphere: an even distribution there is one by
            // cosine on the hemisphere.
            let r2 = (ray as f32 + 0.5) / rays as f32;
            let around = (f64::from(ray) * GOLDEN_RATIO).fract() as f32 + turn;
            let (sin, cos) = (2.0 * PI * around).sin_cos();
            let direction = r2.sqrt() * (u * cos + v * sin) + (1.0 - r2).sqrt() * normal;
            let share = tracer.transmittance(start, direction, 0.0, f32::INFINITY);
            f64::from(share.element_sum()) / 3.0
        });
        point.with_openness(open.sum::<f64>() as f32 / rays as f32)
    })
}

/// The golden ratio's fractional part, whose multiples are spread evenly modulo 1.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;

/// A view, and what lights it.
struct LitView<'a> {
    view: &'a View,
    scene: &'a Scene,
    geometry: &'a Geometry,
    emitters: &'a [&'a Emitter],
    medium: Option<&'a Medium>,
}

impl LitView<'_> {
    /// What surfaces emit and reflect to the eye. `reflected` gives what a surface reflects of
    /// the light of an index.
    fn radiance(
        &self,
        cpu: &Cpu,
        reflected: impl Fn(&Surface, usize) -> Vec3 + Sync + Send,
    ) -> Vec<[f32; 4]> {
        let rays = self.view.rays();
        let tiles = is_worthwhile(self.emitters.iter().copied())
            .then(|| RayTiles::new(cpu, rays, self.view.width(), None))
            .flatten();
        let clusters = tiles.as_ref().and_then(|tiles| {
            let lights = TileLights::new(cpu, tiles, self.emitters);
            // Without lists all lights are asked, which gives the same result.
            lights.and_then(|lights| Clusters::new(cpu, lights)).ok()
        });
        self.radiance_of(cpu, clusters.as_ref(), reflected)
    }

    /// The same for the lights that are in the lists, or for all lights.
    fn radiance_of(
        &self,
        cpu: &Cpu,
        clusters: Option<&Clusters<'_>>,
        reflected: impl Fn(&Surface, usize) -> Vec3 + Sync + Send,
    ) -> Vec<[f32; 4]> {
        let Self { view, medium, .. } = *self;
        let heterogeneous = heterogeneous(self.scene);
        cpu.map(view.rays().len(), |pixel| {
            let ray = &view.rays()[pixel];
            let light = |hit: &Hit| {
                let surface = Surface::new(ray, hit, self.scene, self.geometry);
                let add = |sum: Vec3, light: usize| sum + reflected(&surface, light);
                let reflected = match clusters {
                    Some(clusters) => clusters
                        .at(pixel, hit.distance)
                        .fold(Vec3::ZERO, |sum, light| add(sum, light as usize)),
                    None => (0..self.emitters.len()).fold(Vec3::ZERO, add),
                };
                let radiance = surface.emitted + reflected;
                let even = transmittance(medium, ray.origin(), ray.direction(), hit.distance);
                let cover = view.cover().share(pixel, hit.distance);
                radiance * even * through_heterogeneous(&heterogeneous, ray, hit) * cover
            };
            let behind = view.hits()[pixel].map_or(Vec3::ZERO, |hit| light(&hit));
            let panes = view.panes(pixel).iter().rev();
            let radiance = panes.fold(behind, |behind, pane| {
                light(&pane.hit) + pane.transmittance * behind
            });
            [radiance.x, radiance.y, radiance.z, 0.0]
        })
    }
}

/// The heterogeneous media in the air; `None` if there are none.
fn heterogeneous(scene: &Scene) -> Option<Media<'_>> {
    let media = Media::new(None, scene.height_fog.as_ref(), &scene.translucent);
    (!media.is_homogeneous()).then_some(media)
}

/// The share of light that they let through between the end of a ray and the eye.
fn through_heterogeneous(media: &Option<Media<'_>>, ray: &Ray, hit: &Hit) -> Vec3 {
    let share = |media: &Media<'_>| media.transmittance(ray, hit.distance);
    media.as_ref().map_or(Vec3::ONE, share)
}

/// A light, and the source of its shadows on surfaces; `None` for traced shadows.
pub type Lit<'a> = (&'a Emitter, Option<&'a dyn SurfaceShadow>);

/// A point of a surface that is to be lit.
struct Surface {
    point: Vec3,
    /// The unit normal on the side of the eye.
    normal: Vec3,
    albedo: Vec3,
    emitted: Vec3,
    /// The distance from the surface at which shadow rays start, m.
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
        let appearance = geometry.appearance(scene, hit.triangle as usize, hit.u, hit.v);
        let point = ray.at(hit.distance);
        Self {
            point,
            normal,
            albedo: appearance.albedo,
            emitted: if towards_eye {
                appearance.emitted
            } else {
                appearance.emitted_behind
            },
            // Far above the rounding of the point, and far below any detail.
            offset: 1e-5 * (hit.distance + point.abs().max_element()),
        }
    }

    /// The point as it is lit by other steps, with the share that it is seen through.
    fn seen(&self, ray: &Ray, hit: &Hit, medium: Option<&Medium>, through: Vec3) -> SurfacePoint {
        let fog = transmittance(medium, ray.origin(), ray.direction(), hit.distance);
        SurfacePoint::new(self.point, self.normal, self.albedo / PI * fog * through)
            .unwrap_or_default()
    }

    /// The share of a light at this distance that reaches the point past all triangles.
    fn traced(&self, tracer: &Tracer, to_light: Vec3, distance: f32) -> Vec3 {
        let start = self.point + self.offset * self.normal;
        tracer.transmittance(start, to_light, 0.0, distance)
    }

    /// The share of it that see-through surfaces let through.
    fn through_panes(&self, tracer: &Tracer, to_light: Vec3, distance: f32) -> Vec3 {
        let start = self.point + self.offset * self.normal;
        tracer.transmittance_of_panes(start, to_light, 0.0, distance)
    }

    /// The light that the point reflects. `visibility` is asked for the share of the light that
    /// arrives unblocked, by direction and distance, and only where there is any light.
    fn reflected(
        &self,
        emitter: &Emitter,
        (scene, medium): (&Scene, Option<&Medium>),
        visibility: impl Fn(Vec3, f32) -> Vec3,
    ) -> Vec3 {
        let Some(light) = Arriving::at(self.point, emitter) else {
            return Vec3::ZERO;
        };
        let cos = self.normal.dot(light.to_light);
        if cos <= 0.0 || light.irradiance == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let share = visibility(light.to_light, light.distance);
        if share == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let mut through = light.through(medium, self.point);
        if let Some(fog) = &scene.height_fog {
            let (y, slope) = (f64::from(self.point.y), f64::from(light.to_light.y));
            let depth = fog.depth_towards(y, slope, light.distance.into());
            through *= (-depth).exp().as_vec3();
        }
        self.albedo / PI * light.irradiance * cos * through * share
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use glam::{Affine3A, Quat};
    use reference::random::Random;

    use super::*;
    use crate::scene::{AlphaMode, Camera, Cone, Emission, Instance, Material, Mesh};

    /// A wall at z = −3 and, before it, a card at z = −1 of this material.
    fn card_before_a_wall(card: Option<Material>) -> (Scene, Geometry, View) {
        let square = |half: f32, z: f32, material| Mesh {
            positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| Vec3::new(half * x, half * y, z))
                .to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: Some(material),
            ..Mesh::default()
        };
        let mut scene = Scene {
            meshes: vec![square(9.0, -3.0, 0)],
            materials: vec![Material::default()],
            instances: vec![Instance::default()],
            ..Scene::default()
        };
        if let Some(card) = card {
            scene.meshes.push(square(1.0, -1.0, 1));
            scene.materials.push(card);
            scene.instances.push(Instance {
                mesh: 1,
                transform: Affine3A::IDENTITY,
                ..Instance::default()
            });
        }
        let geometry = Geometry::new(&scene).unwrap();
        let tracer = Tracer::new(&geometry);
        let camera = Camera::new(Vec3::ZERO, Quat::IDENTITY, 1.0).unwrap();
        let cpu = Cpu::new();
        let view = View::new(&cpu, &camera, &tracer, 9, 9).unwrap();
        (scene, geometry, view)
    }

    /// The same, lit by a sun from behind the eye.
    fn picture(card: Option<Material>) -> Vec<[f32; 4]> {
        let (scene, geometry, view) = card_before_a_wall(card);
        let (cpu, tracer) = (Cpu::new(), Tracer::new(&geometry));
        let sun = Emitter::directional(Vec3::new(0.01, 0.02, -1.0), Vec3::splat(PI)).unwrap();
        radiance(&cpu, &view, &scene, &geometry, &tracer, &[sun], None)
    }

    #[test]
    fn a_clear_window_before_a_wall_is_as_if_it_were_not_there() {
        let clear = Material {
            opacity: 0.0,
            alpha: AlphaMode::Blend,
            ..Material::default()
        };
        assert_eq!(picture(Some(clear)), picture(None));
    }

    /// Lamps and spotlights before a wall and a pane, and a sun in the midst of them.
    #[test]
    fn points_that_ask_their_clusters_have_the_bits_of_those_that_ask_all_lights() {
        let pane = Material {
            base_color: Vec3::splat(0.5),
            opacity: 0.25,
            alpha: AlphaMode::Blend,
            ..Material::default()
        };
        let (scene, geometry, view) = card_before_a_wall(Some(pane));
        let (cpu, tracer) = (Cpu::new(), Tracer::new(&geometry));
        let mut random = Random::new(1);
        let mut lights: Vec<Emitter> = (0..40)
            .map(|i| {
                let at = Vec3::from_array(random.vector(1.5)) + Vec3::new(0.0, 0.0, -2.0);
                let cone = Cone {
                    inner: 0.1,
                    outer: 0.5,
                };
                let axis = Vec3::from_array(random.vector(1.0)) + Vec3::splat(1e-3);
                let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, axis.normalize());
                let (range, emission) = match i % 3 {
                    0 => (0.7, Emission::Isotropic),
                    1 => (0.9, Emission::spot(rotation, cone, None).unwrap()),
                    _ => (f32::INFINITY, Emission::spot(rotation, cone, None).unwrap()),
                };
                Emitter::point(at, Vec3::new(1.0, 2.0, 3.0), range, emission).unwrap()
            })
            .collect();
        let sun = Emitter::directional(Vec3::new(0.01, 0.02, -1.0), Vec3::ONE).unwrap();
        lights.insert(20, sun);
        let found = radiance(&cpu, &view, &scene, &geometry, &tracer, &lights, None);
        let emitters: Vec<&Emitter> = lights.iter().collect();
        let lit = LitView {
            view: &view,
            scene: &scene,
            geometry: &geometry,
            emitters: &emitters,
            medium: None,
        };
        let reflected = |surface: &Surface, light: usize| {
            surface.reflected(emitters[light], (&scene, None), |to_light, distance| {
                surface.traced(&tracer, to_light, distance)
            })
        };
        let asked = AtomicUsize::new(0);
        let counted = |surface: &Surface, light: usize| {
            asked.fetch_add(1, Ordering::Relaxed);
            reflected(surface, light)
        };
        let bits = |picture: Vec<[f32; 4]>| -> Vec<[u32; 4]> {
            picture
                .iter()
                .map(|pixel| pixel.map(f32::to_bits))
                .collect()
        };
        let expected = bits(lit.radiance_of(&cpu, None, counted));
        assert!(bits(found) == expected);
        let of_all = asked.swap(0, Ordering::Relaxed);
        assert!(bits(lit.radiance(&cpu, counted)) == expected);
        let of_clusters = asked.load(Ordering::Relaxed);
        assert!(2 * of_clusters < of_all, "{of_clusters} of {of_all}");
    }

    #[test]
    fn a_pane_adds_its_own_light_to_what_it_lets_through_twice() {
        let without = picture(None)[40][0];
        let pane = Material {
            base_color: Vec3::splat(0.5),
            opacity: 0.25,
            alpha: AlphaMode::Blend,
            ..Material::default()
        };
        let cos = Vec3::new(0.01, 0.02, -1.0).normalize().z.abs();
        // Sunlight passes it on its way to the wall, and again on that to the eye.
        let expected = 0.25 * 0.5 * cos + 0.75 * 0.75 * without;
        let found = picture(Some(pane))[40][0];
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        let glass = Material {
            base_color: Vec3::splat(0.5),
            transmission: 1.0,
            ..Material::default()
        };
        let found = picture(Some(glass))[40][0];
        assert!((found - 0.25 * without).abs() < 1e-6, "{found}");
    }

    #[test]
    fn panes_are_points_before_the_surface_behind_them() {
        let pane = Material {
            base_color: Vec3::splat(0.5),
            opacity: 0.25,
            alpha: AlphaMode::Blend,
            ..Material::default()
        };
        let (scene, geometry, view) = card_before_a_wall(Some(pane));
        let cpu = Cpu::new();
        let behind = points(&cpu, &view, &scene, &geometry, None)[40];
        let panes = points_of_panes(&cpu, &view, &scene, &geometry, None);
        assert!(panes.iter().is_sorted_by_key(|(pixel, _)| *pixel));
        let (_, before) = panes.iter().find(|(pixel, _)| *pixel == 40).unwrap();
        assert!((before.response() - 0.25 * 0.5 / PI).abs().max_element() < 1e-7);
        assert!((before.position().z + 1.0).abs() < 1e-6);
        assert!((behind.response() - 0.75 * 0.8 / PI).abs().max_element() < 1e-7);
        // The card covers the picture.
        assert_eq!(panes.len(), view.rays().len());
    }
}

//! Epipolar sampling against a gather of every ray.

use glam::{Quat, Vec3};
use gpu_backend::{Backend, Cpu, Host};

use super::samples::Spacing;
use super::surfaces::Surfaces;
use super::*;
use crate::methods::evaluators::Gauss;
use crate::methods::reduced::{Reduced, Reduction};
use crate::methods::{
    Frame, FrameInputs, LightSources, MethodError, PerLight, Registry, RunOn, Selection,
    SourceAbout, SourceOn, Store, Work,
};
use crate::scene::trace::{Hit, Tracer};
use crate::scene::view::View;
use crate::scene::{Camera, Cone, Emission, Geometry, Medium, Mesh, PhaseFunction, Scene};
use crate::{Emitter, LightPath, Ray, Touching, visibility};

const MAP: u32 = 128;

/// The best quality: a sample in every pixel.
const BEST: u32 = 64;

/// A floor, a wall with gaps behind, posts before it.
fn geometry() -> Geometry {
    let mut mesh = Mesh::default();
    let mut quad = |corners: [[f32; 3]; 4]| {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners.map(Vec3::from));
        mesh.triangles
            .extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    };
    quad([
        [-40.0, 0.0, 8.0],
        [40.0, 0.0, 8.0],
        [40.0, 0.0, -60.0],
        [-40.0, 0.0, -60.0],
    ]);
    let mut upright = |x: f32, z: f32, width: f32, height: f32| {
        quad([
            [x, 0.0, z],
            [x + width, 0.0, z],
            [x + width, height, z],
            [x, height, z],
        ]);
    };
    for i in -3_i16..4 {
        upright(1.7 * f32::from(i), -9.0, 0.9, 4.0);
    }
    for (x, z) in [(-1.3, -4.0), (0.4, -5.0), (1.4, -3.0)] {
        upright(x, z, 0.25, 2.2);
    }
    Geometry::new(&Scene::from(mesh)).unwrap()
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.0, 1.2, 0.0), Vec3::new(0.2, 1.5, -5.0), 1.0).unwrap()
}

fn sun(towards: Vec3) -> Emitter {
    Emitter::directional(-towards, Vec3::ONE).unwrap()
}

fn lamp(position: Vec3, range: f32) -> Emitter {
    Emitter::point(position, Vec3::splat(20.0), range, Emission::Isotropic).unwrap()
}

/// In view, behind the eye and its antipode in view, at infinity, far outside; a lamp in
/// view, one behind, one at the eye, one of a short range.
pub(super) fn lights() -> Vec<(&'static str, Emitter)> {
    let at = |x, y| camera().direction(x, y, 48, 32);
    let right = camera().rotation() * Vec3::X;
    vec![
        ("sun in view", sun(at(17.3, 6.2))),
        ("sun behind", sun(-at(30.0, 45.0))),
        ("sun to the side", sun(right + 1e-11 * Vec3::Y)),
        ("sun far above", sun(Vec3::new(0.1, 1.0, 0.2))),
        (
            "lamp in view",
            lamp(Vec3::new(0.8, 2.4, -6.5), f32::INFINITY),
        ),
        (
            "lamp behind",
            lamp(Vec3::new(-0.5, 3.0, 2.0), f32::INFINITY),
        ),
        ("lamp at the eye", lamp(camera().eye(), f32::INFINITY)),
        ("lamp of short range", lamp(Vec3::new(-1.0, 1.0, -4.5), 1.5)),
    ]
}

/// Calls `test` with a frame of the scene, lit by one light or more.
pub(super) fn with_view<R>(
    size: [u32; 2],
    emitters: &[Emitter],
    test: impl FnOnce(FrameInputs<'_>) -> R,
) -> R {
    let geometry = geometry();
    let tracer = Tracer::new(&geometry);
    let view = View::new(&Cpu::new(), &camera(), &tracer, size[0], size[1]).unwrap();
    with_rays(size, emitters, (view.rays(), view.hits()), test)
}

fn with_rays<R>(
    size: [u32; 2],
    emitters: &[Emitter],
    (rays, hits): (&[Ray], &[Option<Hit>]),
    test: impl FnOnce(FrameInputs<'_>) -> R,
) -> R {
    let haze = Vec3::splat(0.04);
    let medium = Medium::new(haze, haze, PhaseFunction::Isotropic).unwrap();
    let (geometry, host) = (geometry(), Store::<Host>::new());
    test(FrameInputs {
        emitters,
        areas: &[],
        medium: &medium,
        height_fog: None,
        geometry: &geometry,
        translucent: &[],
        camera: &camera(),
        size,
        rays,
        hits,
        map: MAP,
        host: &host,
        selection: Selection::default(),
        watch: &(),
    })
}

fn picture(inputs: FrameInputs<'_>, method: &dyn RunOn<Cpu>, quality: u32) -> Vec<[f32; 4]> {
    picture_on(&Cpu::new(), inputs, method, quality)
}

fn picture_on(
    cpu: &Cpu,
    inputs: FrameInputs<'_>,
    method: &dyn RunOn<Cpu>,
    quality: u32,
) -> Vec<[f32; 4]> {
    let store = Store::<Host>::new();
    let frame = Frame::new(cpu, inputs, &store).unwrap();
    let mut radiance = vec![[0.0; 4]; inputs.rays.len()];
    method.add_radiance(&frame, quality, &mut radiance).unwrap();
    assert!(radiance.as_flattened().iter().all(|c| c.is_finite()));
    radiance
}

fn sampled(inputs: FrameInputs<'_>, quality: u32) -> Vec<[f32; 4]> {
    let all = Registry::standard();
    picture(inputs, &all.find("epipolar-sampling").unwrap(), quality)
}

fn exact(inputs: FrameInputs<'_>) -> Vec<[f32; 4]> {
    let all = Registry::standard();
    picture(inputs, &all.find("map-runs x gauss").unwrap(), 8)
}

/// Root mean square over the mean.
fn error(picture: &[[f32; 4]], expected: &[[f32; 4]]) -> f32 {
    let squares = picture.iter().zip(expected);
    let sum: f32 = squares.map(|(a, b)| (a[0] - b[0]).powi(2)).sum();
    let mean: f32 = expected.iter().map(|light| light[0]).sum::<f32>() / expected.len() as f32;
    (sum / expected.len() as f32).sqrt() / mean
}

const SIZES: [[u32; 2]; 6] = [[1, 1], [1, 9], [9, 1], [2, 2], [7, 13], [48, 32]];

/// To the roundings of a sum of a few dozen parts.
#[test]
fn a_sample_in_every_pixel_is_every_ray_gathered() {
    for size in SIZES {
        for (name, light) in lights() {
            with_view(size, &[light], |inputs| {
                let found = sampled(inputs, BEST);
                for (found, expected) in found.iter().zip(exact(inputs)) {
                    let off = (found[0] - expected[0]).abs();
                    assert!(off <= 4e-6 * expected[0], "{name} {size:?} {found:?}");
                }
            });
        }
    }
}

#[test]
fn small_pictures_of_any_quality_are_sound() {
    for size in SIZES {
        for (name, light) in lights() {
            with_view(size, &[light], |inputs| {
                let expected = exact(inputs);
                let most = expected.iter().map(|light| light[0]).fold(0.0, f32::max);
                for quality in [1, 2, 5, 16, 63] {
                    for light in sampled(inputs, quality) {
                        // A sample is at most half a pixel from a pixel.
                        assert!(light[0] >= 0.0, "{name} {size:?}");
                        assert!(light[0] <= 3.0 * most + 1e-3, "{name} {size:?} {light:?}");
                    }
                }
            });
        }
    }
}

#[test]
fn the_error_falls_with_the_number_of_samples() {
    for (name, light) in lights() {
        with_view([144, 96], &[light], |inputs| {
            let expected = exact(inputs);
            let errors = [2, 8, 32].map(|quality| error(&sampled(inputs, quality), &expected));
            println!("{name} {errors:?}");
            assert!(errors[1] <= errors[0], "{name} {errors:?}");
            // What is left then is that of lines a pixel apart.
            assert!(errors[2] <= 1.1 * errors[1], "{name} {errors:?}");
            assert!(errors[1] < 0.03, "{name} {errors:?}");
        });
    }
}

#[test]
fn the_light_of_many_is_the_sum_of_that_of_each() {
    let all: Vec<Emitter> = lights().into_iter().map(|(_, light)| light).collect();
    let size = [48, 32];
    let mut sum = vec![[0.0_f32; 4]; 48 * 32];
    for light in &all {
        with_view(size, std::slice::from_ref(light), |inputs| {
            for (sum, light) in sum.iter_mut().zip(sampled(inputs, 4)) {
                *sum = std::array::from_fn(|i| sum[i] + light[i]);
            }
        });
    }
    let together = with_view(size, &all, |inputs| sampled(inputs, 4));
    for (one_by_one, together) in sum.iter().zip(&together) {
        assert!((one_by_one[0] - together[0]).abs() <= 1e-6 * together[0]);
    }
}

#[test]
fn pictures_do_not_depend_on_threads() {
    let all = Registry::standard();
    let method = &all.find("epipolar-sampling").unwrap();
    for (name, light) in lights() {
        with_view([48, 32], &[light], |inputs| {
            let one = picture_on(&Cpu::single_threaded(), inputs, method, 4);
            let three = picture_on(&Cpu::with_threads(3).unwrap(), inputs, method, 4);
            assert_eq!(one, three, "{name}");
        });
    }
}

/// Nothing casts a shadow.
#[derive(Debug, Clone, Copy)]
struct Open;

impl LightSources for Open {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: "open",
            title: "",
            quality: None,
            touching: Touching::Joined,
            is_sampled: false,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: false,
        }
    }

    fn work(&self, _: &FrameInputs<'_>, _: u32) -> Work {
        Work::default()
    }
}

impl<B: Backend> SourceOn<B> for Open {
    type Source = visibility::Unshadowed;

    fn prepare(&self, _: &Frame<'_, B>, _: usize, _: u32) -> Result<(), MethodError> {
        Ok(())
    }

    fn source(&self, _: &Frame<'_, B>, _: usize, _: u32) -> Result<Self::Source, MethodError> {
        Ok(visibility::Unshadowed)
    }
}

/// The light of a sun is that of the length of the ray alone: every pixel has that of
/// one side of an edge.
#[test]
fn no_light_leaks_across_an_edge_of_depth() {
    let size = [50, 36];
    // A straight edge, a slanted one, a corner, a thin pole, a hole; sky or wall behind.
    let shapes: [fn(u32, u32) -> bool; 5] = [
        |x, _| x < 23,
        |x, y| 2 * x + y < 60,
        |x, y| x > 16 && y > 12,
        |x, _| x == 19,
        |x, y| x != 26 || y != 17,
    ];
    let method = EpipolarSampling::new(Open, Gauss, 8);
    for is_near in shapes {
        for far in [9.0, f32::INFINITY] {
            let rays: Vec<Ray> = (0..size[0] * size[1])
                .map(|i| {
                    let (x, y) = (i % size[0], i / size[0]);
                    let at = [x, y].map(|i| i as f32 + 0.5);
                    let direction = camera().direction(at[0], at[1], size[0], size[1]);
                    let length = if is_near(x, y) { 4.0 } else { far };
                    Ray::new(camera().eye(), direction, length).unwrap()
                })
                .collect();
            let hits = vec![None; rays.len()];
            for (name, light) in lights().into_iter().take(4) {
                with_rays(size, &[light], (&rays, &hits), |inputs| {
                    let whole = PerLight::new(Open, Gauss, None);
                    let expected = picture(inputs, &whole, 8);
                    for quality in [1, 4, 16] {
                        let found = picture(inputs, &method, quality);
                        for (found, expected) in found.iter().zip(&expected) {
                            let off = (found[0] - expected[0]).abs();
                            // The planes face the eye from each pixel, not from points
                            // of it.
                            assert!(off < 2e-3 * expected[0], "{name} {found:?} {expected:?}");
                        }
                    }
                });
            }
        }
    }
}

#[test]
fn a_part_of_a_picture_is_gathered_as_it_is() {
    let (_, light) = lights().swap_remove(0);
    with_view([24, 16], &[light], |inputs| {
        let method = EpipolarSampling::new(Open, Gauss, 8);
        let inside = Reduced::new(method.clone(), Reduction::QUARTER);
        let whole = PerLight::new(Open, Gauss, None);
        let plain = Reduced::new(whole.clone(), Reduction::QUARTER);
        assert_eq!(picture(inputs, &inside, 4), picture(inputs, &plain, 8));
        // Rays of another eye, or of other directions.
        let moved = |by: Vec3, turn: Vec3| -> Vec<Ray> {
            let rays = inputs.rays.iter();
            rays.map(|ray| {
                let direction = (ray.direction() + turn).normalize();
                Ray::new(ray.origin() + by, direction, ray.length()).unwrap()
            })
            .collect()
        };
        for rays in [
            moved(Vec3::X, Vec3::ZERO),
            moved(Vec3::ZERO, 0.01 * Vec3::X),
        ] {
            let inputs = FrameInputs {
                rays: &rays,
                ..inputs
            };
            assert_eq!(picture(inputs, &method, 4), picture(inputs, &whole, 8));
        }
    });
}

#[test]
fn what_is_no_quality_is_an_error() {
    let (_, light) = lights().swap_remove(0);
    with_view([8, 6], &[light], |inputs| {
        let (cpu, store) = (Cpu::new(), Store::<Host>::new());
        let frame = Frame::new(&cpu, inputs, &store).unwrap();
        for quality in [0, 65, u32::MAX] {
            let method = EpipolarSampling::new(Open, Gauss, 8);
            let mut radiance = vec![[0.0; 4]; 48];
            let error = method.add_radiance(&frame, quality, &mut radiance);
            let error = error.unwrap_err().to_string();
            assert!(error.contains("expected 1 to 64"), "{error}");
        }
    });
}

/// Lines are those of the part of the picture that a light reaches.
#[test]
fn pixels_out_of_reach_stay_dark_and_cost_no_rays() {
    let cone = Cone {
        inner: 0.1,
        outer: 0.25,
    };
    let down = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::NEG_Y);
    let emission = Emission::spot(down, cone, None).unwrap();
    let position = Vec3::new(0.6, 3.0, -6.0);
    let spot = Emitter::point(position, Vec3::splat(20.0), 4.0, emission).unwrap();
    with_view([144, 96], &[spot], |inputs| {
        let (cpu, expected) = (Cpu::new(), exact(inputs));
        let mut dark = 0;
        for (found, ray) in sampled(inputs, 4).iter().zip(inputs.rays) {
            if LightPath::new(ray, &inputs.emitters[0], inputs.medium).is_none() {
                assert_eq!(found[0], 0.0);
                dark += 1;
            }
        }
        assert!(dark > 6000, "{dark}");
        let surfaces = Surfaces::new(&cpu, &inputs);
        let spacing = Spacing {
            lines: 1.0,
            samples: 16.0,
        };
        let choice = Choice::new(&cpu, &surfaces, &inputs.emitters[0], spacing).unwrap();
        let lit = expected.len() - dark;
        let rays = choice.rays.len();
        assert!(rays <= lit, "{rays} rays for {lit} pixels");
        let beyond = Emitter::point(100.0 * Vec3::Z, Vec3::ONE, 1.0, Emission::Isotropic);
        assert!(Choice::new(&cpu, &surfaces, &beyond.unwrap(), spacing).is_none());
    });
}

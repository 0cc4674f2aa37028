//! Froxels against quadrature, closed forms and themselves.

use glam::{Quat, Vec3};
use gpu_backend::{Backend, Cpu, Host};
use reference::metrics::order;
use reference::oracle::closed_form;
use reference::tolerances::{Allowed, ULP32};

use super::*;
use crate::airlight::Quadrature;
use crate::scene::{
    Bounds, Camera, Cone, Emission, Falloff, Geometry, Medium, Mesh, PhaseFunction, Scene, Texture,
};
use crate::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use crate::visibility::{March, PointVisibility, Spacing, Unshadowed};
use crate::{Emitter, Gather, Interval, LitRays, Ray};

pub(super) const SIZE: [u32; 2] = [24, 16];

pub(super) fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.1, 1.6, 0.5), Vec3::new(0.0, 1.8, -6.0), 1.0).unwrap()
}

/// Rays of the pixels that end at different distances, a few at once and a few in the
/// sky.
pub(super) fn rays_of(camera: &Camera, [width, height]: [u32; 2]) -> Vec<Ray> {
    let pixel = |i: u32| {
        let (x, y) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        let length = match i % 11 {
            0 => f32::INFINITY,
            1 => 0.0,
            k => 4.0 + 0.7 * k as f32,
        };
        Ray::new(camera.eye(), camera.direction(x, y, width, height), length).unwrap()
    };
    (0..width * height).map(pixel).collect()
}

pub(super) fn fog() -> Medium {
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.4 };
    Medium::new(Vec3::new(0.1, 0.12, 0.15), Vec3::splat(0.02), phase).unwrap()
}

fn lamp(position: Vec3) -> Emitter {
    let intensity = Vec3::new(3.0, 5.0, 4.0);
    Emitter::point(position, intensity, f32::INFINITY, Emission::Isotropic).unwrap()
}

/// A light of every kind, none of them near a ray.
pub(super) fn lights() -> Vec<Emitter> {
    let texels = (0..64).map(|i| Vec3::splat(0.2 + 0.8 * ((i * 7 % 5) as f32 / 4.0)));
    let cookie = Texture::new(8, 8, texels.collect()).unwrap();
    let cone = Cone {
        inner: 0.3,
        outer: 0.6,
    };
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let spot = Emission::spot(down, cone, Some(cookie)).unwrap();
    let at = |position: [f32; 3], range: f32, emission: Emission| {
        Emitter::point(position, Vec3::new(9.0, 12.0, 15.0), range, emission).unwrap()
    };
    vec![
        lamp(Vec3::new(1.0, 7.5, -5.0)),
        at([0.0, 9.0, -6.0], f32::INFINITY, spot),
        at([-1.0, -6.0, -4.0], 12.0, Emission::Isotropic).with_falloff(Falloff::Smooth),
        at(
            [0.0, 8.0, -6.0],
            f32::INFINITY,
            Emission::Cosine {
                normal: Vec3::NEG_Y,
            },
        ),
        Emitter::directional(Vec3::new(0.3, -1.0, -0.2), Vec3::splat(0.2)).unwrap(),
    ]
}

fn grid_of(
    camera: &Camera,
    rays: &[Ray],
    medium: &Medium,
    lights: &[Emitter],
    tile: u32,
    slices: u32,
) -> FroxelGrid {
    let depths = lit_depths(camera.eye(), rays, medium, lights);
    FroxelGrid::new(camera, SIZE, tile, slices, depths).unwrap()
}

/// What lights with their shadows make of froxels.
fn injected<P: PointVisibility>(
    cpu: &Cpu,
    grid: FroxelGrid,
    jitter: Jitter,
    medium: &Medium,
    lights: &[(&Emitter, P)],
) -> FroxelVolume<Host> {
    let mut volume = FroxelVolume::new(cpu, grid, jitter).unwrap();
    for (emitter, points) in lights {
        let light = FroxelLight {
            emitter,
            medium,
            extinction: true,
        };
        cpu.inject(&light, points, &mut volume).unwrap();
    }
    volume
}

/// The picture that rays make of froxels.
fn picture(
    cpu: &Cpu,
    volume: &mut FroxelVolume<Host>,
    medium: &Medium,
    rays: &[Ray],
) -> Vec<[f32; 4]> {
    let mut airlight = FroxelAirlight::new(cpu, *volume.grid()).unwrap();
    cpu.integrate(medium, volume, &mut airlight).unwrap();
    let mut radiance = cpu.zeros::<[f32; 4]>(rays.len()).unwrap();
    cpu.look_up(&airlight, &rays.to_vec(), &mut radiance)
        .unwrap();
    radiance
}

fn unshadowed(lights: &[Emitter]) -> Vec<(&Emitter, Unshadowed)> {
    lights.iter().map(|light| (light, Unshadowed)).collect()
}

/// Root mean square of a difference, relative to the mean of the second.
fn rmse(found: &[[f32; 4]], expected: &[[f32; 4]]) -> f64 {
    let pairs = || {
        let pixels = found.iter().zip(expected);
        pixels.flat_map(|(f, e)| (0..3).map(move |c| (f64::from(f[c]), f64::from(e[c]))))
    };
    let count = pairs().count() as f64;
    let mean = pairs().map(|(_, e)| e).sum::<f64>() / count;
    (pairs().map(|(f, e)| (f - e).powi(2)).sum::<f64>() / count).sqrt() / mean
}

#[test]
fn in_open_fog_they_converge_to_the_closed_form_at_second_order() {
    let cpu = Cpu::new();
    let fog = Medium::new(
        Vec3::splat(0.12),
        Vec3::splat(0.03),
        PhaseFunction::Isotropic,
    )
    .unwrap();
    let position = Vec3::new(1.0, 7.5, -5.0);
    let light = Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
    let camera = camera();
    let rays = rays_of(&camera, SIZE);
    let expected: Vec<[f32; 4]> = rays
        .iter()
        .map(|ray| {
            let to_light = (position - ray.origin()).as_dvec3();
            let direction = ray.direction().as_dvec3().normalize();
            let foot = to_light.dot(direction);
            let h = to_light.cross(direction).length();
            let end = f64::from(ray.length());
            let value = closed_form::isotropic(0.12, 0.15, foot, h, 0.0, end) as f32;
            [value, value, value, 0.0]
        })
        .collect();
    let lights = [light];
    let error = |tile: u32, slices: u32| {
        let grid = grid_of(&camera, &rays, &fog, &lights, tile, slices);
        let lights = unshadowed(&lights);
        let mut volume = injected(&cpu, grid, Jitter::MIDDLE, &fog, &lights);
        rmse(&picture(&cpu, &mut volume, &fog, &rays), &expected)
    };
    let slices = [16, 32, 64, 128].map(|slices| (slices, error(1, slices)));
    println!("slices {slices:?}: order {:.2}", order(&slices));
    assert!(
        (order(&slices) - 2.0).abs() <= Allowed::Order.error(),
        "{slices:?}"
    );
    assert!(slices[3].1 < 1e-3, "{slices:?}");
    // Tiles are interpolated but for half of one at the border of the picture.
    let tiles = [1, 2, 4].map(|finer| (finer, error(8 / finer, 256)));
    println!("tiles {tiles:?}: order {:.2}", order(&tiles));
    assert!(order(&tiles) >= 1.0 - Allowed::Order.error(), "{tiles:?}");
}

#[test]
fn lights_of_every_kind_converge_to_the_quadrature_inside_and_outside_of_a_box() {
    let cpu = Cpu::new();
    let (camera, lights) = (camera(), lights());
    let rays = rays_of(&camera, SIZE);
    let bank = Bounds::new(Vec3::new(-4.0, -2.0, -9.0), Vec3::new(5.0, 6.0, -2.0)).unwrap();
    for medium in [fog(), fog().within(bank)] {
        for light in &lights {
            let quadrature = Quadrature::with_tolerance(medium.phase(), 1e-5).unwrap();
            let mut expected = cpu.zeros::<[f32; 4]>(rays.len()).unwrap();
            let lit = LitRays::new(&rays, light, &medium);
            cpu.gather(&lit, &Unshadowed, &quadrature, &mut expected)
                .unwrap();
            let light = std::slice::from_ref(light);
            let errors = [32, 64, 128, 256].map(|slices| {
                let grid = grid_of(&camera, &rays, &medium, light, 1, slices);
                let lights = unshadowed(light);
                let mut volume = injected(&cpu, grid, Jitter::MIDDLE, &medium, &lights);
                let error = rmse(&picture(&cpu, &mut volume, &medium, &rays), &expected);
                (slices, error)
            });
            println!(
                "{:?}: order {:.2}, {errors:?}",
                medium.bounds(),
                order(&errors)
            );
            // Cones and cookies have kinks, and columns enter a box where a slice ends.
            assert!(order(&errors) >= 1.0 - Allowed::Order.error(), "{errors:?}");
            assert!(errors[3].1 < 0.01, "{errors:?}");
        }
    }
}

/// A plate between the light and a part of the view.
fn plate() -> Geometry {
    let corners = [[-1.4, -7.5], [0.6, -7.5], [0.6, -4.5], [-1.4, -4.5]];
    let scene = Scene::from(Mesh {
        positions: corners.map(|[x, z]| Vec3::new(x, 4.0, z)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    });
    Geometry::new(&scene).unwrap()
}

pub(super) fn maps(lights: &[Emitter], resolution: u32) -> Vec<ShadowMap<Host>> {
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &plate()).unwrap();
    let map = |light| cpu.shadow_map(&casters, light, resolution).unwrap();
    lights.iter().map(map).collect()
}

#[test]
fn shadows_converge_to_those_of_their_map() {
    let cpu = Cpu::new();
    let (camera, fog, lights) = (camera(), fog(), [lamp(Vec3::new(0.0, 8.0, -6.0))]);
    let rays = rays_of(&camera, SIZE);
    let maps = maps(&lights, 512);
    let quadrature = Quadrature::with_tolerance(fog.phase(), 1e-4).unwrap();
    let lit = LitRays::new(&rays, &lights[0], &fog).joined();
    let march = March::new(&maps[0], 4096, Spacing::Distance);
    let mut expected = cpu.zeros::<[f32; 4]>(rays.len()).unwrap();
    cpu.gather(&lit, &march, &quadrature, &mut expected)
        .unwrap();
    let errors = [32, 64, 128, 256].map(|slices| {
        let grid = grid_of(&camera, &rays, &fog, &lights, 1, slices);
        let lights = [(&lights[0], &maps[0])];
        let mut volume = injected(&cpu, grid, Jitter::MIDDLE, &fog, &lights);
        (
            slices,
            rmse(&picture(&cpu, &mut volume, &fog, &rays), &expected),
        )
    });
    println!("order {:.2}, {errors:?}", order(&errors));
    assert!(order(&errors) >= 1.0 - Allowed::Order.error(), "{errors:?}");
    // Without the shadow it would be off by a tenth.
    assert!(errors[3].1 < 0.01, "{errors:?}");
}

#[test]
fn lights_add_up_and_threads_change_nothing() {
    let (camera, fog, lights) = (camera(), fog(), lights());
    let rays = rays_of(&camera, SIZE);
    let grid = grid_of(&camera, &rays, &fog, &lights, 3, 20);
    let maps = maps(&lights, 64);
    let pairs: Vec<_> = lights.iter().zip(&maps).collect();
    let image = |cpu: &Cpu, lights: &[(&Emitter, &ShadowMap<Host>)]| {
        let mut volume = injected(cpu, grid, Jitter::MIDDLE, &fog, lights);
        picture(cpu, &mut volume, &fog, &rays)
    };
    let cpu = Cpu::single_threaded();
    let all = image(&cpu, &pairs);
    assert_eq!(all, image(&Cpu::new(), &pairs));
    let singly: Vec<_> = pairs.iter().map(|pair| image(&cpu, &[*pair])).collect();
    for (pixel, light) in all.iter().enumerate() {
        for channel in 0..3 {
            let sum: f32 = singly.iter().map(|image| image[pixel][channel]).sum();
            // Sums of twenty slices and five lights, of positive terms.
            let allowed = 2.0 * 25.0 * ULP32 * f64::from(sum);
            assert!(f64::from((light[channel] - sum).abs()) <= allowed);
        }
    }
    // Without any light, and where nothing scatters.
    let mut dark = FroxelVolume::new(&cpu, grid, Jitter::MIDDLE).unwrap();
    assert!(
        picture(&cpu, &mut dark, &fog, &rays)
            .iter()
            .all(|p| *p == [0.0; 4])
    );
    let mut again = injected(&cpu, grid, Jitter::MIDDLE, &fog, &pairs)
        .again(&cpu, grid, Jitter::MIDDLE)
        .unwrap();
    assert!(
        picture(&cpu, &mut again, &fog, &rays)
            .iter()
            .all(|p| *p == [0.0; 4])
    );
    let vacuum = Medium::new(Vec3::ZERO, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let mut none = injected(&cpu, grid, Jitter::MIDDLE, &vacuum, &pairs);
    assert!(
        picture(&cpu, &mut none, &vacuum, &rays)
            .iter()
            .all(|p| *p == [0.0; 4])
    );
}

#[test]
fn extinction_between_light_and_air_is_what_engines_leave_out() {
    let cpu = Cpu::new();
    let (camera, fog) = (camera(), fog());
    let rays = rays_of(&camera, SIZE);
    let lights = [lamp(Vec3::new(1.0, 7.5, -5.0))];
    let grid = grid_of(&camera, &rays, &fog, &lights, 1, 64);
    let image = |extinction: bool| {
        let mut volume = FroxelVolume::new(&cpu, grid, Jitter::MIDDLE).unwrap();
        let light = FroxelLight {
            emitter: &lights[0],
            medium: &fog,
            extinction,
        };
        cpu.inject(&light, &Unshadowed, &mut volume).unwrap();
        picture(&cpu, &mut volume, &fog, &rays)
    };
    for (with, without) in image(true).iter().zip(&image(false)) {
        for channel in 0..3 {
            // No ray comes closer to it than 1 m, and few come farther than 60 m.
            let (with, without) = (with[channel], without[channel]);
            assert!(with <= without * (-0.12_f32).exp());
            assert!(with >= without * (-0.17_f32 * 60.0).exp());
        }
    }
}

#[test]
fn any_picture_any_medium_and_lights_anywhere_give_numbers() {
    let cpu = Cpu::new();
    let camera = camera();
    let deep = Bounds::new(Vec3::splat(-50.0), Vec3::splat(50.0)).unwrap();
    let aside = Bounds::new(Vec3::new(20.0, 0.0, -30.0), Vec3::new(22.0, 4.0, -25.0)).unwrap();
    let gray = |s: f32, a: f32| {
        Medium::new(
            Vec3::splat(s),
            Vec3::splat(a),
            PhaseFunction::HenyeyGreenstein { g: 0.9 },
        )
        .unwrap()
    };
    let mut media = vec![gray(1e-15, 0.0), gray(1.0, 1e3), gray(1e15, 1e15)];
    media.push(gray(1e6, 0.0).within(deep));
    media.push(gray(0.1, 0.0).within(aside));
    let red = Medium::new(
        Vec3::new(0.1, 0.0, 0.0),
        Vec3::new(0.0, 1.0, 0.0),
        PhaseFunction::Rayleigh,
    );
    media.push(red.unwrap());
    let mut lights = lights();
    lights.push(lamp(camera.eye()));
    lights.push(lamp(camera.eye() - Vec3::Z));
    let strong = Emitter::point(
        camera.eye() + 1e-9,
        Vec3::splat(1e20),
        1e9,
        Emission::Isotropic,
    );
    lights.push(strong.unwrap());
    for size in [[1, 1], [1, 7], [5, 3], [301, 2]] {
        let rays = rays_of(&camera, size);
        for medium in &media {
            let depths = lit_depths(camera.eye(), &rays, medium, &lights);
            for slices in [1, 5] {
                let tile = FroxelGrid::usual_tile(size);
                let Ok(grid) = FroxelGrid::new(&camera, size, tile, slices, depths) else {
                    assert!(depths.end <= depths.start);
                    continue;
                };
                for light in &lights {
                    let light = [(light, Unshadowed)];
                    let mut volume = injected(&cpu, grid, Jitter::MIDDLE, medium, &light);
                    let image = picture(&cpu, &mut volume, medium, &rays);
                    let is_sound = |value: &f32| value.is_finite() && *value >= 0.0;
                    assert!(image.iter().flatten().all(is_sound), "{medium:?} {light:?}");
                    for (ray, pixel) in rays.iter().zip(&image) {
                        assert!(ray.length() > 0.0 || *pixel == [0.0; 4]);
                    }
                }
            }
        }
    }
    // Rays that run backwards see nothing, those beside the picture its border.
    let grid = FroxelGrid::new(&camera, SIZE, 4, 8, Interval::new(0.0, 9.0)).unwrap();
    let mut volume = injected(
        &cpu,
        grid,
        Jitter::MIDDLE,
        &fog(),
        &[(&lights[0], Unshadowed)],
    );
    let forward = camera.direction(12.0, 8.0, SIZE[0], SIZE[1]);
    let aside = camera.direction(1e4, 8.0, SIZE[0], SIZE[1]);
    let ray = |direction: Vec3| Ray::new(camera.eye(), direction, 5.0).unwrap();
    let image = picture(&cpu, &mut volume, &fog(), &[ray(-forward), ray(aside)]);
    assert_eq!(image[0], [0.0; 4]);
    assert!(image[1][0] > 0.0);
    let nothing = cpu.look_up(
        &FroxelAirlight::new(&cpu, grid).unwrap(),
        &vec![ray(forward)],
        &mut Vec::new(),
    );
    assert!(nothing.is_err());
}

#[test]
fn slices_and_tiles_are_where_they_say() {
    let camera = camera();
    let grid = FroxelGrid::new(&camera, [25, 16], 3, 10, Interval::new(1.0, 11.0)).unwrap();
    assert_eq!(grid.counts(), [9, 6, 10]);
    assert_eq!(grid.froxels(), 540);
    assert_eq!((grid.depth(0.0), grid.depth(10.0)), (1.0, 11.0));
    assert!((grid.depth(5.0) - 3.5).abs() < 1e-6);
    for u in [0.0, 0.3, 2.5, 9.9, 10.0] {
        assert!((grid.slice(grid.depth(u)) - u).abs() < 1e-4);
    }
    assert_eq!((grid.slice(0.5), grid.slice(1e9)), (0.0, 10.0));
    for (x, y) in [(0.0, 0.0), (12.5, 8.0), (20.3, 15.0)] {
        let direction = camera.direction(x, y, 25, 16);
        assert!((grid.direction([x / 3.0, y / 3.0]) - direction).length() < 1e-6);
        let [a, b] = grid.place(direction).unwrap();
        assert!((a - x / 3.0).abs() < 1e-4 && (b - y / 3.0).abs() < 1e-4);
        assert_eq!(grid.place(-direction), None);
    }
    let tile = FroxelGrid::usual_tile;
    let sizes = [
        [1, 1],
        [160, 90],
        [161, 90],
        [960, 540],
        [1920, 1080],
        [16384, 16384],
    ];
    assert_eq!(sizes.map(tile), [1, 1, 2, 6, 12, 137]);
}

#[test]
fn what_cannot_be_is_an_error_that_says_so() {
    let camera = camera();
    let whole = Interval::new(0.0, 1.0);
    let error = |size, tile, slices, depths| {
        let error = FroxelGrid::new(&camera, size, tile, slices, depths).unwrap_err();
        error.to_string()
    };
    assert!(error(SIZE, 1, 0, whole).contains("0 slices"));
    assert!(error(SIZE, 1, 1025, whole).contains("1 to 1024"));
    assert!(error([0, 9], 1, 8, whole).contains("0 x 9"));
    assert!(error([9, 20_000], 1, 8, whole).contains("9 x 20000"));
    assert!(error(SIZE, 0, 8, whole).contains("0 pixels"));
    assert!(error([16_384, 16_384], 1, 1024, whole).contains("8388608 at most"));
    for (start, end) in [
        (1.0, 1.0),
        (2.0, 1.0),
        (0.0, f32::INFINITY),
        (f32::NAN, 1.0),
        (-1.0, 1.0),
    ] {
        assert!(error(SIZE, 1, 8, Interval::new(start, end)).contains("start < end"));
    }
    for share in [1.0, -0.1, f32::NAN] {
        let error = FroxelHistory::<Host>::new(share).unwrap_err();
        assert!(error.to_string().contains("1 excluded"), "{error}");
    }
}

#[test]
fn a_still_scene_converges_to_the_mean_over_its_jitters() {
    const FRAMES: u32 = 16;
    let cpu = Cpu::new();
    let (camera, fog, lights) = (camera(), fog(), [lamp(Vec3::new(0.0, 8.0, -6.0))]);
    let rays = rays_of(&camera, SIZE);
    let maps = maps(&lights, 128);
    let grid = grid_of(&camera, &rays, &fog, &lights, 4, 16);
    let lights = [(&lights[0], &maps[0])];
    let mut history = FroxelHistory::new(0.95).unwrap();
    let mut sum = vec![[0.0_f64; 3]; grid.froxels()];
    for frame in 0..FRAMES {
        let single = injected(&cpu, grid, Jitter::of_frame(frame), &fog, &lights);
        for (sum, froxel) in sum.iter_mut().zip(single.scattered()) {
            for channel in 0..3 {
                sum[channel] += f64::from(froxel[channel]);
            }
        }
        let mut volume = history.begin(&cpu, grid).unwrap();
        let light = FroxelLight {
            emitter: lights[0].0,
            medium: &fog,
            extinction: true,
        };
        cpu.inject(&light, lights[0].1, &mut volume).unwrap();
        history.finish(&cpu, volume).unwrap();
    }
    assert_eq!(history.frames(), FRAMES);
    for (sum, froxel) in sum.iter().zip(history.last().unwrap().scattered()) {
        assert!((froxel[3] - FRAMES as f32).abs() < 1e-3);
        for channel in 0..3 {
            let mean = sum[channel] / f64::from(FRAMES);
            // Each of sixteen blends rounds a few times, none of them beyond the largest
            // of the frames, which is up to sixteen times the mean.
            let allowed = 4.0 * 16.0 * 16.0 * ULP32 * mean;
            assert!((f64::from(froxel[channel]) - mean).abs() <= allowed);
        }
    }
}

#[test]
fn blended_frames_are_better_than_one_in_the_middle() {
    let cpu = Cpu::new();
    let (camera, fog, lights) = (camera(), fog(), [lamp(Vec3::new(0.0, 8.0, -6.0))]);
    let rays = rays_of(&camera, SIZE);
    let maps = maps(&lights, 512);
    let taps = [(&lights[0], &maps[0])];
    let fine = grid_of(&camera, &rays, &fog, &lights, 1, 1024);
    let mut fine = injected(&cpu, fine, Jitter::MIDDLE, &fog, &taps);
    let fine = picture(&cpu, &mut fine, &fog, &rays);
    let grid = grid_of(&camera, &rays, &fog, &lights, 1, 12);
    let mut single = injected(&cpu, grid, Jitter::MIDDLE, &fog, &taps);
    let single = rmse(&picture(&cpu, &mut single, &fog, &rays), &fine);
    let mut history = FroxelHistory::new(0.95).unwrap();
    for frame in 0..16 {
        let now = injected(&cpu, grid, Jitter::of_frame(frame), &fog, &taps);
        history.finish(&cpu, now).unwrap();
    }
    let now = injected(&cpu, grid, Jitter::of_frame(16), &fog, &taps);
    let blended = history.finish(&cpu, now).unwrap();
    let blended = rmse(&picture(&cpu, blended, &fog, &rays), &fine);
    println!("one {single:.4}, blended {blended:.4}");
    assert!(blended < 0.7 * single, "{single} {blended}");
}

#[test]
fn a_moving_camera_finds_its_past_where_it_was() {
    let cpu = Cpu::new();
    let (fog, light) = (fog(), lamp(Vec3::new(0.0, 8.0, -6.0)));
    let isotropic = Medium::new(fog.sigma_s(), fog.sigma_a(), PhaseFunction::Isotropic).unwrap();
    let lights = [(&light, Unshadowed)];
    let at =
        |x: f32| Camera::look_at(Vec3::new(x, 1.6, 0.5), Vec3::new(x, 1.8, -6.0), 1.0).unwrap();
    let grid =
        |x: f32, end: f32| FroxelGrid::new(&at(x), SIZE, 1, 64, Interval::new(0.0, end)).unwrap();
    let volume = |x, end| injected(&cpu, grid(x, end), Jitter::MIDDLE, &isotropic, &lights);
    for (x, end) in [(0.0, 12.0), (0.4, 12.0), (0.0, 15.0), (-0.7, 9.0)] {
        let before = volume(0.0, 12.0);
        let now = volume(x, end);
        let mut blended = volume(x, end);
        cpu.blend(&before, 0.5, &mut blended).unwrap();
        let (mut seen, mut new) = (0, 0);
        for (froxel, single) in blended.scattered().iter().zip(now.scattered()) {
            if froxel[3] == 1.0 {
                assert_eq!(froxel, single);
                new += 1;
                continue;
            }
            seen += 1;
            assert!((froxel[3] - 2.0).abs() < 1e-4);
            for channel in 0..3 {
                // Interpolated between neighbours, which differ by a few percent, and
                // held at the border.
                assert!((froxel[channel] / single[channel] - 1.0).abs() < 0.05);
            }
        }
        println!("{x} {end}: {seen} seen before, {new} new");
        assert!(seen > 12_000 && (x != 0.0 || end > 12.0 || new == 0));
        assert!(x == 0.0 || new > 500);
    }
}

#[test]
fn jitters_are_spread_evenly_over_any_frames() {
    for (axis, off) in [(0, 2.5), (1, 2.5), (2, 1.0)] {
        for first in [0, 5, 1_000_000, u32::MAX / 2] {
            let places = (first..first + 16).map(|frame| Jitter::of_frame(frame).place()[axis]);
            let mut places: Vec<f32> = places.collect();
            places.sort_by(f32::total_cmp);
            assert!(places.iter().all(|place| (0.0..1.0).contains(place)));
            for (i, place) in places.iter().enumerate() {
                let even = (i as f32 + 0.5) / 16.0;
                assert!(
                    (place - even).abs() <= off / 16.0,
                    "{axis} {first} {places:?}"
                );
            }
        }
        let mean: f32 = (0..16)
            .map(|i| Jitter::of_frame(i).place()[axis])
            .sum::<f32>()
            / 16.0;
        assert!((mean - 0.5).abs() < 0.01, "{axis} {mean}");
    }
}

#[test]
fn filtered_maps_are_asked_like_any_other() {
    use crate::methods::prefiltered::{Moments, PrefilteredMap};

    let cpu = Cpu::new();
    let (camera, fog, lights) = (camera(), fog(), [lamp(Vec3::new(0.0, 8.0, -6.0))]);
    let rays = rays_of(&camera, SIZE);
    let maps = maps(&lights, 128);
    let filtered =
        PrefilteredMap::new(&cpu, &maps[0], Moments::Four, &plate().bounds(), 0).unwrap();
    let grid = grid_of(&camera, &rays, &fog, &lights, 1, 64);
    let image = |volume: &mut FroxelVolume<Host>| picture(&cpu, volume, &fog, &rays);
    let hard = image(&mut injected(
        &cpu,
        grid,
        Jitter::MIDDLE,
        &fog,
        &[(&lights[0], &maps[0])],
    ));
    let soft = image(&mut injected(
        &cpu,
        grid,
        Jitter::MIDDLE,
        &fog,
        &[(&lights[0], filtered)],
    ));
    let bare = image(&mut injected(
        &cpu,
        grid,
        Jitter::MIDDLE,
        &fog,
        &unshadowed(&lights),
    ));
    let [soft, bare] = [rmse(&soft, &hard), rmse(&bare, &hard)];
    assert!(soft < 0.3 * bare, "{soft} {bare}");
}

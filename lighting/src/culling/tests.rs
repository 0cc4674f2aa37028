use std::f32::consts::FRAC_PI_2;

use glam::{Quat, Vec3};
use gpu_backend::Cpu;
use reference::random::Random;

use super::*;
use crate::scene::{Camera, Cone, Emission, Emitter, Medium, PhaseFunction};
use crate::{LightPath, Ray};

const WIDTH: u32 = 37;
const HEIGHT: u32 = 21;

fn vector(random: &mut Random, size: f32) -> Vec3 {
    Vec3::from_array(random.vector(size))
}

/// Rays of a random eye, some of which go on for ever.
fn rays(random: &mut Random) -> Vec<Ray> {
    let eye = vector(random, 5.0);
    let target = eye + vector(random, 1.0) + Vec3::splat(1e-3);
    let fov = random.log_uniform(0.01, 3.0) as f32;
    let camera = Camera::look_at(eye, target, fov).unwrap();
    (0..WIDTH * HEIGHT)
        .map(|i| {
            let [x, y] = [i % WIDTH, i / WIDTH].map(|place| place as f32 + 0.5);
            let direction = camera.direction(x, y, WIDTH, HEIGHT);
            let length = match random.below(4) {
                0 => f32::INFINITY,
                _ => random.log_uniform(1e-3, 1e3) as f32,
            };
            Ray::new(eye, direction, length).unwrap()
        })
        .collect()
}

/// A light with bounds: often in the picture, sometimes at the eye or on a ray.
fn light(random: &mut Random, rays: &[Ray]) -> Emitter {
    let ray = rays[random.below(WIDTH * HEIGHT) as usize];
    let distance = random.log_uniform(1e-2, 1e2) as f32;
    let position = match random.below(8) {
        0 => ray.origin(),
        1 => ray.at(distance),
        2 => ray.origin() + vector(random, distance),
        _ => ray.at(distance) + vector(random, 0.3 * distance),
    };
    let range = (f64::from(distance) * random.log_uniform(1e-3, 10.0)) as f32;
    let rotation = Quat::from_rotation_arc(
        Vec3::Z,
        (vector(random, 1.0) + Vec3::splat(1e-4)).normalize(),
    );
    let outer = random.log_uniform(1e-3, f64::from(FRAC_PI_2)) as f32;
    let cone = Cone {
        inner: 0.0,
        outer: outer.min(FRAC_PI_2),
    };
    let (range, emission) = match random.below(5) {
        0 => (range, Emission::Isotropic),
        1 => (
            range,
            Emission::Cosine {
                normal: rotation * Vec3::Z,
            },
        ),
        2 => (
            f32::INFINITY,
            Emission::Cosine {
                normal: rotation * Vec3::Z,
            },
        ),
        3 => (range, Emission::spot(rotation, cone, None).unwrap()),
        _ => (f32::INFINITY, Emission::spot(rotation, cone, None).unwrap()),
    };
    Emitter::point(position, Vec3::ONE, range, emission).unwrap()
}

fn tiles(rays: &[Ray]) -> RayTiles {
    RayTiles::new(&Cpu::new(), rays, WIDTH, None).unwrap()
}

/// Marks of the rays that a light really reaches.
fn truth(rays: &[Ray], light: &Emitter) -> Vec<bool> {
    let sigma = Vec3::splat(0.01);
    let fog = Medium::new(sigma, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let path = |ray: &Ray| LightPath::new(ray, light, &fog).is_some();
    rays.iter().map(path).collect()
}

#[test]
fn no_ray_that_a_light_reaches_is_left_out() {
    let mut random = Random::new(1);
    let (mut kept, mut reached, mut cut) = (0, 0, 0);
    for _ in 0..300 {
        let rays = rays(&mut random);
        let tiles = tiles(&rays);
        for _ in 0..10 {
            let light = light(&mut random, &rays);
            let truth = truth(&rays, &light);
            let found = tiles.reached(&light).unwrap();
            let mut is_there = vec![false; rays.len()];
            for ray in &found {
                assert!(!is_there[*ray as usize], "twice: {light:?}");
                is_there[*ray as usize] = true;
            }
            for (ray, (reached, there)) in rays.iter().zip(truth.iter().zip(&is_there)) {
                assert!(!reached || *there, "{ray:?} {light:?}");
            }
            kept += found.len();
            reached += truth.iter().filter(|reached| **reached).count();
            cut += usize::from(found.len() < rays.len());
        }
    }
    println!("{reached} rays are reached, {kept} are kept; {cut} of 3000 lights are cut");
    assert!(cut > 1000 && reached > 100_000);
    assert!((kept as f64) < 1.3 * reached as f64, "{kept} of {reached}");
}

#[test]
fn pixels_may_come_in_any_order() {
    let mut random = Random::new(2);
    let all = rays(&mut random);
    let mut pixels: Vec<u32> = (0..WIDTH * HEIGHT).collect();
    random.shuffle(&mut pixels);
    pixels.truncate(300);
    let some: Vec<Ray> = pixels.iter().map(|pixel| all[*pixel as usize]).collect();
    let tiles = RayTiles::new(&Cpu::new(), &some, WIDTH, Some(&pixels)).unwrap();
    for _ in 0..100 {
        let light = light(&mut random, &all);
        let found = tiles.reached(&light).unwrap();
        for (ray, reached) in (0..).zip(truth(&some, &light)) {
            assert!(!reached || found.contains(&ray));
        }
    }
}

#[test]
fn what_has_no_tiles_or_no_bounds_says_so() {
    let cpu = Cpu::new();
    let ray = |x: f32| Ray::new(Vec3::X * x, Vec3::Y, 1.0).unwrap();
    let new = |rays: &[Ray], pixels| RayTiles::new(&cpu, rays, 2, pixels);
    assert!(new(&[], None).is_none());
    assert!(new(&[ray(0.0), ray(1.0)], None).is_none());
    assert!(new(&[ray(0.0)], Some(&[0, 1])).is_none());
    let tiles = new(&[ray(0.0), ray(0.0)], Some(&[1, u32::MAX])).unwrap();
    let lamp = |range| Emitter::point(Vec3::Y, Vec3::ONE, range, Emission::Isotropic).unwrap();
    assert_eq!(tiles.reached(&lamp(f32::INFINITY)), None);
    assert_eq!(
        tiles.reached(&Emitter::directional(Vec3::Y, Vec3::ONE).unwrap()),
        None
    );
    assert_eq!(tiles.reached(&lamp(0.5)).map(|rays| rays.len()), Some(2));
    let sideways = Emitter::point(3.0 * Vec3::X, Vec3::ONE, 1.0, Emission::Isotropic).unwrap();
    assert_eq!(tiles.reached(&sideways), Some(Vec::new()));
}

#[test]
fn tiles_do_not_depend_on_threads() {
    let mut random = Random::new(3);
    let rays = rays(&mut random);
    let light = light(&mut random, &rays);
    let on = |cpu: Cpu| {
        RayTiles::new(&cpu, &rays, WIDTH, None)
            .unwrap()
            .reached(&light)
    };
    assert_eq!(
        on(Cpu::single_threaded()),
        on(Cpu::with_threads(3).unwrap())
    );
}

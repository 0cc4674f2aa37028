use std::f32::consts::FRAC_PI_2;

use glam::{Quat, Vec3};
use gpu_backend::Cpu;
use reference::random::Random;

use super::*;
use crate::scene::{Camera, Cone, Emission, Emitter, Medium, PhaseFunction};
use crate::{LightPath, Ray};

pub(crate) const WIDTH: u32 = 37;
pub(crate) const HEIGHT: u32 = 21;

fn vector(random: &mut Random, size: f32) -> Vec3 {
    Vec3::from_array(random.vector(size))
}

/// Rays of a random eye, some of which go on for ever.
pub(crate) fn rays(random: &mut Random) -> Vec<Ray> {
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
pub(crate) fn light(random: &mut Random, rays: &[Ray]) -> Emitter {
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

#[cfg(feature = "rayon")]
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

/// Lights with bounds, and one without in the midst of them.
pub(crate) fn lights(random: &mut Random, rays: &[Ray], count: usize) -> Vec<Emitter> {
    let mut lights: Vec<Emitter> = (0..count).map(|_| light(random, rays)).collect();
    let endless = Emitter::point(
        rays[0].at(1.0),
        Vec3::ONE,
        f32::INFINITY,
        Emission::Isotropic,
    );
    lights.insert(count / 2, endless.unwrap());
    lights
}

/// Whether a point gets light, as surfaces find out.
fn is_lit(point: Vec3, light: &Emitter) -> bool {
    let Emitter::Point(lamp) = light else {
        return true;
    };
    let offset = lamp.position() - point;
    let distance = offset.length();
    let factor = || lamp.emission().factor(-offset / distance);
    distance > 0.0 && distance <= lamp.range() && factor() != Vec3::ZERO
}

/// The same rays from a place far away, where coordinates are coarse.
fn moved(rays: &[Ray], by: Vec3) -> Vec<Ray> {
    let moved = |ray: &Ray| Ray::new(ray.origin() + by, ray.direction(), ray.length()).unwrap();
    rays.iter().map(moved).collect()
}

#[test]
fn no_light_that_reaches_a_ray_or_a_point_of_it_is_missing_from_its_list() {
    let mut random = Random::new(4);
    let cpu = Cpu::new();
    let (mut listed, mut asked) = (0, 0);
    for set in 0..60 {
        let mut rays = rays(&mut random);
        if set % 3 == 0 {
            rays = moved(&rays, vector(&mut random, 3e4));
        }
        let lights = lights(&mut random, &rays, 40);
        let tiles = tiles(&rays);
        let lists = TileLights::new(&cpu, &tiles, &lights).unwrap();
        let truths: Vec<Vec<bool>> = lights.iter().map(|light| truth(&rays, light)).collect();
        let clusters = Clusters::new(&cpu, lists.clone()).unwrap();
        for (i, ray) in rays.iter().enumerate() {
            let list: Vec<u32> = lists.of_ray(i, ray.length()).collect();
            assert!(list.is_sorted_by(|a, b| a < b));
            let missing = (0..)
                .zip(&truths)
                .find(|(light, reached)| reached[i] && !list.contains(light));
            assert_eq!(missing.map(|(light, _)| light), None, "{ray:?}");
            listed += list.len();
            // The end, where it has one, and a place before it.
            let end = ray.length().min(1e3);
            for distance in [end, random.unit() * end] {
                let list: Vec<u32> = clusters.at(i, distance).collect();
                assert!(list.is_sorted_by(|a, b| a < b));
                let point = ray.at(distance);
                for (number, light) in (0..).zip(&lights) {
                    let there = list.contains(&number);
                    assert!(there || !is_lit(point, light), "{point} {light:?}");
                }
                asked += list.len();
            }
        }
    }
    println!("{listed} lights of rays, {asked} of points");
    assert!(2 * asked < 41 * 60 * 2 * (WIDTH * HEIGHT) as usize);
}

#[test]
fn lists_know_no_rays_and_tiles_that_there_are_not() {
    let mut random = Random::new(8);
    let rays = rays(&mut random);
    let tiles = tiles(&rays);
    let lights = lights(&mut random, &rays, 9);
    let lists = TileLights::new(&Cpu::new(), &tiles, &lights).unwrap();
    assert_eq!(
        (tiles.tile_of(rays.len()), tiles.rays_of(usize::MAX)),
        (None, &[][..])
    );
    assert_eq!(lists.of_ray(rays.len(), 1.0).count(), 0);
    assert!(lists.of_tile(tiles.tiles()).is_empty() && lists.of_tile(usize::MAX).is_empty());
    let none = TileLights::new::<Emitter>(&Cpu::new(), &tiles, &[]).unwrap();
    assert_eq!((none.entries(), none.emitters()), (0, 0));
    let clusters = Clusters::new(&Cpu::new(), lists).unwrap();
    assert_eq!(clusters.at(rays.len(), 1.0).count(), 0);
    assert!(clusters.clusters() > 0 && clusters.entries() > 0);
}

#[test]
fn lists_that_would_be_huge_are_refused() {
    let mut random = Random::new(9);
    let rays = rays(&mut random);
    let tiles = tiles(&rays);
    let sun = Emitter::directional(Vec3::Y, Vec3::ONE).unwrap();
    let many = vec![&sun; MOST_LISTED / tiles.tiles() + 1];
    let error = TileLights::new(&Cpu::new(), &tiles, &many).unwrap_err();
    assert!(
        error.to_string().contains(&many.len().to_string()),
        "{error}"
    );
    let fewer = TileLights::new(&Cpu::new(), &tiles, &many[1..]).unwrap();
    assert!(fewer.entries() <= MOST_LISTED);
}

#[cfg(feature = "rayon")]
#[test]
fn lists_do_not_depend_on_threads() {
    let mut random = Random::new(6);
    let rays = rays(&mut random);
    let lights = lights(&mut random, &rays, 50);
    let tiles = tiles(&rays);
    let on = |cpu: Cpu| {
        let lists = TileLights::new(&cpu, &tiles, &lights).unwrap();
        let clusters = Clusters::new(&cpu, lists).unwrap();
        let points = (0..rays.len()).map(|i| clusters.at(i, rays[i].length()).collect());
        points.collect::<Vec<Vec<u32>>>()
    };
    let one = on(Cpu::single_threaded());
    assert_eq!(one, on(Cpu::with_threads(3).unwrap()));
}

/// Leaves all along the depth of every tile, and lamps all along, too, of a radius of twenty
/// pixels.
#[test]
fn clusters_ask_few_lights_for_nothing_and_far_fewer_than_tiles_where_depths_differ() {
    let (width, height) = (96, 64);
    let mut random = Random::new(7);
    let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0).unwrap();
    let direction = |i: u32| {
        let [x, y] = [i % width, i / width].map(|place| place as f32 + 0.5);
        camera.direction(x, y, width, height)
    };
    let rays: Vec<Ray> = (0..width * height)
        .map(|i| {
            let length = random.log_uniform(2.0, 200.0) as f32;
            Ray::new(Vec3::ZERO, direction(i), length).unwrap()
        })
        .collect();
    let lights: Vec<Emitter> = (0..400)
        .map(|_| {
            let distance = random.log_uniform(2.0, 200.0) as f32;
            let at = distance * direction(random.below(width * height));
            Emitter::point(at, Vec3::ONE, 0.3 * distance, Emission::Isotropic).unwrap()
        })
        .collect();
    let tiles = RayTiles::new(&Cpu::new(), &rays, width, None).unwrap();
    let lists = TileLights::new(&Cpu::new(), &tiles, &lights).unwrap();
    let clusters = Clusters::new(&Cpu::new(), lists.clone()).unwrap();
    let (mut of_tiles, mut of_clusters, mut lit) = (0, 0, 0);
    let (mut of_rays, mut reached) = (0, 0);
    for (i, ray) in rays.iter().enumerate() {
        let tile = tiles.tile_of(i).unwrap();
        of_tiles += lists.of_tile(tile).len();
        of_rays += lists.of_ray(i, ray.length()).count();
        of_clusters += clusters.at(i, ray.length()).count();
        let end = ray.at(ray.length());
        lit += lights.iter().filter(|light| is_lit(end, light)).count();
    }
    for light in &lights {
        reached += truth(&rays, light).iter().filter(|is| **is).count();
    }
    println!(
        "points: {of_tiles} by tiles, {of_clusters} by clusters, {lit} lit; \
         rays: {of_rays} asked, {reached} reached"
    );
    assert!(of_tiles > 3 * of_clusters);
    assert!(10 * of_clusters < 13 * lit && 10 * of_rays < 13 * reached);
}

//! Lights that are culled give the same pictures, bit for bit.

use std::sync::Arc;

use crepuscular_tests::frames::{image, inputs};
use crepuscular_tests::scenes::maps;
use crepuscular_tests::suite::Subject;
use glam::{Quat, Vec3};
use gpu_backend::{Cpu, Host};
use lighting::airlight::EquiAngular;
use lighting::culling::RayTiles;
use lighting::methods::{Entry, Frame, FrameInputs, Registry, Selection, Store, share_cover};
use lighting::scene::procedural::Embedded;
use lighting::scene::view::{Cover, CoverStep};
use lighting::scene::{Camera, Cone, Emission, Medium, PhaseFunction};
use lighting::visibility::{March, Spacing, Unshadowed};
use lighting::{Emitter, LightPath, LitRays, Ray};
use reference::random::Random;
use reference::scenes::TestScene;
use reference::shapes;

crepuscular_tests::on_every_backend!(
    random_lights_that_are_culled_give_the_same_bits,
    shadowed_lights_that_are_culled_give_the_same_bits,
    lights_with_precomputed_shadows_give_the_same_bits_together,
    hair_dims_the_air_behind_it_however_many_lights_there_are,
);

/// The pictures are of so many pixels.
const SIZE: [u32; 2] = [19, 11];

/// A view of `count` lights with bounds, and of one without in the midst of them.
fn random_view(random: &mut Random, count: usize) -> (Camera, Vec<Ray>, Vec<Emitter>) {
    let eye = Vec3::from_array(random.vector(4.0));
    let target = eye + Vec3::from_array(random.vector(1.0)) + Vec3::splat(1e-3);
    let camera = Camera::look_at(eye, target, random.log_uniform(0.02, 2.9) as f32).unwrap();
    let rays = (0..SIZE[0] * SIZE[1]).map(|i| {
        let [x, y] = [i % SIZE[0], i / SIZE[0]].map(|place| place as f32 + 0.5);
        let length = match random.below(3) {
            0 => f32::INFINITY,
            _ => random.log_uniform(0.1, 100.0) as f32,
        };
        Ray::new(eye, camera.direction(x, y, SIZE[0], SIZE[1]), length).unwrap()
    });
    let rays: Vec<Ray> = rays.collect();
    let lights = (0..count).map(|i| {
        let ray = rays[random.below(rays.len() as u32) as usize];
        let distance = random.log_uniform(0.1, 50.0) as f32;
        let position = ray.at(distance) + 0.2 * distance * Vec3::from_array(random.vector(1.0));
        let axis = Vec3::from_array(random.vector(1.0)) + Vec3::splat(1e-3);
        let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, axis.normalize());
        let cone = Cone {
            inner: 0.0,
            outer: random.log_uniform(0.02, 1.5) as f32,
        };
        let range = 0.5 * distance * random.log_uniform(0.05, 2.0) as f32;
        let (range, emission) = match (2 * i == count, random.below(3)) {
            (true, _) => (f32::INFINITY, Emission::Isotropic),
            (_, 0) => (range, Emission::Isotropic),
            (_, 1) => (range, Emission::spot(rotation, cone, None).unwrap()),
            _ => (f32::INFINITY, Emission::spot(rotation, cone, None).unwrap()),
        };
        Emitter::point(position, Vec3::new(3.0, 2.0, 1.0), range, emission).unwrap()
    });
    let lights = lights.collect();
    (camera, rays, lights)
}

/// Lights that reach less than three quarters of the rays.
fn culled_of(rays: &[Ray], width: u32, emitters: &[Emitter]) -> usize {
    let tiles = RayTiles::new(&Cpu::new(), rays, width, None).unwrap();
    let is_culled = |light: &&Emitter| {
        let reached = tiles.reached(light);
        reached.is_some_and(|reached| 4 * reached.len() < 3 * rays.len())
    };
    emitters.iter().filter(is_culled).count()
}

fn bits(picture: &[[f32; 4]]) -> Vec<[u32; 4]> {
    picture
        .iter()
        .map(|pixel| pixel.map(f32::to_bits))
        .collect()
}

/// A thousand sets of lights and eyes on a CPU; on a GPU, whose driver may be software, as
/// many as take a few seconds.
fn random_lights_that_are_culled_give_the_same_bits<B: Subject>(backend: &B) {
    let is_cpu = std::any::type_name::<B>() == std::any::type_name::<Cpu>();
    let sets = if is_cpu { 1000 } else { 20 };
    let fog = Medium::new(
        Vec3::splat(0.05),
        Vec3::splat(0.01),
        PhaseFunction::Isotropic,
    )
    .unwrap();
    let geometry = shapes::nothing();
    let method: Entry = Registry::standard().pair("none", "gauss", Some(3)).unwrap();
    let airlight = EquiAngular::new(3).unwrap();
    let mut random = Random::new(5);
    let mut culled_lights = 0;
    for set in 0..sets {
        let (camera, rays, emitters) = random_view(&mut random, 8 + set % 9);
        let hits = vec![None; rays.len()];
        let host = Store::<Host>::new();
        let inputs = FrameInputs {
            emitters: &emitters,
            areas: &[],
            medium: &fog,
            height_fog: None,
            geometry: &geometry,
            translucent: &[],
            camera: &camera,
            size: SIZE,
            rays: &rays,
            hits: &hits,
            map: 16,
            host: &host,
            selection: Selection::default(),
            watch: &(),
        };
        let culled = image(backend, inputs, &method, 3).unwrap().unwrap();
        let uploaded = backend.upload(&rays).unwrap();
        let mut whole = backend.zeros::<[f32; 4]>(rays.len()).unwrap();
        for emitter in &emitters {
            let lit = LitRays::new(&uploaded, emitter, &fog);
            backend
                .gather(&lit, &Unshadowed, &airlight, &mut whole)
                .unwrap();
        }
        assert!(
            bits(&culled) == bits(&backend.download(&whole).unwrap()),
            "set {set}"
        );
        culled_lights += culled_of(&rays, SIZE[0], &emitters);
    }
    assert!(culled_lights > 2 * sets, "{culled_lights}");
}

/// Spotlights above a city, all and alone, and those of half of the pixels.
fn shadowed_lights_that_are_culled_give_the_same_bits<B: Subject>(backend: &B) {
    let mut scene = TestScene::new(Embedded::City, 32, 18);
    scene.emitters = spots(&scene, 12);
    let method = Registry::standard()
        .pair("march", "gauss", Some(1))
        .unwrap();
    let host = Store::new();
    let of_all = inputs(&scene, 64, &host);
    let pixels: Vec<u32> = (0..scene.rays.len() as u32).step_by(2).collect();
    let rays: Vec<Ray> = pixels.iter().map(|i| scene.rays[*i as usize]).collect();
    let hits: Vec<_> = pixels.iter().map(|i| scene.hits[*i as usize]).collect();
    let of_some = FrameInputs {
        rays: &rays,
        hits: &hits,
        selection: Selection {
            pixels: Some(&pixels),
            ..Selection::default()
        },
        ..of_all
    };
    assert!(culled_of(&scene.rays, scene.size[0], &scene.emitters) > 6);
    let maps = maps(backend, &scene, 64);
    let one = EquiAngular::new(1).unwrap();
    for inputs in [of_all, of_some] {
        let culled = image(backend, inputs, &method, 16).unwrap().unwrap();
        let rays = backend.upload(inputs.rays).unwrap();
        let mut whole = backend.zeros::<[f32; 4]>(inputs.rays.len()).unwrap();
        for (emitter, map) in scene.emitters.iter().zip(&maps) {
            let march = March::new(map, 16, Spacing::Distance);
            let lit = LitRays::new(&rays, emitter, &scene.medium);
            backend.gather(&lit, &march, &one, &mut whole).unwrap();
        }
        let whole = backend.download(&whole).unwrap();
        assert!(bits(&culled) == bits(&whole));
        assert!(whole.iter().any(|pixel| pixel[0] > 0.0));
    }
}

/// All lights of a frame at once, and frames of one light each, which are below the number
/// that is culled.
fn lights_with_precomputed_shadows_give_the_same_bits_together<B: Subject>(backend: &B) {
    let mut scene = TestScene::new(Embedded::City, 32, 18);
    let mut lights = spots(&scene, 9);
    lights.insert(4, scene.emitters[0].clone());
    scene.emitters = lights;
    for airlight in ["gauss", "table"] {
        let method = Registry::standard().pair("precomputed", airlight, None);
        let method = method.unwrap();
        let host = Store::new();
        let of_all = inputs(&scene, 16, &host);
        let together = image(backend, of_all, &method, 64).unwrap().unwrap();
        let method = method.on::<B>().unwrap();
        let mut whole = backend.zeros::<[f32; 4]>(scene.rays.len()).unwrap();
        for light in &scene.emitters {
            let (host, store) = (Store::new(), Store::new());
            let of_one = FrameInputs {
                emitters: std::slice::from_ref(light),
                host: &host,
                ..of_all
            };
            let frame = Frame::new(backend, of_one, &store).unwrap();
            method.add_radiance(&frame, 64, &mut whole).unwrap();
        }
        let whole = backend.download(&whole).unwrap();
        assert!(bits(&together) == bits(&whole), "{airlight}");
        assert!(whole.iter().any(|pixel| pixel[0] > 0.0));
    }
}

/// Lamps of streets: spotlights that look down from above where rays of the view end.
fn spots(scene: &TestScene, count: usize) -> Vec<Emitter> {
    let mut random = Random::new(3);
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let ends: Vec<&Ray> = scene.rays.iter().filter(|ray| ray.length() < 1e6).collect();
    let cone = Cone {
        inner: 0.6,
        outer: 0.9,
    };
    let spot = |_| {
        let ray = ends[random.below(ends.len() as u32) as usize];
        let position = ray.at(ray.length()) + 5.0 * Vec3::Y;
        let emission = Emission::spot(down, cone, None).unwrap();
        Emitter::point(position, Vec3::splat(50.0), 12.0, emission).unwrap()
    };
    (0..count).map(spot).collect()
}

/// The lamps of a city, in a picture of a usual size.
#[test]
fn few_lights_are_tested_for_nothing() {
    let scene = TestScene::new(Embedded::City, 480, 270);
    let tiles = RayTiles::new(&Cpu::new(), &scene.rays, scene.size[0], None).unwrap();
    let (mut tested, mut reached) = (0, 0);
    for light in spots(&scene, 165) {
        let rays = tiles.reached(&light).unwrap();
        tested += rays.len();
        let reaches = |ray: &&Ray| LightPath::new(ray, &light, &scene.medium).is_some();
        reached += scene.rays.iter().filter(reaches).count();
    }
    let share = tested as f64 / reached as f64;
    println!("{tested} rays are tested, {reached} are reached: {share:.3}");
    assert!(reached > 100_000 && (1.0..1.3).contains(&share), "{share}");
}

/// Half of each ray's light is covered from the eye on, and none of it.
fn hair_dims_the_air_behind_it_however_many_lights_there_are<B: Subject>(backend: &B) {
    let fog = Medium::new(Vec3::splat(0.05), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let geometry = shapes::nothing();
    let method: Entry = Registry::standard().pair("none", "gauss", Some(3)).unwrap();
    assert!(method.method().sees_cover());
    let mut random = Random::new(11);
    for count in [3, 40] {
        let (camera, rays, emitters) = random_view(&mut random, count);
        let hits = vec![None; rays.len()];
        let (open, covered) = (Store::<Host>::new(), Store::<Host>::new());
        let half = CoverStep {
            distance: 0.0,
            share: 0.5,
        };
        let cover = Cover::new(rays.iter().map(|_| [half]));
        share_cover(&covered, &Arc::new(cover));
        let [open, covered] = [&open, &covered].map(|host| {
            let inputs = FrameInputs {
                emitters: &emitters,
                areas: &[],
                medium: &fog,
                height_fog: None,
                geometry: &geometry,
                translucent: &[],
                camera: &camera,
                size: SIZE,
                rays: &rays,
                hits: &hits,
                map: 16,
                host,
                selection: Selection::default(),
                watch: &(),
            };
            image(backend, inputs, &method, 3).unwrap().unwrap()
        });
        for (open, covered) in open.iter().zip(&covered) {
            for channel in 0..3 {
                let off = covered[channel] - 0.5 * open[channel];
                assert!(
                    off.abs() <= 1e-5 * open[channel],
                    "{count}: {open:?} {covered:?}"
                );
            }
        }
    }
}

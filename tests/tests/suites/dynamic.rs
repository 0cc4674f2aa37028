//! Static casters in precomputed shadows and dynamic ones in maps, against exact
//! visibility and the reference image.

use std::sync::Arc;

use crepuscular_tests::frames::{image, inputs};
use crepuscular_tests::on_every_backend;
use crepuscular_tests::suite::{self, Subject};
use glam::{Affine3A, Vec3};
use gpu_backend::Cpu;
use lighting::methods::epipolar::MapRuns;
use lighting::methods::{
    Entry, FROM_FILE, Frame, FrameInputs, Registry, Store, Verdict, forget_dynamic,
    share_precomputed,
};
use lighting::precomputed::{BakedShadow, Builder, Resolution};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::{Emission, Instance, Medium, Mesh, PhaseFunction, Scene};
use lighting::shadow_map::{Casters, RenderShadowMap, reached};
use lighting::visibility::{Both, Exact};
use lighting::{Emitter, Interval, LightPath, VisibilitySource};
use proptest::prelude::*;
use reference::generators::{emitter, ray, soup};
use reference::metrics::image_error;
use reference::property::holds_for;
use reference::scenes::TestScene;
use reference::shapes;
use reference::tolerances::Allowed;

fn fog() -> Medium {
    Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic).unwrap()
}

fn pair() -> Entry {
    let registry = Registry::standard();
    let pair = registry.pair(lighting::methods::PRECOMPUTED, "gauss", Some(8));
    pair.unwrap()
}

/// Length that is in the parts of one list and not in those of another.
fn apart(a: &[Interval], b: &[Interval]) -> f32 {
    let covered = |part: &Interval| -> f32 {
        let common = |other: &Interval| other.end.min(part.end) - other.start.max(part.start);
        b.iter().map(|other| common(other).max(0.0)).sum()
    };
    let beyond = |part: &Interval| (part.end - part.start - covered(part)).max(0.0);
    a.iter().map(beyond).sum()
}

fn differ(a: &[Interval], b: &[Interval]) -> f32 {
    apart(a, b) + apart(b, a)
}

fn lit<V: VisibilitySource>(source: &V, path: &LightPath<'_>) -> Vec<Interval> {
    let mut lit = Vec::new();
    source.lit_intervals(path, &mut lit);
    lit.iter().map(|part| part.interval).collect()
}

/// Where both are right, so is what they have in common: whatever casters are shared out
/// among grids and maps, they are wrong nowhere else than either is by itself.
#[test]
fn casters_shared_out_at_random_are_wrong_where_a_grid_or_a_map_is() {
    let medium = fog();
    let rays = prop::collection::vec(ray(10.0), 40);
    let cpu = Cpu::new();
    let side = Resolution::new(256).unwrap();
    holds_for(
        60,
        (soup(10.0, 20), soup(10.0, 20), emitter(10.0), rays),
        |(still, moving, light, rays)| {
            let all = shapes::geometry(&[still.clone(), moving.clone()].concat());
            let [still, moving] = [still, moving].map(|list| shapes::geometry(&list));
            let [all, of_still, of_moving] = [&all, &still, &moving].map(Tracer::new);
            let baked = BakedShadow::bake(&cpu, &still, &light, side, Builder::new());
            let baked = baked.unwrap().0;
            let casters = Casters::upload(&cpu, &moving).unwrap();
            let map = reached(moving.bounds(), &light).map(|within| {
                let map = cpu.shadow_map_within(&casters, within, &light, 256);
                Arc::new(map.unwrap())
            });
            for ray in &rays {
                let ray = ray.with_length(ray.length().min(40.0));
                let Some(path) = LightPath::new(&ray, &light, &medium) else {
                    continue;
                };
                let expected = lit(&Exact::new(&all), &path);
                let of_grids = lit(&baked, &path);
                let mut wrong = differ(&of_grids, &lit(&Exact::new(&of_still), &path));
                let exact = lit(&Exact::new(&of_moving), &path);
                let found = match &map {
                    Some(map) => {
                        let runs = MapRuns::walked(map.clone());
                        wrong += differ(&lit(&runs, &path), &exact);
                        lit(&Both(&baked, runs), &path)
                    }
                    // Nothing that the light lights is in the shadow of what moves.
                    None => {
                        let open = differ(&exact, &[path.span()]);
                        prop_assert!(open <= 1e-3, "{open}");
                        of_grids
                    }
                };
                let wrong_together = differ(&found, &expected);
                prop_assert!(wrong_together <= wrong + 1e-3, "{wrong_together} {wrong}");
            }
            Ok(())
        },
    );
}

/// The same triangles, none of which moves.
fn standing_still(embedded: Embedded) -> Scene {
    let mut scene = embedded.build(1);
    for instance in &mut scene.instances {
        instance.dynamic = false;
    }
    scene
}

/// Against a reference in which it does not matter what moves.
fn traffic_is_as_right_as_the_same_city_without_motion<B: Subject>(backend: &B) {
    let moving = TestScene::new(Embedded::Traffic, 48, 27);
    let still = TestScene::of("still", standing_still(Embedded::Traffic), 48, 27);
    let truth = moving.truth();
    let error = |scene: &TestScene, [voxels, texels]: [u32; 2]| {
        let host = Store::new();
        let image = image(backend, inputs(scene, texels, &host), &pair(), voxels);
        image_error(&image.unwrap().unwrap(), &truth).rmse
    };
    let baked = error(&still, [2048, 64]);
    let mapped = error(&moving, [2048, 1024]);
    let coarse = error(&moving, [2048, 32]);
    println!("{baked} baked, {mapped} with maps, {coarse} with coarse maps");
    assert!(mapped <= 1.1 * baked, "{mapped} {baked}");
    assert!(
        coarse > 1.02 * mapped,
        "maps have shadows: {coarse} {mapped}"
    );
}

/// Boxes in a row on a floor, a lamp above each; every third box is dynamic.
fn row_of_lamps() -> TestScene {
    row_of_lamps_moved(0.0)
}

/// The same where the dynamic ones have moved so far along the row.
fn row_of_lamps_moved(by: f32) -> TestScene {
    let mut scene = Scene::default();
    let triangles = |mesh: &[[Vec3; 3]]| Mesh {
        positions: mesh.as_flattened().to_vec(),
        triangles: (0..mesh.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect(),
        ..Mesh::default()
    };
    let floor = shapes::cuboid(Vec3::new(-30.0, -1.0, -9.0), Vec3::new(30.0, 0.0, 3.0));
    let cube = shapes::cuboid(Vec3::new(-0.5, 0.5, -0.5), Vec3::new(0.5, 1.5, 0.5));
    scene.meshes = vec![triangles(&floor), triangles(&cube)];
    scene.instances.push(Instance::default());
    let camera =
        lighting::scene::Camera::look_at(Vec3::new(0.0, 3.0, 14.0), Vec3::new(0.0, 1.0, 0.0), 1.0);
    scene.camera = Some(camera.unwrap());
    scene.medium = Some(fog());
    for i in 0..12 {
        let dynamic = i % 3 == 0 && i < 6;
        let x = 4.0 * i as f32 - 22.0 + if dynamic { by } else { 0.0 };
        scene.instances.push(Instance {
            mesh: 1,
            transform: Affine3A::from_translation(Vec3::new(x, 0.0, -1.0)),
            dynamic,
            ..Instance::default()
        });
    }
    let mut test_scene = TestScene::of("lamps", scene, 48, 27);
    test_scene.emitters = (0..12)
        .map(|i| {
            let at = Vec3::new(4.0 * i as f32 - 21.7, 2.6, -0.8);
            Emitter::point(at, Vec3::splat(3.0), 3.5, Emission::Isotropic).unwrap()
        })
        .collect();
    test_scene
}

const VOXELS: u32 = 256;
const TEXELS: u32 = 256;

/// Lights that nothing dynamic reaches are gathered together, and all in their order.
#[test]
fn lights_together_have_the_bits_of_one_after_the_other() {
    let scene = row_of_lamps();
    let host = Store::new();
    let all = inputs(&scene, TEXELS, &host);
    let is_reached: Vec<bool> = (0..12).map(|i| all.dynamic_reached(i).is_some()).collect();
    assert!(is_reached[..4].iter().all(|reached| *reached));
    assert!(is_reached[6..].iter().all(|reached| !reached));
    let cpu = Cpu::new();
    let together = image(&cpu, all, &pair(), VOXELS).unwrap().unwrap();

    let mut one_by_one = vec![[0.0; 4]; scene.rays.len()];
    for light in 0..12 {
        let host = Store::new();
        let alone = FrameInputs {
            emitters: &scene.emitters[light..=light],
            ..inputs(&scene, TEXELS, &host)
        };
        let frame = Frame::new(&cpu, alone, &host).unwrap();
        let entry = pair();
        let method = entry.on::<Cpu>().unwrap();
        method
            .add_radiance(&frame, VOXELS, &mut one_by_one)
            .unwrap();
    }
    assert!(together == one_by_one);
}

/// Rays that differ by more than rounding are those next to borders of voxels and texels.
fn check_backends(scene: &TestScene) {
    let Some(gpu) = suite::gpu() else { return };
    let host = Store::new();
    let all = inputs(scene, TEXELS, &host);
    let cpu = Cpu::new();
    let none = Registry::standard().pair("none", "gauss", Some(8)).unwrap();
    let open = image(&cpu, all, &none, 8).unwrap().unwrap();
    let expected = image(&cpu, all, &pair(), VOXELS).unwrap().unwrap();
    let actual = image(&gpu, all, &pair(), VOXELS).unwrap().unwrap();
    let differs = |i: &usize| {
        (0..3).any(|c| {
            let (e, a) = (f64::from(expected[*i][c]), f64::from(actual[*i][c]));
            (e - a).abs() > Allowed::GpuIntervals.error() * f64::from(open[*i][c])
        })
    };
    let different = (0..expected.len()).filter(differs).count();
    println!("{}: {different} of {} differ", scene.name, expected.len());
    let allowed = Allowed::GpuBakedRays.error() + Allowed::GpuMarchRays.error();
    assert!(
        different as f64 <= allowed * expected.len() as f64,
        "{different}"
    );
}

#[test]
fn both_backends_agree_on_lamps_and_on_traffic() {
    check_backends(&row_of_lamps());
    check_backends(&TestScene::new(Embedded::Traffic, 48, 27));
}

/// What moves is in no bake: frames of it take the shadows that were baked before the
/// first.
#[test]
fn frames_of_what_moves_bake_nothing_and_are_those_of_a_bake_of_their_own() {
    let cpu = Cpu::new();
    let mut scene = Embedded::Traffic.build(1);
    let first = TestScene::of("traffic", scene.clone(), 32, 18);
    let side = Resolution::new(512).unwrap();
    let fixed = first.geometry.static_part().unwrap();
    let bake = |emitter| BakedShadow::bake(&cpu, fixed, emitter, side, Builder::new());
    let baked: Vec<_> = (first.emitters.iter())
        .map(|emitter| Arc::new(bake(emitter).unwrap().0))
        .collect();
    let mut last = Vec::new();
    for _ in 0..3 {
        for instance in scene.instances.iter_mut().filter(|i| i.dynamic) {
            let step = Affine3A::from_translation(Vec3::new(3.0, 0.0, -2.0));
            instance.transform = step * instance.transform;
        }
        let frame = TestScene::of("traffic", scene.clone(), 32, 18);
        let host = Store::new();
        for (light, shadow) in baked.iter().enumerate() {
            share_precomputed(&host, light, shadow);
        }
        let shared = inputs(&frame, TEXELS, &host);
        let found = image(&cpu, shared, &pair(), FROM_FILE).unwrap().unwrap();
        let made: Vec<&str> = host.used().iter().map(|used| used.what).collect();
        assert!(
            made.iter()
                .filter(|what| what.contains("precomputed"))
                .count()
                <= 1,
            "{made:?}"
        );
        let own = Store::new();
        let own = inputs(&frame, TEXELS, &own);
        let expected = image(&cpu, own, &pair(), 512).unwrap().unwrap();
        assert!(found == expected && found != last);
        last = found;
    }
}

/// Frames whose stores are used again, against those with stores of their own.
fn check_stores<B: Subject>(backend: &B, frames: &[TestScene], lights: usize) {
    let maps = Registry::standard().pair("map-runs", "gauss", None);
    for (entry, quality) in [(pair(), 512), (maps.unwrap(), 8)] {
        let (host, store) = (Store::new(), Store::new());
        let mut last = Vec::new();
        for scene in frames {
            forget_dynamic(&host);
            forget_dynamic(&store);
            let again = inputs(scene, TEXELS, &host);
            let frame = Frame::new(backend, again, &store).unwrap();
            let mut radiance = backend.zeros::<[f32; 4]>(scene.rays.len()).unwrap();
            let method = entry.on::<B>().unwrap();
            method.add_radiance(&frame, quality, &mut radiance).unwrap();
            let found = backend.download(&radiance).unwrap();
            let own = Store::new();
            let expected = image(backend, inputs(scene, TEXELS, &own), &entry, quality);
            assert!(found == expected.unwrap().unwrap() && found != last);
            last = found;
        }
        let used = host.used();
        let bakes = used
            .iter()
            .filter(|used| used.what == "precomputed shadows");
        assert!(bakes.count() <= lights, "{used:?}");
    }
}

fn stores_that_forget_what_is_dynamic_are_as_good_as_new_and_bake_once<B: Subject>(backend: &B) {
    let mut scene = Embedded::Traffic.build(1);
    let frames = [0, 1, 2].map(|_| {
        for instance in scene.instances.iter_mut().filter(|i| i.dynamic) {
            let step = Affine3A::from_translation(Vec3::new(3.0, 0.0, -2.0));
            instance.transform = step * instance.transform;
        }
        TestScene::of("traffic", scene.clone(), 32, 18)
    });
    check_stores(backend, &frames, 1);
    let lamps = [0.0, 0.3, 0.6].map(row_of_lamps_moved);
    check_stores(backend, &lamps, 12);
}

on_every_backend! {
    heavy:
    traffic_is_as_right_as_the_same_city_without_motion,
    stores_that_forget_what_is_dynamic_are_as_good_as_new_and_bake_once,
}

#[test]
fn a_scene_in_which_all_moves_has_nothing_to_bake() {
    let mut scene = standing_still(Embedded::Coil);
    let names: Vec<String> = scene.meshes.iter().map(|mesh| mesh.name.clone()).collect();
    for name in &names {
        assert!(scene.set_dynamic(name, true) > 0);
    }
    let scene = TestScene::of("coil", scene, 8, 8);
    assert!(scene.geometry.static_part().is_none());
    let host = Store::new();
    let inputs = inputs(&scene, 32, &host);
    let verdict = pair().method().applies(&inputs);
    assert!(matches!(verdict, Verdict::Impossible(_)), "{verdict:?}");
    assert!(image(&Cpu::new(), inputs, &pair(), 64).is_err());
}

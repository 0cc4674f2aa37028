//! Area lights by many virtual lights against the oracle of an area light.

use crepuscular_tests::frames::{image, inputs};
use glam::Vec3;
use gpu_backend::{Cpu, Host};
use lighting::Emitter;
use lighting::methods::{FrameInputs, Registry, Store};
use lighting::scene::Pattern;
use lighting::scene::procedural::Embedded;
use lighting::shadow_map::{
    CasterPoints, Casters, LevelOfDetail, RenderImperfectMaps, RenderShadowMapAtlas, ShadowMapAtlas,
};
use reference::metrics::{ImageError, Reference, image_error};
use reference::oracle::area;
use reference::oracle::image::Options;
use reference::scenes::TestScene;

/// Relative; far below what is measured with it.
const TOLERANCE: f64 = 2e-3;

fn truth(scene: &TestScene) -> Reference {
    let areas: Vec<_> = scene.areas.iter().map(|area| area.light.clone()).collect();
    let options = Options {
        tolerance: TOLERANCE,
        ..Options::default()
    };
    area::reference(
        &scene.rays,
        &[],
        &areas,
        &scene.medium,
        &scene.geometry,
        options,
    )
}

fn error(inputs: FrameInputs<'_>, truth: &Reference, method: &str, quality: u32) -> ImageError {
    let registry = Registry::standard();
    let entry = registry.find(method).unwrap();
    let image = image(&Cpu::new(), inputs, &entry, quality)
        .unwrap()
        .unwrap();
    let error = image_error(&image, truth);
    println!("{method} {quality}: {:.5} {:.4}", error.rmse, error.max);
    error
}

/// The shares of points in the air that maps of 16 lights call lit and are not, and the
/// other way round.
fn wrong(maps: &ShadowMapAtlas<Host>, scene: &TestScene, lights: &[Emitter]) -> [f64; 2] {
    let mut counts = [0, 0, 0];
    for (index, ray) in scene.rays.iter().enumerate() {
        let way = ray.length().min(12.0) * (index % 17) as f32 / 17.0;
        let point = ray.at(way + 0.05);
        for (light, emitter) in lights.iter().enumerate() {
            let Emitter::Point(lamp) = emitter else {
                continue;
            };
            let to_point = point - lamp.position();
            let distance = to_point.length();
            let direction = to_point / distance;
            if lamp.emission().factor(direction) == Vec3::ZERO {
                continue;
            }
            let is_lit = !(scene.tracer).occluded(lamp.position(), direction, 0.0, distance);
            counts[2] += 1;
            if maps.is_lit(light, point) != is_lit {
                counts[usize::from(is_lit)] += 1;
            }
        }
    }
    [0, 1].map(|kind| f64::from(counts[kind]) / f64::from(counts[2]))
}

/// Imperfect maps against exact ones, over the number of points: the table that the
/// papers do not have.
#[test]
fn imperfect_maps_err_less_with_more_points_and_less_with_a_level_of_detail() {
    let scene = TestScene::new(Embedded::Pergola, 64, 36);
    let lights = scene.areas[0].light.virtual_lights(Pattern::Lattice, 16);
    let lights = lights.unwrap();
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &scene.geometry).unwrap();
    let exact = cpu.shadow_map_atlas(&casters, &lights, 128).unwrap();
    let exact = wrong(&exact, &scene, &lights);
    println!(
        "exact 128²: false-lit {:.5}, false-shadow {:.5}",
        exact[0], exact[1]
    );
    let points = CasterPoints::sample(&cpu, &scene.geometry, 1 << 17).unwrap();
    let mut rates = Vec::new();
    for level in [LevelOfDetail::Even, LevelOfDetail::Near] {
        for count in [512, 1024, 2048, 4096, 8192, 16_384] {
            let maps = cpu
                .imperfect_maps(&points, &lights, 128, count, level)
                .unwrap();
            let [lit, dark] = wrong(&maps, &scene, &lights);
            println!("{level:?} {count}: false-lit {lit:.5}, false-shadow {dark:.5}");
            rates.push([lit, lit + dark]);
        }
    }
    let (even, near) = rates.split_at(6);
    // Few points leave holes unless they are near the light; what is wrong with many
    // is that splats are wider than the edges of the casters.
    for few in 0..2 {
        assert!(5.0 * near[few][0] <= even[few][0], "{rates:?}");
    }
    for more in 1..6 {
        assert!(near[more][1] < even[more][1], "{rates:?}");
    }
    assert!(near[5][1] < 0.5 * near[0][1], "{rates:?}");
    assert!(exact[0] + exact[1] < 0.2 * near[5][1]);
}

/// Leaving the shadows out of this scene costs a third of its light. Runs go on
/// converging; the average stops where its floor is.
#[test]
fn runs_converge_to_the_area_light_and_the_average_has_a_floor() {
    let scene = TestScene::new(Embedded::Pergola, 48, 27);
    let truth = truth(&scene);
    assert!(truth.max_bound() < 0.05 * truth.mean());
    let host = Store::new();
    let inputs = inputs(&scene, 128, &host);

    let bare = {
        let emitters = scene.areas[0].light.virtual_lights(Pattern::Lattice, 256);
        let emitters = emitters.unwrap();
        let inputs = FrameInputs {
            emitters: &emitters,
            areas: &[],
            ..inputs
        };
        error(inputs, &truth, "none x gauss", 8).rmse
    };
    assert!(bare >= 0.3, "{bare}");

    let [few, more, most] = [16, 64, 256].map(|n| error(inputs, &truth, "area-runs", n).rmse);
    assert!(few > more && more > most, "{few} {more} {most}");
    assert!(more <= 0.025, "{more}");
    assert!(most <= 0.008, "{most}");
    let voxels = error(inputs, &truth, "area-voxels", 256).rmse;
    assert!(voxels <= 0.01, "{voxels}");
    let floor = [64, 256].map(|n| error(inputs, &truth, "area-average", n).rmse);
    assert!(
        floor[1] > 2.0 * most && floor[1] > 0.7 * floor[0],
        "{floor:?}"
    );
}

/// Rays whose points are even converge faster than independent ones, which would halve
/// their error with four times as many: 4 times from 16 to 256. What is left at the end
/// is noise, whose mean over the picture is within three of its deviations.
#[test]
fn traced_rays_and_runs_are_unbiased_and_converge_faster_than_independent_ones() {
    let scene = TestScene::new(Embedded::Pergola, 32, 18);
    let truth = truth(&scene);
    let host = Store::new();
    let inputs = inputs(&scene, 128, &host);
    for (method, counts) in [
        ("area-rays", [16, 256, 1024]),
        ("area-traced-runs", [4, 64, 256]),
    ] {
        let errors = counts.map(|count| error(inputs, &truth, method, count));
        let [few, more, most] = errors.map(|error| error.rmse);
        assert!(
            few > 4.0 * more && more > 1.5 * most,
            "{method}: {few} {more} {most}"
        );
        let registry = Registry::standard();
        let entry = registry.find(method).unwrap();
        let image = image(&Cpu::new(), inputs, &entry, counts[1])
            .unwrap()
            .unwrap();
        let sum = |pixel: &[f32; 4]| f64::from(pixel[0] + pixel[1] + pixel[2]);
        let mean = image.iter().map(sum).sum::<f64>() / (3 * image.len()) as f64;
        let bias = (mean / truth.mean() - 1.0).abs();
        let allowed = 3.0 * more / (image.len() as f64).sqrt() + TOLERANCE;
        println!("{method}: bias {bias:.5} of {allowed:.5}");
        assert!(bias < allowed, "{method}: {bias} {allowed}");
    }
}

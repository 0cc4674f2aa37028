//! Gathers through smoke against the truth, and against each other.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

use crepuscular_tests::frames::{image, inputs};
use glam::{Quat, Vec3};
use gpu_backend::Cpu;
use lighting::methods::{Registry, Store};
use lighting::scene::procedural::{Embedded, smoke_grid, smoke_particles};
use lighting::scene::{Cone, Emission, HeightFog, Medium, PhaseFunction, Translucent};
use lighting::{Emitter, Ray};
use reference::metrics::image_error;
use reference::oracle::media::{Air, MediaWorld, reference as of_media};
use reference::scenes::TestScene;

/// A stage with smoke and no hair, which gathers do not see.
fn stage() -> TestScene {
    let mut scene = TestScene::new(Embedded::Translucent, 32, 18);
    scene
        .translucent
        .retain(|caster| !matches!(caster, Translucent::Strands(_)));
    scene
}

#[test]
fn every_gather_converges_to_the_truth() {
    let scene = stage();
    let air = Air {
        medium: Some(&scene.medium),
        height_fog: None,
        translucent: &scene.translucent,
    };
    let world = MediaWorld::new(air, &scene.emitters, &scene.geometry);
    let truth = of_media(&world, &scene.rays, 1e-3);
    let host = Store::new();
    let inputs = inputs(&scene, 1024, &host);
    for entry in Registry::standard().all() {
        if !entry.method().sees_uneven_media() {
            continue;
        }
        let about = entry.about();
        let errors = [16, 128].map(|steps| {
            let image = image(&Cpu::new(), inputs, entry, steps).unwrap().unwrap();
            image_error(&image, &truth).rmse
        });
        println!("{}: {errors:.2e?}", about.name);
    }
}

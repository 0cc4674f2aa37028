//! Gathers through smoke against the truth.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

use crepuscular_tests::frames::{image, inputs};
use gpu_backend::Cpu;
use lighting::methods::{Method, Registry, Role, Store};
use lighting::scene::Translucent;
use lighting::scene::procedural::Embedded;
use reference::metrics::image_error;
use reference::oracle::media::{Air, MediaWorld, reference as of_media};
use reference::scenes::TestScene;

/// The embedded scene of smoke, without its hair, which gathers do not see.
fn smoke() -> TestScene {
    let mut scene = TestScene::new(Embedded::Translucent, 14, 8);
    let is_hair = |caster: &Translucent| matches!(caster, Translucent::Strands(_));
    scene.translucent.retain(|caster| !is_hair(caster));
    scene
}

#[test]
fn every_gather_through_smoke_comes_near_the_truth() {
    let scene = smoke();
    let air = Air {
        medium: Some(&scene.medium),
        height_fog: None,
        translucent: &scene.translucent,
    };
    let world = MediaWorld::new(air, &scene.emitters, &scene.geometry);
    let truth = of_media(&world, &scene.rays, 5e-3);
    let host = Store::new();
    let inputs = inputs(&scene, 1024, &host);
    let mut best = f64::INFINITY;
    for entry in Registry::standard().all() {
        let about = entry.about();
        if !entry.sees_heterogeneous_media() {
            continue;
        }
        let errors = [16, 128].map(|steps| {
            let image = image(&Cpu::new(), inputs, entry, steps).unwrap().unwrap();
            image_error(&image, &truth).rmse
        });
        let is_right = match about.role {
            // Shadows of smoke are worth something.
            Role::Unshadowed => errors[1] > 0.5,
            Role::Baseline => errors[1] < 0.3,
            _ => errors[1] < 0.15 && errors[1] < errors[0],
        };
        assert!(is_right, "{}: {errors:?}", about.name);
        best = best.min(errors[1]);
    }
    // The reference itself is known to half of that.
    assert!(best < 0.01, "{best}");
}

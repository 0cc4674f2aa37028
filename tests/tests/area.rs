//! Area lights by many virtual lights against the oracle of an area light.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

use crepuscular_tests::frames::{image, inputs};
use gpu_backend::Cpu;
use lighting::methods::{FrameInputs, Registry, Store};
use lighting::scene::Pattern;
use lighting::scene::procedural::Embedded;
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
    let image = image(&Cpu::new(), inputs, entry, quality).unwrap().unwrap();
    let error = image_error(&image, truth);
    println!("{method} {quality}: {:.5} {:.4}", error.rmse, error.max);
    error
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

//! A probe of a few pixels tells what the whole picture would.

use std::cell::Cell;
use std::convert::Infallible;

use crepuscular_tests::frames::inputs;
use gpu_backend::{Backend, Cpu, Download};
use lighting::methods::{Entry, Frame, Registry, RunOn, Store};
use lighting::prediction::{Forecast, Judged, Known, Probe, Profile, Sample, Setting};
use lighting::scene::procedural::Embedded;
use reference::metrics::{Reference, image_error};
use reference::scenes::TestScene;

/// Texels per side of shadow maps.
const MAP: u32 = 256;

const METHODS: [&str; 5] = [
    "none x gauss",
    "march x midpoint",
    "march quarter",
    "hybrid x gauss-8",
    "epipolar-sampling",
];

fn settings(methods: &Registry) -> Vec<Setting> {
    let setting = |entry: &Entry, quality: &u32| Setting {
        entry: entry.clone(),
        quality: *quality,
        map: MAP,
    };
    let entries = METHODS.map(|name| methods.find(name).unwrap());
    let all = entries.iter().flat_map(|entry| {
        let qualities = entry.about().quick;
        qualities.iter().map(|quality| setting(entry, quality))
    });
    all.collect()
}

fn judged(sample: &Sample, truth: &Reference, most: usize) -> Judged {
    let known = |pixels: &[u32]| {
        let light = pixels.iter().map(|pixel| truth.radiance[*pixel as usize]);
        Ok::<_, Infallible>(light.collect())
    };
    Judged::new(sample, most, known).unwrap()
}

/// A forecast by a clock that goes on a millisecond whenever it is looked at.
fn forecast(scene: &TestScene, truth: &Reference, pixels: usize, seconds: f64) -> Forecast {
    let host = Store::new();
    let sample = Sample::new(scene.size, pixels);
    let sample = sample.with_nearest(&scene.rays, &scene.emitters, pixels / 16);
    let now = Cell::new(0.0);
    let probe = Probe {
        inputs: inputs(scene, MAP, &host),
        sample: &sample,
        judged: &judged(&sample, truth, pixels / 2),
        profile: &Profile::new(),
        seconds,
        start: None,
        clock: &|| {
            now.set(now.get() + 1e-3);
            now.get()
        },
    };
    let settings = settings(&Registry::standard());
    probe.run(&Cpu::new(), "cpu", &host, &settings).unwrap()
}

#[test]
fn errors_of_a_sample_are_those_of_the_picture() {
    let scene = TestScene::new(Embedded::Fence, 160, 90);
    let truth = scene.truth();
    let forecast = forecast(&scene, &truth, 2048, f64::INFINITY);
    let settings = settings(&Registry::standard());
    assert_eq!(forecast.rows.len(), settings.len(), "{forecast}");
    let (cpu, store) = (Cpu::new(), Store::new());
    let frame = Frame::new(&cpu, inputs(&scene, MAP, &store), &store).unwrap();
    for row in &forecast.rows {
        assert_ne!(row.known, Known::Interpolated);
        let Setting { entry, quality, .. } = &settings[row.setting];
        let mut radiance = cpu.zeros::<[f32; 4]>(scene.rays.len()).unwrap();
        entry.add_radiance(&frame, *quality, &mut radiance).unwrap();
        let actual = image_error(&cpu.download(&radiance).unwrap(), &truth).rmse;
        let off = (row.rmse / actual).max(actual / row.rmse);
        assert!(off < 1.5, "{row}: {actual}");
        assert!(row.rmse_spread < row.rmse, "{row}: {}", row.rmse_spread);
    }
}

#[test]
fn a_forecast_is_the_same_whenever_the_clock_is() {
    let scene = TestScene::new(Embedded::Coil, 96, 64);
    let truth = scene.truth();
    let known = |forecast: &Forecast| {
        let rows = forecast.rows.iter();
        let rows = rows.map(|row| (row.method.clone(), row.quality, row.frame, row.rmse));
        rows.collect::<Vec<_>>()
    };
    let first = forecast(&scene, &truth, 1024, f64::INFINITY);
    assert_eq!(
        known(&first),
        known(&forecast(&scene, &truth, 1024, f64::INFINITY))
    );
    // One look before and one behind each frame: no time depends on the rays.
    assert!(
        first.rows.iter().all(|row| (row.frame - 1e-3).abs() < 1e-9),
        "{first}"
    );
}

#[test]
fn what_is_too_expensive_for_a_probe_is_named() {
    let scene = TestScene::new(Embedded::Fence, 32, 18);
    let truth = scene.truth();
    let nothing = forecast(&scene, &truth, 1024, 0.0);
    assert!(nothing.rows.is_empty());
    assert_eq!(nothing.skipped.len(), settings(&Registry::standard()).len());
    let text = nothing.to_string();
    assert!(
        text.contains("not foreseen: march x midpoint with 8 steps"),
        "{text}"
    );
    // What is run does not depend on the clock, and what is not is between what is.
    let some = forecast(&scene, &truth, 1024, 0.5);
    assert!(some.rows.iter().any(|row| row.known == Known::Probed));
}

#[test]
fn a_sample_of_all_pixels_leaves_nothing_to_chance() {
    let scene = TestScene::new(Embedded::Fence, 32, 18);
    let truth = scene.truth();
    let sample = Sample::new(scene.size, 1 << 20);
    assert!(sample.is_whole());
    assert_eq!(judged(&sample, &truth, usize::MAX).number(), 32 * 18);
    let forecast = forecast(&scene, &truth, 1 << 20, f64::INFINITY);
    assert!(forecast.rows.iter().all(|row| row.rmse_spread == 0.0));
}

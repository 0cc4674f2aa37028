//! Gathers through smoke, with their maps ready: time for a picture, beside the double march
//! with as many steps along the eye ray and, from each of these, towards the light.

use std::hint::black_box;
use std::time::Duration;

use crepuscular_tests::frames::inputs;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use gpu_backend::Cpu;
use lighting::methods::{Frame, Registry, Store};
use lighting::scene::procedural::Embedded;
use reference::scenes::TestScene;

const SIZE: [u32; 2] = [80, 45];

/// Steps for each ray.
const STEPS: u32 = 16;

/// Texels of the maps.
const MAP: u32 = 256;

const METHODS: [&str; 5] = [
    "media-exact-area-8",
    "media-exact-area-16",
    "media-area-8",
    "media-avsm-8",
    "media-double-march",
];

fn gathers(criterion: &mut Criterion) {
    let registry = Registry::standard();
    for embedded in [
        Embedded::SmokeRoom,
        Embedded::SmokeColumns,
        Embedded::Translucent,
    ] {
        let scene = TestScene::new(embedded, SIZE[0], SIZE[1]);
        let mut group = criterion.benchmark_group(format!("media/{}", scene.name));
        group.throughput(Throughput::Elements(scene.rays.len() as u64));
        let host = Store::new();
        let (cpu, store) = (Cpu::new(), Store::new());
        let frame = Frame::new(&cpu, inputs(&scene, MAP, &host), &store).expect("a frame");
        for name in METHODS {
            let entry = registry.find(name).expect("a method");
            let method = entry.on::<Cpu>().expect("a method for the CPU");
            method.prepare(&frame, STEPS).expect("maps");
            group.bench_function(name, |b| {
                b.iter(|| {
                    let mut radiance = vec![[0.0; 4]; scene.rays.len()];
                    method
                        .add_radiance(&frame, STEPS, &mut radiance)
                        .expect("a picture");
                    radiance
                });
            });
        }
        let mut target = scene.rays.clone();
        group.bench_function("copy", |b| {
            b.iter(|| black_box(&mut target[..]).copy_from_slice(black_box(&scene.rays)));
        });
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = gathers
}
criterion_main!(benches);

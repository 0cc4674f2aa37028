//! A frame by every method of the registry, on every backend: what `compare`
//! measures, with criterion's statistics.

use std::time::Duration;

use crepuscular_tests::frames::inputs;
use crepuscular_tests::suite::{self, Subject};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use gpu_backend::Cpu;
use lighting::methods::{Frame, Registry, Store, Verdict};
use lighting::scene::procedural::Embedded;
use reference::scenes::TestScene;

/// A sun, a spotlight and a point light.
const SCENES: [Embedded; 3] = [Embedded::City, Embedded::Smoke, Embedded::Coil];
const SIZE: (u32, u32) = (160, 90);
const MAP: u32 = 1024;

fn bench<B: Subject>(criterion: &mut Criterion, backend: &B) {
    let registry = Registry::standard();
    for embedded in SCENES {
        let scene = TestScene::new(embedded, SIZE.0, SIZE.1);
        let host = Store::new();
        let inputs = inputs(&scene, MAP, &host);
        for entry in registry.compared() {
            let Some(method) = entry.on::<B>() else {
                continue;
            };
            if entry.method().applies(&inputs) != Verdict::Applies {
                continue;
            }
            let about = entry.about();
            let mut group = criterion.benchmark_group(about.name.as_ref());
            group.throughput(Throughput::Elements(scene.rays.len() as u64));
            let (qualities, _) = entry.method().distinct(&inputs, about.quick);
            for &quality in qualities {
                let store = Store::new();
                let frame = Frame::new(backend, inputs, &store).expect("memory");
                method.prepare(&frame, quality).expect("a legal quality");
                let name = format!("{}/{}", backend.name(), scene.name);
                group.bench_function(BenchmarkId::new(name, quality), |b| {
                    b.iter(|| {
                        let mut radiance = backend.zeros(scene.rays.len()).expect("memory");
                        method
                            .add_radiance(&frame, quality, &mut radiance)
                            .expect("a frame as before");
                        backend.wait().expect("a backend that works");
                    });
                });
            }
            group.finish();
        }
    }
}

fn on_every_backend(criterion: &mut Criterion) {
    bench(criterion, &Cpu::new());
    if let Some(gpu) = suite::gpu() {
        bench(criterion, &gpu);
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = on_every_backend
}
criterion_main!(benches);

//! What is built once per scene or light: hierarchies and shadow maps.

use std::time::Duration;

use crepuscular_tests::suite::{self, Subject};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use gpu_backend::Cpu;
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::shadow_map::Casters;
use reference::oracle::visibility::Blockers;
use reference::scenes::TestScene;

/// A sun, a spotlight and a point light.
const SCENES: [Embedded; 3] = [Embedded::City, Embedded::Smoke, Embedded::Coil];

fn shadow_maps<B: Subject>(criterion: &mut Criterion, backend: &B) {
    let mut group = criterion.benchmark_group("shadow map");
    for embedded in SCENES {
        let test_scene = TestScene::new(embedded, 1, 1);
        let casters = Casters::upload(backend, &test_scene.geometry).expect("memory");
        let emitter = &test_scene.emitters[0];
        for resolution in [256, 1024, 2048] {
            let render = || {
                let map = backend
                    .shadow_map(&casters, emitter, resolution)
                    .expect("memory");
                backend.wait().expect("a backend that works");
                map
            };
            group.throughput(Throughput::Elements(render().bytes() / 4));
            let id = BenchmarkId::new(
                format!("{}/{}", backend.name(), test_scene.name),
                resolution,
            );
            group.bench_function(id, |b| b.iter(render));
        }
    }
    group.finish();
}

fn hierarchies(criterion: &mut Criterion) {
    for embedded in SCENES {
        let geometry = TestScene::new(embedded, 1, 1).geometry;
        let triangles = geometry.triangles().len();
        let mut group = criterion.benchmark_group("hierarchy");
        group.throughput(Throughput::Elements(triangles as u64));
        let id = |of: &str| BenchmarkId::new(format!("cpu/{of}/{}", embedded.name()), triangles);
        group.bench_function(id("tracer"), |b| b.iter(|| Tracer::new(&geometry)));
        group.bench_function(id("oracle"), |b| b.iter(|| Blockers::new(&geometry)));
        group.finish();
    }
}

fn on_every_backend(criterion: &mut Criterion) {
    shadow_maps(criterion, &Cpu::new());
    if let Some(gpu) = suite::gpu() {
        shadow_maps(criterion, &gpu);
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = on_every_backend, hierarchies
}
criterion_main!(benches);

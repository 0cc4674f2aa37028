//! The reference image on every embedded scene, with the tolerance swept.

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use lighting::scene::procedural::Embedded;
use reference::oracle::image::{Options, reference};
use reference::scenes::TestScene;

fn images(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("reference");
    for embedded in Embedded::ALL {
        let test_scene = TestScene::new(embedded, 64, 36);
        group.throughput(Throughput::Elements(test_scene.rays.len() as u64));
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let options = Options {
                tolerance,
                ..Options::default()
            };
            let id = BenchmarkId::new(format!("cpu/{}", test_scene.name), tolerance);
            group.bench_function(id, |b| {
                b.iter(|| {
                    reference(
                        &test_scene.rays,
                        &test_scene.emitters,
                        &test_scene.medium,
                        &test_scene.geometry,
                        options,
                    )
                });
            });
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = images
}
criterion_main!(benches);

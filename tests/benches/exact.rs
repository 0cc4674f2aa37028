//! Exact visibility of the rays of a picture: asked about together with their neighbours, and
//! one by one, which is what it is compared with.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use gpu_backend::Cpu;
use lighting::airlight::Midpoint;
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::visibility::{Exact, VisibilitySource};
use lighting::{Gather, LightPath, LitInterval, LitRays};
use reference::scenes::TestScene;

const SIZE: [u32; 2] = [240, 135];

/// Rays that do not know their neighbours.
#[derive(Debug)]
struct RayByRay<'a>(&'a Exact<&'a Tracer>);

impl VisibilitySource for RayByRay<'_> {
    type Share = Vec3;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<Vec3>>) {
        self.0.lit_intervals(path, lit);
    }
}

fn rays(criterion: &mut Criterion) {
    for embedded in [Embedded::City, Embedded::Hairball] {
        let scene = TestScene::new(embedded, SIZE[0], SIZE[1]);
        let mut group = criterion.benchmark_group(format!("exact/{}", scene.name));
        group.throughput(Throughput::Elements(scene.rays.len() as u64));
        let exact = Exact::new(&scene.tracer);
        let lit = LitRays::new(&scene.rays, &scene.emitters[0], &scene.medium);
        let cpu = Cpu::new();
        group.bench_function("together", |b| {
            b.iter(|| {
                let mut radiance = vec![[0.0; 4]; scene.rays.len()];
                cpu.gather(&lit, &exact, &Midpoint, &mut radiance)
            });
        });
        group.bench_function("ray by ray", |b| {
            b.iter(|| {
                let mut radiance = vec![[0.0; 4]; scene.rays.len()];
                cpu.gather(&lit, &RayByRay(&exact), &Midpoint, &mut radiance)
            });
        });
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
    targets = rays
}
criterion_main!(benches);

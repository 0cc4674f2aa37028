//! Airlight of a picture by every pair of visibility and airlight, with the
//! quality swept.

use std::time::Duration;

use crepuscular_tests::scenes::eye;
use crepuscular_tests::suite::{self, Subject};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use gpu_backend::{Backend, Cpu, Download};
use lighting::Gather;
use lighting::airlight::{EquiAngular, Midpoint};
use lighting::scene::procedural::Embedded;
use lighting::shadow_map::{Casters, ShadowMap};
use lighting::visibility::{Exact, March, Spacing};
use lighting::voxelized::{Detail, Resolution, VoxelVolume};
use reference::scenes::TestScene;

/// A sun, a spotlight and a point light.
const SCENES: [Embedded; 3] = [Embedded::City, Embedded::Smoke, Embedded::Coil];
const SIZE: (u32, u32) = (160, 90);
const MAP: u32 = 1024;

/// One gather of `visibility` × `airlight` over all emitters of the stage.
fn gather<B, V, A>(
    backend: &B,
    stage: &TestScene,
    touching: Touching,
    (sources, airlight): (&[V], &A),
) where
    B: Download + Gather<V, A>,
{
    let rays = backend.upload(&stage.rays).expect("memory");
    let mut radiance = backend.zeros(stage.rays.len()).expect("memory");
    for (emitter, source) in stage.emitters.iter().zip(sources) {
        backend
            .gather(
                &LitRays {
                    touching,
                    ..LitRays::new(&rays, emitter, &stage.medium)
                },
                source,
                airlight,
                &mut radiance,
            )
            .expect("buffers of one length");
    }
    backend.wait().expect("a backend that works");
}

/// Exact visibility, which is traced on the CPU.
fn traced(criterion: &mut Criterion, backend: &Cpu) {
    for embedded in SCENES {
        let stage = TestScene::new(embedded, SIZE.0, SIZE.1);
        let rays = Throughput::Elements(stage.rays.len() as u64);
        let id =
            |quality: u32| BenchmarkId::new(format!("{}/{}", backend.name(), stage.name), quality);
        let mut group = criterion.benchmark_group("exact x quadrature");
        group.throughput(rays);
        for nodes in [2, 8] {
            let quadrature = EquiAngular::new(nodes).expect("a legal number");
            let exact = vec![Exact::new(&stage.tracer); stage.emitters.len()];
            group.bench_function(id(nodes), |b| {
                b.iter(|| gather(backend, &stage, Touching::Apart, (&exact, &quadrature)));
            });
        }
        group.finish();
    }
}

fn bench<B: Subject>(criterion: &mut Criterion, backend: &B) {
    for embedded in SCENES {
        let stage = TestScene::new(embedded, SIZE.0, SIZE.1);
        let casters = Casters::upload(backend, &stage.geometry).expect("memory");
        let maps: Vec<ShadowMap<B::Memory>> = stage
            .emitters
            .iter()
            .map(|emitter| backend.shadow_map(&casters, emitter, MAP).expect("memory"))
            .collect();
        let rays = Throughput::Elements(stage.rays.len() as u64);
        let id =
            |quality: u32| BenchmarkId::new(format!("{}/{}", backend.name(), stage.name), quality);

        let march = |samples, spacing| -> Vec<_> {
            let new = |map| March::new(map, samples, spacing);
            maps.iter().map(new).collect()
        };
        let one = EquiAngular::new(1).expect("a legal number");
        let eight = EquiAngular::new(8).expect("a legal number");
        for samples in [16, 64, 256] {
            let mut group = criterion.benchmark_group("march x midpoint");
            group.throughput(rays.clone());
            let steps = march(samples, Spacing::Distance);
            group.bench_function(id(samples), |b| {
                b.iter(|| gather(backend, &stage, Touching::Apart, (&steps, &Midpoint)));
            });
            group.finish();

            let mut group = criterion.benchmark_group("merged march x quadrature 8");
            group.throughput(rays.clone());
            let runs = march(samples, Spacing::Distance);
            group.bench_function(id(samples), |b| {
                b.iter(|| gather(backend, &stage, Touching::Joined, (&runs, &eight)));
            });
            group.finish();

            let mut group = criterion.benchmark_group("equi-angular march x quadrature 1");
            group.throughput(rays.clone());
            let steps = march(samples, Spacing::EquiAngular);
            group.bench_function(id(samples), |b| {
                b.iter(|| gather(backend, &stage, Touching::Apart, (&steps, &one)));
            });
            group.finish();
        }

        // A frame: voxels are made anew for each light, and read.
        for side in [128, 512] {
            let resolution = Resolution::new(side, side, side).expect("a resolution");
            let mut volume = VoxelVolume::new(backend, resolution).expect("memory");
            let upload = backend.upload(&stage.rays).expect("memory");
            for (name, detail) in [
                ("voxel average x quadrature 8", Detail::Average),
                ("voxel runs x quadrature 8", Detail::Runs),
            ] {
                let mut group = criterion.benchmark_group(name);
                group.throughput(rays.clone());
                group.bench_function(id(side), |b| {
                    b.iter(|| {
                        let mut radiance = backend.zeros(stage.rays.len()).expect("memory");
                        for (emitter, map) in stage.emitters.iter().zip(&maps) {
                            volume
                                .update(backend, emitter, &eye(&stage), map)
                                .expect("voxels");
                            backend
                                .gather(
                                    &LitRays::new(&upload, emitter, &stage.medium),
                                    &volume.source(detail),
                                    &eight,
                                    &mut radiance,
                                )
                                .expect("buffers of one length");
                        }
                        backend.wait().expect("a backend that works");
                    });
                });
                group.finish();
            }
        }
    }
}

fn on_every_backend(criterion: &mut Criterion) {
    traced(criterion, &Cpu::new());
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

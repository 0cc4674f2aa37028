//! What frames of many lights pay before any light is gathered, and what a frame pays for
//! casters that move beside shadows that are baked.

use std::f32::consts::PI;
use std::time::Duration;

use crepuscular_tests::frames::inputs;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use gpu_backend::{Backend, Cpu};
use lighting::Emitter;
use lighting::culling::{Clusters, RayTiles, TileLights};
use lighting::methods::{Frame, Registry, Store, forget_dynamic, share_tracer};
use lighting::scene::Emission;
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use reference::random::Random;
use reference::scenes::TestScene;

/// Lamps before the surfaces of a view, so large that eight of them reach a pixel, about.
fn lamps(scene: &TestScene, count: u32) -> Vec<Emitter> {
    let mut random = Random::new(19);
    let rays: Vec<_> = scene
        .rays
        .iter()
        .filter(|ray| ray.length().is_finite())
        .collect();
    // As if the view were a radian wide.
    let radius = (8.0 / (PI * count as f32)).sqrt();
    let lamps = (0..count).map(|_| {
        let ray = rays[random.below(rays.len() as u32) as usize];
        let distance = ray.length() * (0.2 + 0.8 * random.unit());
        let range = radius * distance;
        Emitter::point(ray.at(distance), Vec3::ONE, range, Emission::Isotropic)
    });
    lamps.collect::<Result<_, _>>().expect("sound lamps")
}

/// The lists of lights of tiles and of clusters, beside a copy of the rays.
fn culling(criterion: &mut Criterion) {
    let cpu = Cpu::new();
    for (width, height) in [(480, 270), (1920, 1080)] {
        let scene = TestScene::new(Embedded::City, width, height);
        let mut group = criterion.benchmark_group(format!("culling/{width}x{height}"));
        group.throughput(Throughput::Elements(scene.rays.len() as u64));
        group.bench_function("copy of rays", |b| b.iter(|| scene.rays.clone()));
        let tiled = || RayTiles::new(&cpu, &scene.rays, width, None).expect("rays of one eye");
        group.bench_function("rays in tiles", |b| b.iter(tiled));
        let tiles = tiled();
        for count in [165, 1000, 10_000] {
            let lamps = lamps(&scene, count);
            let lists = || TileLights::new(&cpu, &tiles, &lamps).expect("short lists");
            group.bench_function(BenchmarkId::new("lists", count), |b| b.iter(lists));
            let lists = lists();
            group.bench_function(BenchmarkId::new("clusters", count), |b| {
                b.iter(|| Clusters::new(&cpu, lists.clone()).expect("short lists"));
            });
        }
        group.finish();
    }
}

/// Frames in which nothing has moved since the last one, and frames in which what may move
/// has.
fn dynamic_casters(criterion: &mut Criterion) {
    let methods = Registry::standard();
    let Some(entry) = methods.find("precomputed x gauss") else {
        return;
    };
    let cpu = Cpu::new();
    let method = entry.on::<Cpu>().expect("every method runs on the CPU");
    let quality = entry.about().usual;
    let scene = TestScene::new(Embedded::Traffic, 160, 90);
    let host = Store::new();
    share_tracer(&host, &Tracer::new(&scene.geometry).into());
    let store = Store::new();
    let frame = Frame::new(&cpu, inputs(&scene, 1024, &host), &store).expect("memory");
    method.prepare(&frame, quality).expect("a legal quality");
    let picture = || {
        let mut radiance = cpu.zeros(scene.rays.len()).expect("memory");
        let added = method.add_radiance(&frame, quality, &mut radiance);
        added.expect("a frame as before");
    };
    let mut group = criterion.benchmark_group("dynamic casters");
    group.throughput(Throughput::Elements(scene.rays.len() as u64));
    group.bench_function("at rest", |b| b.iter(picture));
    group.bench_function("moved", |b| {
        b.iter(|| {
            forget_dynamic(&host);
            forget_dynamic(&store);
            method.prepare(&frame, quality).expect("as before");
            picture();
        });
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1));
    targets = culling, dynamic_casters
}
criterion_main!(benches);

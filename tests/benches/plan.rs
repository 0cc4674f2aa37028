//! What a plan saves, and what it costs to make: `forced` beside `planned` in each group.

use std::time::Duration;

use crepuscular_tests::frames::{image, inputs};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use gpu_backend::Cpu;
use gpu_backend::gpu::{Context, Gpu};
use lighting::Emitter;
use lighting::methods::{Registry, Store, share_tracer};
use lighting::plan::Plan;
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::{AreaEmitters, AreaLight, AreaShape, Emission, Pattern};
use reference::scenes::TestScene;

const SIZE: [u32; 2] = [480, 270];

/// A lamp in the air before the eye, so near that nothing is in its light.
fn lamp(scene: &TestScene) -> Emitter {
    let way = scene.camera.direction(0.5, 0.3, 1, 1);
    let position = scene.camera.eye() + 3.0 * way;
    let light = Emitter::point(position, Vec3::splat(5.0), 1.5, Emission::Isotropic);
    light.expect("a sound lamp")
}

/// Shadows of a lamp with nothing in its way: with maps and a march, and in closed form.
fn shadows(criterion: &mut Criterion) {
    let methods = Registry::standard();
    let mut group = criterion.benchmark_group("plan/shadows of a lamp that casts none");
    let mut scene = TestScene::new(Embedded::City, SIZE[0], SIZE[1]);
    let host = Store::new();
    share_tracer(&host, &Tracer::new(&scene.geometry).into());
    scene.emitters = vec![lamp(&scene)];
    let frame = inputs(&scene, 1024, &host);
    for name in [
        "march x midpoint",
        "exact x quadrature",
        "voxelized x gauss",
    ] {
        let Some(entry) = methods.find(name) else {
            continue;
        };
        let quality = entry.about().usual;
        let cpu = Cpu::new();
        group.throughput(Throughput::Elements(scene.rays.len() as u64));
        group.bench_function(BenchmarkId::new("forced", name), |b| {
            b.iter(|| image(&cpu, frame, &entry, quality));
        });
        group.bench_function(BenchmarkId::new("planned", name), |b| {
            b.iter(|| {
                let plan = Plan::of_frame(&frame).expect("a plan");
                assert_eq!(plan.unshadowed(), [0]);
                let closed = methods.unshadowed(&entry, quality);
                let (closed, quality) = closed.expect("a method");
                image(&cpu, frame, &closed, quality)
            });
        });
    }
    group.finish();
}

/// The same of a small glowing disk, by the points that represent it.
fn shadows_of_areas(criterion: &mut Criterion) {
    let methods = Registry::standard();
    let mut group = criterion.benchmark_group("plan/shadows of an area light that casts none");
    let mut scene = TestScene::new(Embedded::City, SIZE[0] / 2, SIZE[1] / 2);
    let way = scene.camera.direction(0.5, 0.3, 1, 1);
    let light = AreaLight {
        shape: AreaShape::Disk,
        corner: scene.camera.eye() + 3.0 * way,
        // It shines towards the eye.
        edges: [0.2 * way.cross(Vec3::X), 0.2 * Vec3::X],
        radiance: Vec3::ONE,
        ..AreaLight::default()
    };
    scene.emitters = light.virtual_lights(Pattern::Lattice, 16).expect("a light");
    let emitters = 0..scene.emitters.len();
    scene.areas = vec![AreaEmitters { light, emitters }];
    let host = Store::new();
    share_tracer(&host, &Tracer::new(&scene.geometry).into());
    let frame = inputs(&scene, 512, &host);
    let cpu = Cpu::new();
    for name in ["march x midpoint", "exact x quadrature"] {
        let entry = methods.find(name).expect("a method of the list");
        let quality = entry.about().usual;
        group.bench_function(BenchmarkId::new("forced", name), |b| {
            b.iter(|| image(&cpu, frame, &entry, quality));
        });
        group.bench_function(BenchmarkId::new("planned", name), |b| {
            b.iter(|| {
                let plan = Plan::of_frame(&frame).expect("a plan");
                assert_eq!(plan.unshadowed().len(), scene.emitters.len());
                let closed = methods.unshadowed(&entry, quality);
                let (closed, quality) = closed.expect("a method");
                image(&cpu, frame, &closed, quality)
            });
        });
    }
    group.finish();
}

/// Lights that do not reach the view.
fn lights(criterion: &mut Criterion) {
    let methods = Registry::standard();
    let mut group = criterion.benchmark_group("plan/lights behind the eye");
    let mut scene = TestScene::new(Embedded::Coil, SIZE[0], SIZE[1]);
    let behind = scene.camera.eye() - 3.0 * scene.camera.direction(0.5, 0.5, 1, 1);
    let unseen = Emitter::point(behind, Vec3::ONE, 2.0, Emission::Isotropic);
    (scene.emitters).push(unseen.expect("a sound lamp"));
    let entry = methods.find("march x midpoint").expect("the baseline");
    let quality = entry.about().usual;
    let (cpu, host) = (Cpu::new(), Store::new());
    group.bench_function("forced", |b| {
        b.iter(|| image(&cpu, inputs(&scene, 1024, &host), &entry, quality));
    });
    group.bench_function("planned", |b| {
        b.iter(|| {
            let plan = Plan::new(&scene.emitters, Some(&scene.medium), &scene.rays);
            let kept = plan.emitters().iter();
            let emitters: Vec<Emitter> = kept.map(|i| scene.emitters[*i].clone()).collect();
            let frame = lighting::methods::FrameInputs {
                emitters: &emitters,
                ..inputs(&scene, 1024, &host)
            };
            image(&cpu, frame, &entry, quality)
        });
    });
    group.finish();
}

/// The question whether lights are unshadowed, beside a frame that marches.
fn questions(criterion: &mut Criterion) {
    let methods = Registry::standard();
    let march = methods.find("march x midpoint").expect("the baseline");
    let mut group = criterion.benchmark_group("plan/question");
    for embedded in [Embedded::City, Embedded::Hairball, Embedded::Coil] {
        let scene = TestScene::new(embedded, SIZE[0], SIZE[1]);
        let mut unshadowed = TestScene::new(embedded, SIZE[0], SIZE[1]);
        unshadowed.emitters = vec![lamp(&scene)];
        let host = Store::new();
        share_tracer(&host, &Tracer::new(&scene.geometry).into());
        group.throughput(Throughput::Elements(scene.rays.len() as u64));
        for (what, scene) in [("own lights", &scene), ("lamp", &unshadowed)] {
            let frame = inputs(scene, 1024, &host);
            let id = |of: &str| BenchmarkId::new(format!("{of}/{what}"), scene.name);
            group.bench_function(id("plan"), |b| b.iter(|| Plan::of_frame(&frame)));
            group.bench_function(id("lights alone"), |b| {
                b.iter(|| Plan::new(frame.emitters, Some(frame.medium), frame.rays));
            });
            group.bench_function(id("march"), |b| {
                b.iter(|| image(&Cpu::new(), frame, &march, 64));
            });
        }
    }
    group.finish();
}

/// A picture on a GPU that has to be started for it, and on the CPU, which has not.
fn starts(criterion: &mut Criterion) {
    let methods = Registry::standard();
    let march = methods.find("march x midpoint").expect("the baseline");
    let mut group = criterion.benchmark_group("plan/start of a backend");
    if Context::request().is_err() {
        return;
    }
    let scene = TestScene::new(Embedded::Fence, 160, 90);
    let host = Store::new();
    share_tracer(&host, &Tracer::new(&scene.geometry).into());
    let frame = inputs(&scene, 256, &host);
    group.bench_function("forced", |b| {
        b.iter(|| {
            let context = Context::request().expect("it was there before");
            image(&Gpu::new(context), frame, &march, 64)
        });
    });
    group.bench_function("planned", |b| {
        b.iter(|| image(&Cpu::new(), frame, &march, 64));
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1));
    targets = shadows, shadows_of_areas, lights, questions, starts
}
criterion_main!(benches);

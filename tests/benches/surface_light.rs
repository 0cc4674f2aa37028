//! Light that surfaces receive by way of the fog, and from an environment: time per
//! surface, with the largest error against the oracle printed beside it.

use std::time::Duration;

use crepuscular_tests::suite;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Quat, Vec3};
use gpu_backend::{Cpu, Download};
use lighting::environment::{Environment, EnvironmentMap};
use lighting::indirect::LightSurfaces;
use lighting::scene::{Bounds, Cone, Emission, Medium, PhaseFunction};
use lighting::surface_scattering::{AddSurfaceScattering, ClosedForm, LitSurfaces, Quadrature};
use lighting::visibility::Unshadowed;
use lighting::{Emitter, SurfacePoint};
use reference::oracle::surface::scattered_irradiance;

/// Surfaces that are timed; the error is measured on every 64th of them.
const POINTS: usize = 1024;
const JUDGED: usize = 64;

/// A floor of ten metres a side, turned a little from point to point.
fn points() -> Vec<SurfacePoint> {
    (0..POINTS)
        .map(|i| {
            let (x, z) = ((i % 32) as f32 / 3.2 - 5.0, (i / 32) as f32 / 3.2 - 5.0);
            let normal = Vec3::new((7.0 * x).sin(), 1.5, (5.0 * z).cos());
            SurfacePoint::new(Vec3::new(x, 0.0, z), normal, Vec3::ONE).expect("a sound point")
        })
        .collect()
}

fn cases() -> Vec<(&'static str, Emitter, Medium)> {
    let fog = |phase| Medium::new(Vec3::new(0.1, 0.12, 0.15), Vec3::splat(0.01), phase);
    let even = fog(PhaseFunction::Isotropic).expect("sound numbers");
    let hazy = fog(PhaseFunction::HenyeyGreenstein { g: 0.6 }).expect("sound numbers");
    let corners = (Vec3::new(-6.0, -0.1, -6.0), Vec3::new(6.0, 4.0, 6.0));
    let room = Bounds::new(corners.0, corners.1).expect("a box");
    let lamp = |emission| {
        let position = Vec3::new(0.5, 3.0, 0.2);
        Emitter::point(position, Vec3::splat(10.0), f32::INFINITY, emission).expect("a lamp")
    };
    let cone = Cone {
        inner: 0.3,
        outer: 0.5,
    };
    let down = Quat::from_rotation_x(-1.4);
    let spot = Emission::spot(down, cone, None).expect("a cone");
    let sun = Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE).expect("a sun");
    vec![
        ("lamp in even fog", lamp(Emission::Isotropic), even),
        ("lamp in haze", lamp(Emission::Isotropic), hazy),
        ("spotlight in a room", lamp(spot), hazy.within(room)),
        ("sun in a room", sun, hazy.within(room)),
    ]
}

fn scattering<B, S>(
    criterion: &mut Criterion,
    backend: &B,
    (name, emitter, medium): &(&'static str, Emitter, Medium),
    (way, nodes, scattering): (&str, u32, &S),
    truth: &[DVec3],
) where
    B: Download + AddSurfaceScattering<S>,
{
    let points = backend.upload(&points()).expect("memory");
    let mut radiance = backend.zeros::<[f32; 4]>(POINTS).expect("memory");
    let lit = LitSurfaces {
        points: &points,
        emitter,
        medium,
    };
    backend
        .add_surface_scattering(&lit, scattering, &mut radiance)
        .expect("a light that is covered");
    let found = backend.download(&radiance).expect("memory");
    let scale = truth
        .iter()
        .fold(0.0, |most, light| light.max_element().max(most));
    let judged = found.iter().step_by(JUDGED).zip(truth);
    let error = judged.fold(0.0, |most: f64, (found, truth)| {
        let error = (Vec3::from_slice(found).as_dvec3() - truth).abs();
        most.max(error.max_element() / scale)
    });
    let id = format!("{}/{name}/{way}", backend.name());
    eprintln!("{id}/{nodes}: error {error:.1e} of the brightest");
    let mut group = criterion.benchmark_group("surface scattering");
    group.throughput(Throughput::Elements(POINTS as u64));
    group.bench_function(BenchmarkId::new(id, nodes), |bencher| {
        bencher.iter(|| {
            backend
                .add_surface_scattering(&lit, scattering, &mut radiance)
                .expect("a light that is covered");
            backend.wait().expect("a backend that works");
        });
    });
    group.finish();
}

fn bench<B: LightSurfaces>(criterion: &mut Criterion, backend: &B) {
    for case in &cases() {
        let (_, emitter, medium) = case;
        let truth: Vec<DVec3> = points()
            .iter()
            .step_by(JUDGED)
            .map(|p| scattered_irradiance(p.position(), p.normal(), emitter, medium, 1e-5))
            .collect();
        let closed_form = ClosedForm::new(medium);
        if closed_form.covers(emitter, medium).is_ok() {
            scattering(
                criterion,
                backend,
                case,
                ("closed form", 1, &closed_form),
                &truth,
            );
        }
        for nodes in [4, 8, 16] {
            let quadrature = Quadrature::new(Unshadowed, nodes).expect("a legal number");
            scattering(
                criterion,
                backend,
                case,
                ("quadrature", nodes, &quadrature),
                &truth,
            );
        }
    }
    let even = Environment::even([0.3, 0.4, 0.6]).expect("a radiance");
    let room = cases()[3].2;
    let map = EnvironmentMap::new(backend, &even, Some(&room)).expect("memory");
    let points = backend.upload(&points()).expect("memory");
    let mut radiance = backend.zeros::<[f32; 4]>(POINTS).expect("memory");
    let mut group = criterion.benchmark_group("environment light");
    group.throughput(Throughput::Elements(POINTS as u64));
    group.bench_function(BenchmarkId::new(backend.name(), "patches"), |bencher| {
        bencher.iter(|| {
            backend
                .add_environment_light(&points, &map, &mut radiance)
                .expect("buffers of one length");
            backend.wait().expect("a backend that works");
        });
    });
    group.finish();
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

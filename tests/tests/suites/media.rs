//! Gathers through smoke against the truth.

use std::sync::Arc;

use crepuscular_tests::frames::{image, inputs};
use glam::{Affine3A, Quat, Vec3};
use gpu_backend::Cpu;
use lighting::Ray;
use lighting::methods::heterogeneous::{AddEmission, EmittingRays};
use lighting::methods::{Method, Registry, Role, Store, share_transmittance_map};
use lighting::scene::procedural::Embedded;
use lighting::scene::{
    Bounds, DensityGrid, HeightFog, Interpolation, Media, Medium, PhaseFunction, Translucent,
};
use lighting::translucent::{Casters, TransmittanceMap};
use reference::metrics::image_error;
use reference::oracle::media::{Air, MediaWorld, reference as of_media};
use reference::oracle::quadrature::Tolerance;
use reference::random::Random;
use reference::scenes::TestScene;
use transmittance::Stream;

/// The embedded scene of smoke, without its hair, which gathers do not see.
fn smoke() -> TestScene {
    let mut scene = TestScene::new(Embedded::Translucent, 14, 8);
    let is_hair = |caster: &Translucent| matches!(caster, Translucent::Strands(_));
    scene.translucent.retain(|caster| !is_hair(caster));
    scene
}

#[test]
fn every_gather_through_smoke_comes_near_the_truth() {
    let scene = smoke();
    let air = Air {
        medium: Some(&scene.medium),
        height_fog: None,
        translucent: &scene.translucent,
    };
    let world = MediaWorld::new(air, &scene.emitters, &scene.geometry);
    let truth = of_media(&world, &scene.rays, 5e-3);
    let host = Store::new();
    let inputs = inputs(&scene, 1024, &host);
    let mut best = f64::INFINITY;
    for entry in Registry::standard().all() {
        let about = entry.about();
        if !entry.sees_heterogeneous_media() {
            continue;
        }
        let errors = [16, 128].map(|steps| {
            let image = image(&Cpu::new(), inputs, entry, steps).unwrap().unwrap();
            image_error(&image, &truth).rmse
        });
        let is_right = match about.role {
            // Shadows of smoke are worth something.
            Role::Unshadowed => errors[1] > 0.5,
            Role::Baseline => errors[1] < 0.3,
            _ => errors[1] < 0.15 && errors[1] < errors[0],
        };
        assert!(is_right, "{}: {errors:?}", about.name);
        best = best.min(errors[1]);
    }
    // The reference itself is known to half of that.
    assert!(best < 0.01, "{best}");
}

/// What is emitted along rays, on the CPU.
fn emitted(rays: &[Ray], media: &Media<'_>, mut radiance: Vec<[f32; 4]>) -> Vec<[f32; 4]> {
    let rays = &rays.to_vec();
    let panes = None;
    let seen = EmittingRays { rays, media, panes };
    Cpu::new().add_emission(&seen, &mut radiance).unwrap();
    radiance
}

/// Smoke that glows, of `scale`.
fn glowing(scale: f32, interpolation: Interpolation, turn: f32) -> DensityGrid {
    let bounds = Bounds::new(Vec3::new(-1.0, -0.8, -1.2), Vec3::new(1.0, 0.9, 0.7));
    let mut random = Random::new(u64::from(turn.to_bits()));
    let density = (0..60).map(|_| random.unit()).collect();
    let glow = (0..60).map(|_| 1.0 + Vec3::from(random.vector(1.0)));
    let turn = Quat::from_axis_angle(Vec3::new(0.6, 0.8, 0.0), turn);
    DensityGrid::new(bounds.unwrap(), [5, 4, 3], density, scale, interpolation)
        .and_then(|grid| grid.with_emission(glow.collect()))
        .and_then(|grid| grid.with_tint(Vec3::new(1.0, 0.6, 0.1)))
        .and_then(|grid| grid.with_transform(Affine3A::from_quat(turn)))
        .unwrap()
}

#[test]
fn what_smoke_emits_is_the_truth() {
    let even = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let isotropic = PhaseFunction::Isotropic;
    let mist = HeightFog::new(Vec3::splat(0.3), Vec3::ZERO, -0.2, 0.3, isotropic).unwrap();
    // Without lamps nothing casts a shadow.
    let geometry = smoke().geometry;
    let mut random = Random::new(8);
    let rays: Vec<Ray> = (0..40)
        .map(|i| {
            let distance = if i % 4 == 0 { 0.5 } else { 4.0 };
            let origin = distance * Vec3::from(random.vector(1.0));
            let target = 0.7 * Vec3::from(random.vector(1.0));
            Ray::new(origin, target - origin, 7.0).unwrap()
        })
        .collect();
    for interpolation in [Interpolation::Constant, Interpolation::Linear] {
        for scale in [0.0, 0.5, 20.0, 1e4] {
            let casters: [Translucent; 2] = [
                glowing(scale, interpolation, 0.4).into(),
                glowing(0.3, interpolation, 1.3).into(),
            ];
            for (medium, height_fog) in [(None, None), (Some(&even), Some(&mist))] {
                let air = Air {
                    medium,
                    height_fog,
                    translucent: &casters,
                };
                let world = MediaWorld::new(air, &[], &geometry);
                let media = Media::new(medium, height_fog, &casters);
                let found = emitted(&rays, &media, vec![[0.0; 4]; rays.len()]);
                for (ray, found) in rays.iter().zip(found) {
                    let truth = world.radiance(ray, Tolerance::relative(1e-7));
                    for (found, truth_of) in found.iter().zip(truth.value.to_array()) {
                        let error = (f64::from(*found) - truth_of).abs();
                        assert!(
                            error <= 2e-6 * truth_of + truth.bound + 1e-28,
                            "{interpolation:?} {scale}: {found} for {truth_of}, {ray:?}"
                        );
                    }
                }
            }
        }
    }
}

/// A lamp's light and the smoke's own together.
#[test]
fn pictures_of_smoke_that_glows_come_near_the_truth() {
    let mut scene = smoke();
    for caster in &mut scene.translucent {
        if let Translucent::Grid(grid) = caster {
            let glow = grid.density().iter();
            let glow = glow.map(|density| *density * Vec3::new(0.5, 0.2, 0.05));
            *grid = grid.clone().with_emission(glow.collect()).unwrap();
        }
    }
    let air = Air {
        medium: Some(&scene.medium),
        height_fog: None,
        translucent: &scene.translucent,
    };
    let world = MediaWorld::new(air, &scene.emitters, &scene.geometry);
    let truth = of_media(&world, &scene.rays, 5e-3);
    let host = Store::new();
    let inputs = inputs(&scene, 1024, &host);
    let entry = Registry::standard().find("media-area-16").unwrap();
    let lit = image(&Cpu::new(), inputs, &entry, 128).unwrap().unwrap();
    let dark = image_error(&lit, &truth).rmse;
    let error = image_error(&emitted(&scene.rays, &inputs.media(), lit), &truth).rmse;
    assert!(error < 0.02 && dark > 10.0 * error, "{error} {dark}");
}

#[test]
fn a_gather_uses_the_maps_that_surfaces_have() {
    let cpu = Cpu::new();
    let entry = Registry::standard().find("media-area-8").unwrap();
    for embedded in [Embedded::SmokeRoom, Embedded::SmokeColumns] {
        let scene = TestScene::new(embedded, 24, 14);
        let own = Store::new();
        let own = inputs(&scene, 128, &own);
        let expected = image(&cpu, own, &entry, 8).unwrap();
        let casters = Casters::new(&scene.translucent, None);
        let host = Store::new();
        for (light, emitter) in scene.emitters.iter().enumerate() {
            let side = casters.resolution(128, &scene.emitters, emitter);
            let clear = Stream::<8>::new();
            let map = TransmittanceMap::build(&cpu, &casters, emitter, side, &clear).unwrap();
            share_transmittance_map(&host, light, &Arc::new(map));
        }
        let shared = inputs(&scene, 128, &host);
        assert!(image(&cpu, shared, &entry, 8).unwrap() == expected);
        let maps = host
            .used()
            .into_iter()
            .filter(|used| used.what.contains("transmittance"));
        assert!(maps.map(|used| used.seconds).all(|seconds| seconds == 0.0));
    }
}

/// Beams through a window are sampled by the steps of other gathers, and cut out by this one.
#[test]
fn beams_in_smoke_have_exact_edges_with_few_steps() {
    let scene = TestScene::new(Embedded::SmokeRoom, 40, 22);
    let host = Store::new();
    let inputs = inputs(&scene, 512, &host);
    let registry = Registry::standard();
    let lit = |name: &str, steps| {
        let entry = registry.find(name).unwrap();
        image(&Cpu::new(), inputs, &entry, steps).unwrap().unwrap()
    };
    let truth = scene.truth_in_media();
    let error = |name: &str, steps| image_error(&lit(name, steps), &truth).rmse;
    let (exact, sampled) = (error("media-exact-area-8", 16), error("media-area-8", 16));
    assert!(exact < 0.05 && sampled > 4.0 * exact, "{exact} {sampled}");
    // What is left with many steps is the error of the curves.
    let curves = [("media-exact-area-8", 64), ("media-exact-area-16", 64)];
    let [eight, sixteen] = curves.map(|(name, steps)| error(name, steps));
    assert!(sixteen < 0.01 && sixteen < 0.6 * eight, "{sixteen} {eight}");
    // The two agree in the limit.
    let limit = error("media-area-8", 1024);
    assert!(limit < 0.05, "{limit}");
}

//! Both marches converge, at the order that theory gives them.

use crepuscular_tests::scenes::{least_order, maps};
use crepuscular_tests::suite::{Subject, cpu_alone, cpu_with_threads};
use glam::Vec3;
use gpu_backend::Cpu;
use lighting::airlight::{EquiAngular, Midpoint};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::{Camera, Emission, Medium, PhaseFunction};
use lighting::shadow_map::ShadowMap;
use lighting::visibility::{March, Spacing};
use lighting::{Emitter, LitRays, Ray};
use reference::metrics::{image_error, order};
use reference::oracle::image::Reference;
use reference::scenes::TestScene;
use reference::shapes;
use reference::tolerances::Allowed;

crepuscular_tests::on_every_backend!(
    without_shadows_marches_converge_at_second_order,
    without_shadows_16_equi_angular_steps_beat_64_of_equal_length,
);
crepuscular_tests::on_every_backend!(heavy:
    marches_converge_to_the_limit_of_their_map_at_first_order_on_every_scene,
    with_the_map_refined_along_marches_converge_to_the_reference,
);

/// The image of a test scene by marching `maps` in `samples` steps.
fn march<B: Subject>(
    backend: &B,
    test_scene: &TestScene,
    maps: &[ShadowMap<B::Memory>],
    samples: u32,
    spacing: Spacing,
) -> Vec<[f32; 4]> {
    let rays = backend.upload(&test_scene.rays).unwrap();
    let mut radiance = backend.zeros::<[f32; 4]>(test_scene.rays.len()).unwrap();
    let one = EquiAngular::new(1).unwrap();
    for (emitter, map) in test_scene.emitters.iter().zip(maps) {
        let march = March::new(map, samples, spacing);
        let lit = LitRays::new(&rays, emitter, &test_scene.medium);
        match spacing {
            Spacing::Distance => backend.gather(&lit, &march, &Midpoint, &mut radiance),
            Spacing::EquiAngular | Spacing::Picture => {
                backend.gather(&lit, &march, &one, &mut radiance)
            }
        }
        .unwrap();
    }
    backend.download(&radiance).unwrap()
}

#[test]
fn threads_change_no_bit_of_a_map_or_a_march() {
    for embedded in [Embedded::City, Embedded::Smoke, Embedded::Coil] {
        let test_scene = TestScene::new(embedded, 32, 18);
        let images = |backend: &Cpu| {
            let maps = maps(backend, &test_scene, 256);
            let depths: Vec<Vec<f32>> = maps.iter().map(|map| map.depth().clone()).collect();
            let march = |spacing| march(backend, &test_scene, &maps, 32, spacing);
            (depths, SPACINGS.map(march))
        };
        assert!(
            cpu_alone().map(|cpu| images(&cpu)) == cpu_with_threads().map(|cpu| images(&cpu)),
            "{}",
            test_scene.name
        );
    }
}

/// An image as something to compare with.
fn limit(image: &[[f32; 4]]) -> Reference {
    Reference {
        radiance: image
            .iter()
            .map(|p| [p[0], p[1], p[2]].map(f64::from))
            .collect(),
        bound: vec![0.0; image.len()],
    }
}

/// Steps of the coarsest march.
const COARSEST: u32 = 64;

/// An embedded scene as far as steps and maps can resolve it.
fn resolvable(embedded: Embedded) -> TestScene {
    TestScene::resolvable(embedded, 32, 18, COARSEST)
}

const SPACINGS: [Spacing; 2] = [Spacing::Distance, Spacing::EquiAngular];

fn marches_converge_to_the_limit_of_their_map_at_first_order_on_every_scene<B: Subject>(
    backend: &B,
) {
    // Visibility is binary: a step that contains a shadow's edge is wrong by a
    // share of itself, which is first order. Smooth parts converge faster, and
    // where they dominate the order may be higher.
    for embedded in Embedded::ALL {
        let test_scene = resolvable(embedded);
        let maps = maps(backend, &test_scene, 512);
        for spacing in SPACINGS {
            // Not more: some software drivers end loops after 65,535 iterations.
            let limit = limit(&march(backend, &test_scene, &maps, 4096, spacing));
            let errors = [1, 2, 4, 8].map(|finer| {
                let samples = COARSEST * finer;
                let image = march(backend, &test_scene, &maps, samples, spacing);
                (samples, image_error(&image, &limit).rmse)
            });
            let measured = order(&errors);
            assert!(
                measured >= 1.0 - Allowed::Order.error(),
                "{}, {spacing:?}: order {measured:.2}, {errors:?}",
                test_scene.name
            );
        }
    }
}

fn with_the_map_refined_along_marches_converge_to_the_reference<B: Subject>(backend: &B) {
    for embedded in Embedded::ALL {
        let test_scene = resolvable(embedded);
        let truth = test_scene.truth();
        let mut errors = SPACINGS.map(|_| Vec::new());
        for finer in [1, 2, 4, 8] {
            let maps = maps(backend, &test_scene, 128 * finer);
            for (spacing, errors) in SPACINGS.into_iter().zip(&mut errors) {
                let samples = COARSEST * finer;
                let image = march(backend, &test_scene, &maps, samples, spacing);
                errors.push((samples, image_error(&image, &truth).rmse));
            }
        }
        for (spacing, errors) in SPACINGS.into_iter().zip(errors) {
            let measured = order(&errors);
            assert!(
                measured >= least_order(embedded),
                "{}, {spacing:?}: order {measured:.2}, {errors:?}",
                test_scene.name
            );
        }
    }
}

fn without_shadows_marches_converge_at_second_order<B: Subject>(backend: &B) {
    let test_scene = unshadowed_lamp_in_view();
    let maps = maps(backend, &test_scene, 16);
    let truth = test_scene.truth();
    // Equal steps must be finer than the light's distance from the ray, 0.1 m.
    for (spacing, coarsest) in [(Spacing::Distance, 128), (Spacing::EquiAngular, 64)] {
        let errors = [1, 2, 4, 8].map(|finer| {
            let image = march(backend, &test_scene, &maps, coarsest * finer, spacing);
            (coarsest * finer, image_error(&image, &truth).rmse)
        });
        let measured = order(&errors);
        assert!(
            (measured - 2.0).abs() <= Allowed::Order.error(),
            "{spacing:?}: order {measured:.2}, {errors:?}"
        );
    }
}

fn without_shadows_16_equi_angular_steps_beat_64_of_equal_length<B: Subject>(backend: &B) {
    let test_scene = unshadowed_lamp_in_view();
    let maps = maps(backend, &test_scene, 16);
    let truth = test_scene.truth();
    let error = |samples, spacing| {
        image_error(
            &march(backend, &test_scene, &maps, samples, spacing),
            &truth,
        )
    };
    let few = error(16, Spacing::EquiAngular);
    let many = error(64, Spacing::Distance);
    assert!(few.rmse < many.rmse, "{few:?} {many:?}");
    assert!(few.max < many.max, "{few:?} {many:?}");
}

/// A lamp 4 m in front of the eye, and nothing in its light.
fn unshadowed_lamp_in_view() -> TestScene {
    let grey = Vec3::splat(0.1);
    let lamp = Vec3::new(0.013, 0.021, -4.0);
    // Pixels of 0.2 m around the lamp, none closer to it than 0.1 m.
    let rays = (0..400).map(|i| {
        let (x, y) = ((i % 20) as f32 - 9.5, (i / 20) as f32 - 9.5);
        Ray::new(Vec3::ZERO, Vec3::new(0.05 * x, 0.05 * y, -1.0), 10.0).unwrap()
    });
    let geometry = shapes::nothing();
    TestScene {
        name: "lamp in view",
        tracer: Tracer::new(&geometry),
        geometry,
        emitters: vec![
            Emitter::point(lamp, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap(),
        ],
        areas: Vec::new(),
        medium: Medium::new(grey, 0.2 * grey, PhaseFunction::Isotropic).unwrap(),
        camera: Camera::look_at(Vec3::ZERO, lamp, 1.0).unwrap(),
        size: [20, 20],
        rays: rays.collect(),
        hits: vec![None; 400],
        translucent: Vec::new(),
        height_fog: None,
    }
}

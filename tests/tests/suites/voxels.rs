//! Voxelized shadow volumes converge to the reference, wherever the light is.

use crepuscular_tests::scenes::{eye, least_order, maps};
use crepuscular_tests::suite::{Subject, cpu_alone, cpu_with_threads};
use glam::Vec3;
use lighting::airlight::{EquiAngular, Quadrature};
use lighting::scene::Emission;
use lighting::scene::procedural::Embedded;
use lighting::shadow_map::{Casters, ShadowMap};
use lighting::voxelized::{Detail, Resolution, VoxelVolume};
use lighting::{Emitter, LitRays, Ray};
use reference::metrics::{image_error, order};
use reference::scenes::TestScene;
use reference::tolerances::Allowed;

crepuscular_tests::on_every_backend!(heavy:
    with_the_map_refined_along_voxels_converge_to_the_reference,
    wherever_a_lamp_is_voxels_converge_to_the_reference,
);

/// Voxels along each coordinate at first.
const COARSEST: u32 = 64;

const REFINEMENTS: [u32; 4] = [1, 2, 4, 8];

/// The largest error with a lamp within a few centimetres of the eye. Shadows between
/// light rays and eye rays that are thinner than two voxels have no voxels there, up to
/// more voxels than these: what is left is what those shadows take, and has no order.
const NEXT_TO_THE_EYE: f64 = 1e-4;

/// What voxels are made from.
enum Blockers<'a, M: gpu_backend::Memory> {
    Maps(&'a [ShadowMap<M>]),
    Triangles(&'a Casters<M>),
}

/// The images of a test scene from `side` voxels along each coordinate, one for each detail
/// that is gathered from them.
fn images<B: Subject, const N: usize>(
    backend: &B,
    test_scene: &TestScene,
    blockers: &Blockers<'_, B::Memory>,
    side: u32,
    details: [Detail; N],
) -> [Vec<[f32; 4]>; N] {
    let rays = backend.upload(&test_scene.rays).unwrap();
    let zeros = |_| backend.zeros::<[f32; 4]>(test_scene.rays.len()).unwrap();
    let mut images = details.map(zeros);
    let quadrature = Quadrature::with_tolerance(test_scene.medium.phase(), 1e-4).unwrap();
    let one = EquiAngular::new(1).unwrap();
    let resolution = Resolution::new(side, side, side).unwrap();
    let mut volume = VoxelVolume::new(backend, resolution).unwrap();
    for (index, emitter) in test_scene.emitters.iter().enumerate() {
        match blockers {
            Blockers::Maps(maps) => volume.update(backend, emitter, &eye(test_scene), &maps[index]),
            Blockers::Triangles(casters) => {
                volume.update_from_triangles(backend, emitter, &eye(test_scene), casters)
            }
        }
        .unwrap();
        let lit = LitRays::new(&rays, emitter, &test_scene.medium);
        for (detail, radiance) in details.into_iter().zip(&mut images) {
            let source = volume.source(detail);
            match detail {
                Detail::Voxels => backend.gather(&lit, &source, &one, radiance),
                _ => backend.gather(&lit, &source, &quadrature, radiance),
            }
            .unwrap();
        }
    }
    images.map(|radiance| backend.download(&radiance).unwrap())
}

fn with_the_map_refined_along_voxels_converge_to_the_reference<B: Subject>(backend: &B) {
    // Bits are binary: at a shadow's edge first order.
    for embedded in Embedded::ALL {
        let test_scene = TestScene::resolvable(embedded, 32, 18, COARSEST);
        let truth = test_scene.truth();
        let details = [Detail::Runs, Detail::Voxels];
        let errors = REFINEMENTS.map(|finer| {
            let maps = maps(backend, &test_scene, 128 * finer);
            let side = COARSEST * finer;
            let blockers = Blockers::Maps(&maps);
            images(backend, &test_scene, &blockers, side, details)
                .map(|image| (side, image_error(&image, &truth).rmse))
        });
        for (index, detail) in details.into_iter().enumerate() {
            let errors = errors.map(|of_details| of_details[index]);
            let measured = order(&errors);
            println!(
                "{}, {detail:?}: order {measured:.2}, {errors:?}",
                test_scene.name
            );
            assert!(
                measured >= least_order(embedded),
                "{}, {detail:?}: order {measured:.2}, {errors:?}",
                test_scene.name
            );
        }
    }
}

/// A lamp in the middle of the picture, just outside of it, behind the camera,
/// and on its way through the eye.
fn wherever_a_lamp_is_voxels_converge_to_the_reference<B: Subject>(backend: &B) {
    let mut test_scene = TestScene::new(Embedded::Fence, 32, 18);
    let eye = test_scene.camera.eye();
    let rotation = test_scene.camera.rotation();
    let (forward, right) = (rotation * Vec3::NEG_Z, rotation * Vec3::X);
    // Half of the field of view is below 45 degrees up and down.
    for (name, offset) in [
        ("in view", 4.1 * forward + 0.03 * right),
        ("beside the picture", 0.7 * forward + 2.9 * right),
        ("behind the camera", -3.3 * forward + 0.1 * right),
        ("behind, on the axis", -2.0 * forward),
        ("5 cm before the eye", 0.04 * forward + 0.03 * right),
        ("before the eye", 0.02 * forward + 0.01 * right),
        ("behind the eye", -0.013 * forward - 0.01 * right),
    ] {
        let lamp = Emitter::point(
            eye + offset,
            Vec3::splat(5.0),
            f32::INFINITY,
            Emission::Isotropic,
        );
        test_scene.emitters = vec![lamp.unwrap()];
        let truth = test_scene.truth();
        let errors = REFINEMENTS.map(|finer| {
            let maps = maps(backend, &test_scene, 128 * finer);
            let side = COARSEST * finer;
            let blockers = Blockers::Maps(&maps);
            let [image] = images(backend, &test_scene, &blockers, side, [Detail::Runs]);
            (side, image_error(&image, &truth))
        });
        let measured = order(&errors.map(|(side, error)| (side, error.rmse)));
        println!("{name}: order {measured:.2}, {errors:?}");
        let holds = if name.ends_with("the eye") {
            errors.iter().all(|(_, error)| error.rmse < NEXT_TO_THE_EYE)
        } else {
            measured >= 1.0 - Allowed::Order.error()
        };
        assert!(holds, "{name}: order {measured:.2}, {errors:?}");
    }
}

#[test]
fn threads_change_no_bit_of_voxels_or_images() {
    for embedded in [Embedded::City, Embedded::Coil] {
        let test_scene = TestScene::new(embedded, 32, 18);
        let images = |backend: &gpu_backend::Cpu| {
            let maps = maps(backend, &test_scene, 256);
            let details = [Detail::Average, Detail::Voxels, Detail::Runs];
            images(backend, &test_scene, &Blockers::Maps(&maps), 128, details)
        };
        assert!(
            cpu_alone().map(|cpu| images(&cpu)) == cpu_with_threads().map(|cpu| images(&cpu)),
            "{}",
            test_scene.name
        );
    }
}

#[test]
fn voxels_from_triangles_converge_without_a_map() {
    let cpu = cpu_with_threads().unwrap();
    for embedded in [Embedded::Coil, Embedded::Fence, Embedded::TexturedSpot] {
        let test_scene = TestScene::resolvable(embedded, 32, 18, COARSEST);
        let truth = test_scene.truth();
        let casters = Casters::upload(&cpu, &test_scene.geometry).unwrap();
        let blockers = Blockers::Triangles(&casters);
        let errors = REFINEMENTS.map(|finer| {
            let side = COARSEST * finer;
            let [image] = images(&cpu, &test_scene, &blockers, side, [Detail::Runs]);
            (side, image_error(&image, &truth).rmse)
        });
        let measured = order(&errors);
        assert!(
            measured >= 1.0 - Allowed::Order.error(),
            "{}: order {measured:.2}, {errors:?}",
            test_scene.name
        );
    }
}

/// Rays that meet no surface and no blocker have the closed form, whatever the
/// detail.
#[test]
fn without_a_shadow_all_details_are_the_unshadowed_light() {
    let cpu = cpu_with_threads().unwrap();
    let mut test_scene = TestScene::new(Embedded::Coil, 32, 18);
    test_scene.geometry = reference::shapes::nothing();
    let end = |ray: &Ray| Ray::new(ray.origin(), ray.direction(), 20.0).unwrap();
    test_scene.rays = test_scene.rays.iter().map(end).collect();
    let truth = test_scene.truth();
    let maps = maps(&cpu, &test_scene, 64);
    let details = [Detail::Average, Detail::Runs];
    let images = images(&cpu, &test_scene, &Blockers::Maps(&maps), 64, details);
    for (detail, image) in details.into_iter().zip(images) {
        let error = image_error(&image, &truth);
        // The quadrature's tolerance, which is relative: of the brightest pixel
        // it is a larger part of the mean, by which the other is divided.
        let brightest = truth.radiance.iter().flatten().copied().fold(0.0, f64::max);
        assert!(
            error.rmse < 1e-4 * brightest / error.mean && error.rel_p99 < 1e-4,
            "{detail:?} {error:?}"
        );
    }
}

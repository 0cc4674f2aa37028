//! Precomputed shadows against exact visibility and the reference image.

use crepuscular_tests::scenes::least_order;
use crepuscular_tests::suite::{cpu_alone, cpu_with_threads};
use glam::Vec3;
use gpu_backend::Cpu;
use lighting::airlight::Quadrature;
use lighting::precomputed::{BakedShadow, Builder, FilterSize, Resolution};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::{Medium, PhaseFunction};
use lighting::visibility::{Both, Exact, SurfaceShadow};
use lighting::{Gather, LightPath, LitInterval, LitRays, VisibilitySource};
use proptest::prelude::*;
use reference::generators::{bulb, ray, soup, sun};
use reference::metrics::{image_error, order};
use reference::oracle::image::{Options, reference};
use reference::property::holds_for;
use reference::scenes::TestScene;
use reference::shapes;

fn baked(cpu: &Cpu, test_scene: &TestScene, resolution: u32) -> Vec<BakedShadow> {
    let resolution = Resolution::new(resolution).unwrap();
    let bake = |emitter| {
        BakedShadow::bake(
            cpu,
            &test_scene.geometry,
            emitter,
            resolution,
            Builder::new(),
        )
        .unwrap()
        .0
    };
    test_scene.emitters.iter().map(bake).collect()
}

fn image<V: VisibilitySource>(cpu: &Cpu, test_scene: &TestScene, sources: &[V]) -> Vec<[f32; 4]> {
    let quadrature = Quadrature::with_tolerance(test_scene.medium.phase(), 1e-5).unwrap();
    let mut radiance = vec![[0.0; 4]; test_scene.rays.len()];
    for (emitter, source) in test_scene.emitters.iter().zip(sources) {
        cpu.gather(
            &LitRays::new(&test_scene.rays, emitter, &test_scene.medium),
            source,
            &quadrature,
            &mut radiance,
        )
        .unwrap();
    }
    radiance
}

#[test]
fn images_converge_to_the_reference_as_grids_get_finer() {
    let cpu = Cpu::new();
    for embedded in Embedded::ALL {
        let test_scene = TestScene::new(embedded, 32, 18);
        let truth = reference(
            &test_scene.rays,
            &test_scene.emitters,
            &test_scene.medium,
            &test_scene.geometry,
            Options::default(),
        );
        let errors = [1, 2, 4, 8].map(|finer| {
            let side = 128 * finer;
            let image = image(&cpu, &test_scene, &baked(&cpu, &test_scene, side));
            (side, image_error(&image, &truth).rmse)
        });
        let measured = order(&errors);
        println!("{}: order {measured:.2}, {errors:?}", test_scene.name);
        assert!(
            measured >= least_order(embedded),
            "{}: order {measured:.2}, {errors:?}",
            test_scene.name
        );
    }
}

#[test]
fn threads_change_no_bit_of_a_bake_or_an_image() {
    for embedded in [Embedded::City, Embedded::Coil] {
        let test_scene = TestScene::new(embedded, 32, 18);
        let all = |cpu: Cpu| {
            let baked = baked(&cpu, &test_scene, 256);
            let image = image(&cpu, &test_scene, &baked);
            let grids = baked.iter().flat_map(BakedShadow::grids);
            let bytes: Vec<Vec<u8>> = grids.map(|grid| grid.as_bytes().to_vec()).collect();
            (bytes, image)
        };
        assert!(
            cpu_alone().map(all) == cpu_with_threads().map(all),
            "{}",
            test_scene.name
        );
    }
}

/// Length that is lit according to one list of parts and not to another.
fn apart<A, B>(a: &[LitInterval<A>], b: &[LitInterval<B>]) -> f32 {
    let mut apart = 0.0;
    for part in a {
        let (start, end) = (part.interval.start, part.interval.end.min(1e4));
        let covered: f32 = (b.iter())
            .map(|other| (other.interval.end.min(end) - other.interval.start.max(start)).max(0.0))
            .sum();
        apart += (end - start - covered).max(0.0);
    }
    apart
}

#[test]
fn lit_parts_differ_from_the_exact_ones_in_proportion_to_the_voxels() {
    let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let emitter = prop_oneof![bulb(10.0).boxed(), sun().boxed()];
    let rays = prop::collection::vec(ray(10.0), 40);
    holds_for(
        40,
        (soup(10.0, 12), emitter, rays),
        |(triangles, emitter, rays)| {
            let geometry = shapes::geometry(&triangles);
            let tracer = Tracer::new(&geometry);
            let cpu = Cpu::new();
            let differ = |side: u32| {
                let resolution = Resolution::new(side).unwrap();
                let (baked, _) =
                    BakedShadow::bake(&cpu, &geometry, &emitter, resolution, Builder::new())
                        .unwrap();
                let mut sum = 0.0;
                for ray in &rays {
                    let ray = ray.with_length(ray.length().min(40.0));
                    let Some(path) = LightPath::new(&ray, &emitter, &medium) else {
                        continue;
                    };
                    let (mut found, mut exact) = (Vec::new(), Vec::new());
                    baked.lit_intervals(&path, &mut found);
                    Exact::new(&tracer).lit_intervals(&path, &mut exact);
                    sum += (apart(&found, &exact) + apart(&exact, &found)).min(1.0);
                }
                sum / rays.len() as f32
            };
            let (coarse, fine) = (differ(256), differ(2048));
            println!("{coarse} {fine}");
            prop_assert!(fine <= 0.3 * coarse + 0.02, "{coarse} then {fine}");
            Ok(())
        },
    );
}

#[test]
fn casters_may_be_shared_out_among_sources() {
    let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let emitter = prop_oneof![bulb(10.0).boxed(), sun().boxed()];
    let rays = prop::collection::vec(ray(10.0), 40);
    let parts = (soup(10.0, 20), soup(10.0, 20));
    holds_for(
        100,
        (parts, emitter, rays),
        |((still, moving), emitter, rays)| {
            let all = [still.clone(), moving.clone()].concat();
            let [still, moving, all] = [still, moving, all].map(|list| shapes::geometry(&list));
            let [still, moving, all] = [&still, &moving, &all].map(Tracer::new);
            let both = Both(Exact::new(&still), Exact::new(&moving));
            for ray in &rays {
                let Some(path) = LightPath::new(ray, &emitter, &medium) else {
                    continue;
                };
                let (mut found, mut expected) = (Vec::new(), Vec::new());
                both.lit_intervals(&path, &mut found);
                Exact::new(&all).lit_intervals(&path, &mut expected);
                let apart = apart(&found, &expected) + apart(&expected, &found);
                prop_assert!(apart <= 1e-5 * path.span().end.clamp(1.0, 1e4), "{apart}");
            }
            Ok(())
        },
    );
}

#[test]
fn shadows_on_surfaces_are_those_of_traced_rays_away_from_edges() {
    let cpu = Cpu::new();
    for embedded in [Embedded::City, Embedded::Landscape] {
        let test_scene = TestScene::new(embedded, 64, 36);
        let bounds = test_scene.geometry.bounds();
        let texel = bounds.min().distance(bounds.max()) / 4096.0;
        let one = FilterSize::new(1).unwrap();
        for (emitter, baked) in test_scene
            .emitters
            .iter()
            .zip(&baked(&cpu, &test_scene, 4096))
        {
            let shadow = baked.filtered(one);
            let (mut wrong, mut all) = (0, 0);
            for ray in test_scene
                .rays
                .iter()
                .filter(|ray| ray.length().is_finite())
            {
                let Some(hit) = test_scene
                    .tracer
                    .closest_hit(&ray.with_length(f32::INFINITY))
                else {
                    continue;
                };
                let [a, b, c] = test_scene.geometry.triangles()[hit.triangle as usize];
                let normal = (b - a).cross(c - a).normalize();
                let point = ray.at(hit.distance);
                let lifted = point + 0.5 * texel * normal;
                let to_light = match emitter {
                    lighting::Emitter::Directional(sun) => -sun.direction(),
                    lighting::Emitter::Point(point) => (point.position() - lifted).normalize(),
                };
                if normal.dot(to_light) < 0.2 {
                    continue;
                }
                let lit = |at| !test_scene.tracer.occluded(at, to_light, 0.0, f32::INFINITY);
                // Edges may be off by texels.
                let (u, v) = normal.any_orthonormal_pair();
                let around = [u, v, u + v, u - v].map(|aside| 2.0 * texel * aside);
                let around = around
                    .iter()
                    .flat_map(|aside| [lifted + *aside, lifted - *aside]);
                let states: Vec<bool> = around.map(lit).collect();
                let lit = lit(lifted);
                if states.iter().any(|state| *state != lit) {
                    continue;
                }
                all += 1;
                wrong += u32::from((shadow.visibility(point, normal).x > 0.5) != lit);
            }
            println!("{}: {wrong} of {all}", test_scene.name);
            assert!(
                all > 300 && 200 * wrong < all,
                "{}: {wrong} of {all}",
                test_scene.name
            );
        }
    }
}

//! The GPU agrees with the CPU, which defines the result, on every embedded
//! scene.

use crepuscular_tests::suite::{self, Subject};
use gpu_backend::{Cpu, Download};
use lighting::airlight::{EquiAngular, Midpoint};
use lighting::methods::prefiltered::{Moments, PrefilteredMap};
use lighting::scene::Emission;
use lighting::scene::procedural::Embedded;
use lighting::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use lighting::visibility::{March, Spacing, Unshadowed};
use lighting::{Emitter, Gather, LitRays, Ray, Touching};
use reference::scenes::TestScene;
use reference::tolerances::Allowed;

fn gathered<B, V, A>(
    backend: &B,
    test_scene: &TestScene,
    emitter: &Emitter,
    (visibility, airlight): (&V, &A),
) -> Vec<[f32; 4]>
where
    B: Gather<V, A> + Download,
{
    gathered_as(
        backend,
        test_scene,
        emitter,
        Touching::Apart,
        (visibility, airlight),
    )
}

fn gathered_as<B, V, A>(
    backend: &B,
    test_scene: &TestScene,
    emitter: &Emitter,
    touching: Touching,
    (visibility, airlight): (&V, &A),
) -> Vec<[f32; 4]>
where
    B: Gather<V, A> + Download,
{
    let rays = backend.upload(&test_scene.rays).unwrap();
    let mut radiance = backend.zeros::<[f32; 4]>(test_scene.rays.len()).unwrap();
    let lit = LitRays {
        touching,
        ..LitRays::new(&rays, emitter, &test_scene.medium)
    };
    backend
        .gather(&lit, visibility, airlight, &mut radiance)
        .unwrap();
    backend.download(&radiance).unwrap()
}

/// Four ways to march, in 32 steps.
fn marches<B: Subject>(
    backend: &B,
    test_scene: &TestScene,
    emitter: &Emitter,
    map: &ShadowMap<B::Memory>,
) -> [Vec<[f32; 4]>; 4] {
    let march = |spacing| March::new(map, 32, spacing);
    let nodes = |n| EquiAngular::new(n).unwrap();
    [
        gathered(
            backend,
            test_scene,
            emitter,
            (&march(Spacing::Distance), &Midpoint),
        ),
        gathered(
            backend,
            test_scene,
            emitter,
            (&march(Spacing::EquiAngular), &nodes(1)),
        ),
        gathered_as(
            backend,
            test_scene,
            emitter,
            Touching::Joined,
            (&march(Spacing::Distance), &nodes(8)),
        ),
        gathered_as(
            backend,
            test_scene,
            emitter,
            Touching::Joined,
            (&march(Spacing::EquiAngular), &nodes(8)),
        ),
    ]
}

/// What a light that shines everywhere would give: the measure of errors at
/// the border of a cone.
fn without_borders(emitter: &Emitter) -> Emitter {
    match emitter {
        Emitter::Point(point) => Emitter::point(
            point.position(),
            point.intensity(),
            f32::INFINITY,
            Emission::Isotropic,
        )
        .unwrap(),
        other => other.clone(),
    }
}

fn allowed(ray: &Ray, emitter: &Emitter) -> f64 {
    let Emitter::Point(point) = emitter else {
        return Allowed::GpuRadiance.error();
    };
    let to_light = (point.position() - ray.origin()).as_dvec3();
    let h = to_light.cross(ray.direction().as_dvec3()).length();
    // Images put a light no closer to a ray than this.
    let ratio = (to_light.length() / h).min(1e4);
    Allowed::GpuRadiance.error() + ratio * Allowed::GpuRadianceNearTheAxis.error()
}

/// How many rays are not the same on both backends, as parts of what an unshadowed light
/// would give.
fn differing(
    rays: &[Ray],
    emitter: &Emitter,
    [expected, actual, scale]: [&[[f32; 4]]; 3],
) -> usize {
    let differs = |i: &usize| {
        let i = *i;
        (0..3).any(|c| {
            let (e, g) = (f64::from(expected[i][c]), f64::from(actual[i][c]));
            let scale = f64::from(scale[i][c].max(f32::MIN_POSITIVE)).max(e);
            // What is not a number differs.
            !((e - g).abs() <= scale * allowed(&rays[i], emitter))
        })
    };
    (0..rays.len()).filter(differs).count()
}

#[test]
fn marches_through_the_same_map_agree_on_every_scene() {
    let Some(gpu) = suite::gpu() else { return };
    let cpu = Cpu::new();
    let reference = EquiAngular::new(8).unwrap();
    for embedded in Embedded::ALL {
        let test_scene = TestScene::new(embedded, 48, 27);
        let casters = Casters::upload(&cpu, &test_scene.geometry).unwrap();
        let (mut all, mut different) = (0, 0);
        for emitter in &test_scene.emitters {
            let map = cpu.shadow_map(&casters, emitter, 256).unwrap();
            let expected = marches(&cpu, &test_scene, emitter, &map);
            let actual = marches(&gpu, &test_scene, emitter, &map.upload(&gpu).unwrap());
            let bare = without_borders(emitter);
            let scale = gathered(&cpu, &test_scene, &bare, (&Unshadowed, &reference));
            for (expected, actual) in expected.iter().zip(&actual) {
                all += expected.len();
                different += differing(&test_scene.rays, emitter, [expected, actual, &scale]);
            }
        }
        let share = different as f64 / all as f64;
        println!("{}: {different} of {all} rays differ", test_scene.name);
        assert!(
            share <= Allowed::GpuRays.error(),
            "{}: {different} of {all} rays differ",
            test_scene.name
        );
    }
}

/// Some software drivers end the loops of a ray after 65,535 turns in all.
#[test]
fn marches_of_many_steps_through_filtered_maps_agree() {
    const STEPS: u32 = 2000;
    let Some(gpu) = suite::gpu() else { return };
    let cpu = Cpu::new();
    let test_scene = TestScene::new(Embedded::Fence, 16, 9);
    let casters = Casters::upload(&cpu, &test_scene.geometry).unwrap();
    let bounds = test_scene.geometry.bounds();
    for kind in [
        Moments::Variance,
        Moments::ExponentialVariance,
        Moments::Four,
        Moments::Six,
    ] {
        let (mut all, mut different) = (0, 0);
        for emitter in &test_scene.emitters {
            let map = cpu.shadow_map(&casters, emitter, 64).unwrap();
            let there = map.upload(&gpu).unwrap();
            let ours = PrefilteredMap::new(&cpu, &map, kind, &bounds, 0).unwrap();
            let theirs = PrefilteredMap::new(&gpu, &there, kind, &bounds, 0).unwrap();
            let ours = March::new(ours, STEPS, Spacing::Distance);
            let theirs = March::new(theirs, STEPS, Spacing::Distance);
            let expected = gathered(&cpu, &test_scene, emitter, (&ours, &Midpoint));
            let actual = gathered(&gpu, &test_scene, emitter, (&theirs, &Midpoint));
            let scale = gathered(&cpu, &test_scene, emitter, (&Unshadowed, &Midpoint));
            all += expected.len();
            different += differing(&test_scene.rays, emitter, [&expected, &actual, &scale]);
        }
        let share = different as f64 / all as f64;
        assert!(
            share <= Allowed::GpuRays.error(),
            "{kind:?}: {different} of {all} rays differ"
        );
    }
}

#[test]
fn shadow_maps_agree_but_for_texels_on_an_edge_on_every_scene() {
    const SIDE: usize = 256;
    let Some(gpu) = suite::gpu() else { return };
    let cpu = Cpu::new();
    for embedded in Embedded::ALL {
        let test_scene = TestScene::new(embedded, 1, 1);
        let here = Casters::upload(&cpu, &test_scene.geometry).unwrap();
        let there = Casters::upload(&gpu, &test_scene.geometry).unwrap();
        for emitter in &test_scene.emitters {
            let expected = cpu.shadow_map(&here, emitter, SIDE as u32).unwrap();
            let actual = gpu.shadow_map(&there, emitter, SIDE as u32).unwrap();
            let actual = gpu.download(actual.depth()).unwrap();
            let expected = expected.depth();
            let agree = |a: f32, b: f32, error: f64| {
                f64::from((a - b).abs()) <= error * f64::from(a.max(b))
            };
            // Texels with a neighbour of clearly another depth lie on an edge.
            let is_edge = |i: usize| {
                let (x, y) = (i % SIDE, i / SIDE % SIDE);
                let near = [
                    (x > 0).then(|| i - 1),
                    (x + 1 < SIDE).then(|| i + 1),
                    (y > 0).then(|| i - SIDE),
                    (y + 1 < SIDE).then(|| i + SIDE),
                ];
                near.into_iter()
                    .flatten()
                    .any(|j| !agree(expected[i], expected[j], 0.05))
            };
            let edges = (0..expected.len()).filter(|&i| is_edge(i)).count();
            let different = (0..expected.len())
                .filter(|&i| !agree(expected[i], actual[i], Allowed::GpuTexel.error()))
                .count();
            println!(
                "{}: {different} texels differ, {edges} on edges",
                test_scene.name
            );
            // Triangles smaller than a texel have edges that no pair shows.
            assert!(
                different as f64 <= 2.0 + Allowed::GpuEdgeTexels.error() * edges as f64,
                "{}: {different} of {} texels differ, {edges} lie on edges",
                test_scene.name,
                expected.len()
            );
        }
    }
}

//! The lit runs of a shadow map, by trees and by walking, against an oracle.

use crepuscular_tests::map_cases::{casters, fog, light_and_eye, rays};
use glam::Vec3;
use gpu_backend::Cpu;
use lighting::methods::epipolar::{MapRuns, Visits};
use lighting::scene::Emission;
use lighting::scene::procedural::Embedded;
use lighting::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use lighting::{Emitter, Interval, LightPath, LitInterval, Ray, VisibilitySource};
use reference::oracle::map_runs::Map;
use reference::property::cases;
use reference::random::Random;
use reference::scenes::TestScene;
use reference::tolerances::Allowed;

/// The length that is in one of two lists of runs and not in the other.
fn difference(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let mut ends: Vec<(f64, usize, bool)> = Vec::new();
    for (list, runs) in [a, b].into_iter().enumerate() {
        for run in runs {
            ends.extend([(run[0], list, true), (run[1], list, false)]);
        }
    }
    ends.sort_unstable_by(|x, y| x.0.total_cmp(&y.0));
    let mut inside = [false; 2];
    let mut sum = 0.0;
    for pair in ends.windows(2) {
        inside[pair[0].1] = pair[0].2;
        if inside[0] != inside[1] && pair[0].0 < pair[1].0 {
            sum += pair[1].0 - pair[0].0;
        }
    }
    sum
}

fn lit(
    source: &MapRuns<&ShadowMap<gpu_backend::Host>, gpu_backend::Host>,
    path: &LightPath<'_>,
) -> Vec<LitInterval> {
    let mut lit = Vec::new();
    source.lit_intervals(path, &mut lit);
    lit
}

/// Requires the lit parts of a path to be the oracle's but for rounding.
fn require_truth(oracle: &Map<'_>, path: &LightPath<'_>, actual: &[LitInterval], context: &str) {
    // The sky begins here.
    let finite = |x: f64| x.min(1e30);
    let truth = oracle.runs(path.ray(), path.span());
    let truth: Vec<[f64; 2]> = truth.iter().map(|run| run.map(finite)).collect();
    let found: Vec<[f64; 2]> = actual
        .iter()
        .map(|part| [part.interval.start, part.interval.end].map(|x| finite(f64::from(x))))
        .collect();
    let ends = truth.iter().chain(&found).flatten();
    let largest = ends
        .filter(|end| **end < 1e30)
        .fold(0.0, |most: f64, end| most.max(end.abs()));
    let ends = 2 * (truth.len() + found.len());
    let allowed = ends as f64 * Allowed::MapRunEnds.error() * (largest + 20.0);
    let differs = difference(&truth, &found);
    assert!(
        differs <= allowed,
        "{context}: {differs:e}\n{truth:?}\n{found:?}"
    );
}

/// Rays that run along borders of texels or towards one for ever, through the light or
/// from it.
#[test]
fn rays_along_the_axes_of_a_cube_of_maps_are_on_one_side_of_a_border() {
    let cpu = Cpu::new();
    let mut random = Random::new(285);
    let (geometry, medium) = (casters(&mut random), fog());
    let casters = Casters::upload(&cpu, &geometry).unwrap();
    let at = Vec3::new(-0.25, 0.5, 1.0);
    let light = Emitter::point(at, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
    let map = cpu.shadow_map(&casters, &light, 64).unwrap();
    let oracle = Map {
        faces: map.faces(),
        resolution: 64,
        depth: map.depth(),
    };
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    for aside in [
        Vec3::ZERO,
        Vec3::splat(0.7),
        Vec3::new(-0.3, 0.9, 0.4),
        Vec3::new(0.0, 3.0, -2.0),
    ] {
        let ahead = axes.into_iter().flat_map(|axis| [axis, -axis]);
        let rays: Vec<Ray> = ahead
            .map(|axis| Ray::new(at + aside, axis, f32::INFINITY).unwrap())
            .collect();
        let trees = MapRuns::new(&cpu, &map, &rays, &light, &medium).unwrap();
        for ray in &rays {
            let path = LightPath::new(ray, &light, &medium).unwrap();
            let actual = lit(&trees, &path);
            assert_eq!(actual, lit(&MapRuns::walked(&map), &path));
            // Along a border both sides are right.
            let along = (aside == Vec3::ZERO) || aside.x == 0.0;
            if !along {
                require_truth(&oracle, &path, &actual, &format!("{ray:?}"));
            }
        }
    }
}

/// 1e5 rays; `PROPTEST_CASES=500` makes them a million.
#[test]
fn runs_by_trees_are_those_of_every_texel_to_the_last_bit() {
    let cpu = Cpu::new();
    let mut random = Random::new(1811);
    let medium = fog();
    let (mut rays_seen, mut by_tree, mut visits) = (0_u64, 0_u64, [0_u64; 2]);
    for number in 0..cases(50).cases {
        let geometry = casters(&mut random);
        let (light, eye) = light_and_eye(&mut random, number);
        let casters = Casters::upload(&cpu, &geometry).unwrap();
        let resolution = [1, 5, 33, 64, 100, 128][random.below(6) as usize];
        let map = cpu.shadow_map(&casters, &light, resolution).unwrap();
        let rays = rays(&mut random, eye, &light);
        let trees = MapRuns::new(&cpu, &map, &rays, &light, &medium).unwrap();
        let walked = MapRuns::walked(&map);
        let oracle = Map {
            faces: map.faces(),
            resolution,
            depth: map.depth(),
        };
        for (index, ray) in rays.iter().enumerate() {
            rays_seen += 1;
            let Some(path) = LightPath::new(ray, &light, &medium) else {
                continue;
            };
            let expected = lit(&walked, &path);
            let actual = lit(&trees, &path);
            let context = format!("{number} {index}: {resolution} {light:?} {ray:?}");
            assert_eq!(actual, expected, "{context}");
            let looks = [trees.visits(&path), walked.visits(&path)];
            by_tree += u64::from(looks[0].nodes > 0);
            if looks[0].nodes > 0 {
                visits[0] += looks[0].nodes + looks[0].texels;
                visits[1] += looks[1].texels;
            }
            require_truth(&oracle, &path, &actual, &context);
        }
    }
    println!("{rays_seen} rays, {by_tree} by trees, which looked at {visits:?}");
    assert!(by_tree * 2 > rays_seen, "{by_tree} of {rays_seen}");
    assert!(visits[0] < visits[1], "{visits:?}");
}

/// The point test of the map, at the middle of each run and of each gap.
#[test]
fn runs_are_what_the_map_says_of_points() {
    let cpu = Cpu::new();
    let (mut asked, mut others) = (0, 0);
    for embedded in Embedded::ALL {
        let scene = TestScene::new(embedded, 40, 30);
        let casters = Casters::upload(&cpu, &scene.geometry).unwrap();
        for light in &scene.emitters {
            let map = cpu.shadow_map(&casters, light, 200).unwrap();
            let runs = MapRuns::new(&cpu, &map, &scene.rays, light, &scene.medium).unwrap();
            for ray in &scene.rays {
                let Some(path) = LightPath::new(ray, light, &scene.medium) else {
                    continue;
                };
                let mut last = path.span().start;
                for part in lit(&runs, &path) {
                    let Interval { start, end } = part.interval;
                    let parts = [(last, start, false), (start, end, true)];
                    for (a, b, is_lit) in parts {
                        if b.is_finite() && b - a > 1e-3 * b {
                            asked += 1;
                            others += i32::from(map.is_lit(ray.at(0.5 * (a + b))) != is_lit);
                        }
                    }
                    last = end;
                }
            }
        }
    }
    println!("{others} of {asked} points differ");
    assert!(
        f64::from(others) <= Allowed::GpuMarchRays.error() * f64::from(asked),
        "{others} of {asked}"
    );
}

/// A tree says of most of a ray at once what it is.
#[test]
fn trees_look_at_less_than_a_tenth_of_the_texels_of_a_closed_city() {
    let cpu = Cpu::new();
    let scene = TestScene::new(Embedded::City, 96, 54);
    let casters = Casters::upload(&cpu, &scene.geometry).unwrap();
    let sun = &scene.emitters[0];
    let map = cpu.shadow_map(&casters, sun, 2048).unwrap();
    let trees = MapRuns::new(&cpu, &map, &scene.rays, sun, &scene.medium).unwrap();
    let walked = MapRuns::walked(&map);
    let (mut by_tree, mut by_walk) = (Visits::default(), Visits::default());
    for ray in &scene.rays {
        let Some(path) = LightPath::new(ray, sun, &scene.medium) else {
            continue;
        };
        for (sum, source) in [(&mut by_tree, &trees), (&mut by_walk, &walked)] {
            let visits = source.visits(&path);
            sum.nodes += visits.nodes;
            sum.texels += visits.texels;
            sum.runs += visits.runs;
        }
    }
    let rays = scene.rays.len() as f64;
    let per_ray = |visits: Visits| {
        [visits.nodes, visits.texels, visits.runs].map(|count| count as f64 / rays)
    };
    let ([nodes, texels, runs], [_, crossed, _]) = (per_ray(by_tree), per_ray(by_walk));
    println!(
        "per ray: {crossed:.1} texels, {runs:.2} runs; {nodes:.1} nodes and {texels:.1} texels by trees of {} MiB",
        trees.bytes() >> 20
    );
    assert!(nodes + texels <= 0.1 * crossed && nodes <= 10.0 * runs);
}

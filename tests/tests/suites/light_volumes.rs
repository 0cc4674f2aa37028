//! The lit runs of light volumes against the maps that they are made from.

use crepuscular_tests::map_cases::{casters, fog, light_and_eye, rays};
use gpu_backend::{Cpu, Host};
use lighting::methods::epipolar::MapRuns;
use lighting::methods::light_volumes::{BuildLightVolume, LightVolume};
use lighting::scene::procedural::Embedded;
use lighting::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use lighting::{Emitter, LightPath, LitInterval, Ray, VisibilitySource};
use reference::oracle::map_runs::Map;
use reference::property::cases;
use reference::random::Random;
use reference::scenes::TestScene;
use reference::tolerances::Allowed;

/// Tolerances in texels' widths; the last one is that of a usual picture.
const TOLERANCES: [f32; 3] = [0.0, 1.0, 0.25];

fn lit(source: &impl VisibilitySource<Share = f32>, path: &LightPath<'_>) -> Vec<LitInterval> {
    let mut lit = Vec::new();
    source.lit_intervals(path, &mut lit);
    lit
}

/// What was asked of rays.
#[derive(Debug, Default)]
struct Asked {
    points: u64,
    ends: u64,
    /// Lengths that only one of mesh and map calls lit, and all lit lengths.
    differing: f64,
    lit: f64,
}

/// Requires every point of a path that a volume calls lit to be so in the map within a texel
/// sideways and the tolerance along the light, and every dark one dark: beside all ends
/// and in the middle of all parts.
fn require_within_a_texel(
    oracle: &Map<'_>,
    path: &LightPath<'_>,
    parts: &[LitInterval],
    tolerance: f32,
    asked: &mut Asked,
) {
    let span = path.span();
    let far = span.end.min(span.start + 1e4);
    let mut pieces = Vec::new();
    let mut last = span.start;
    for part in parts {
        let [start, end] = [part.interval.start, part.interval.end].map(|x| x.min(far));
        assert!(last <= start && start <= end, "{parts:?}");
        pieces.extend([(last, start, false), (start, end, true)]);
        last = end;
    }
    pieces.push((last, far, false));
    let reach = path.ray().origin().distance(oracle.faces[0].origin);
    let along = f64::from(tolerance) * 1.001 + Allowed::LightVolumeDepth.error();
    for (a, b, is_lit) in pieces {
        // Ends are rounded to f32.
        let [a, b] = [a, b].map(f64::from);
        let off = 4.0 * f64::from(f32::EPSILON) * (f64::from(reach) + b);
        if !(b - a > 4.0 * off) {
            continue;
        }
        asked.ends += u64::from(a > f64::from(span.start)) + u64::from(b < f64::from(far));
        for x in [a + off, 0.75 * a + 0.25 * b, 0.5 * (a + b), b - off] {
            let aside = 1.0 + Allowed::LightVolumeTexel.error();
            let [may_be_lit, may_be_dark] = oracle.near(path.ray(), x, aside, along);
            let is_right = if is_lit { may_be_lit } else { may_be_dark };
            asked.points += 1;
            assert!(
                is_right,
                "{x} of {a} to {b}, lit: {is_lit}, at a tolerance of {tolerance}, {:?}",
                path.ray()
            );
        }
    }
}

/// The lengths that are in one of two lists of parts and not in the other.
fn differing(a: &[LitInterval], b: &[LitInterval]) -> f64 {
    let within = |parts: &[LitInterval], from: f64, to: f64| -> f64 {
        let of = |part: &LitInterval| {
            let [start, end] = [part.interval.start, part.interval.end].map(f64::from);
            (end.min(to) - start.max(from)).max(0.0)
        };
        parts.iter().map(of).sum()
    };
    let all = |parts: &[LitInterval]| within(parts, 0.0, 1e4);
    let both: f64 = a
        .iter()
        .map(|part| {
            let [from, to] = [part.interval.start, part.interval.end].map(f64::from);
            within(b, from, to.min(1e4))
        })
        .sum();
    all(a) + all(b) - 2.0 * both
}

fn ask(
    volumes: &[(f32, LightVolume<Host>)],
    map: &ShadowMap<Host>,
    (rays, light): (&[Ray], &Emitter),
    medium: &lighting::scene::Medium,
    asked: &mut Asked,
) {
    let oracle = Map {
        faces: map.faces(),
        resolution: map.resolution(),
        depth: map.depth(),
    };
    let exact = MapRuns::walked(map);
    for ray in rays {
        let Some(path) = LightPath::new(ray, light, medium) else {
            continue;
        };
        let exact = lit(&exact, &path);
        for (tolerance, volume) in volumes {
            let parts = lit(volume, &path);
            require_within_a_texel(&oracle, &path, &parts, *tolerance, asked);
            asked.differing += differing(&parts, &exact);
            asked.lit += differing(&exact, &[]);
        }
    }
}

/// 6e4 rays; `PROPTEST_CASES=500` makes them a million.
#[test]
fn runs_end_within_a_texel_of_those_of_the_map() {
    let cpu = Cpu::new();
    let mut random = Random::new(2010);
    let medium = fog();
    let mut asked = Asked::default();
    for number in 0..cases(30).cases {
        let geometry = casters(&mut random);
        let (light, eye) = light_and_eye(&mut random, number);
        let casters = Casters::upload(&cpu, &geometry).unwrap();
        let resolution = [1, 2, 5, 33, 64, 100, 128][random.below(7) as usize];
        let map = cpu.shadow_map(&casters, &light, resolution).unwrap();
        let rays = rays(&mut random, eye, &light);
        let tolerance = TOLERANCES[number as usize % 3];
        let volumes = [(tolerance, cpu.light_volume(&map, tolerance).unwrap())];
        ask(&volumes, &map, (&rays, &light), &medium, &mut asked);
    }
    println!("{asked:?}");
    assert!(asked.ends > 1000, "{asked:?}");
}

#[test]
fn runs_of_every_scene_end_within_a_texel_of_those_of_the_map() {
    let cpu = Cpu::new();
    for embedded in Embedded::ALL {
        let scene = TestScene::new(embedded, 40, 23);
        let casters = Casters::upload(&cpu, &scene.geometry).unwrap();
        let mut asked = Asked::default();
        for light in &scene.emitters {
            let map = cpu.shadow_map(&casters, light, 200).unwrap();
            let volumes = TOLERANCES.map(|t| (t, cpu.light_volume(&map, t).unwrap()));
            ask(
                &volumes,
                &map,
                (&scene.rays, light),
                &scene.medium,
                &mut asked,
            );
        }
        let share = asked.differing / asked.lit;
        println!("{}: {share:.4} of what is lit, {asked:?}", scene.name);
    }
}

/// The mean share of the lit length on which mesh and map differ.
fn share_that_differs(scene: &TestScene, resolution: u32, tolerance: f32) -> f64 {
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &scene.geometry).unwrap();
    let mut asked = Asked::default();
    for light in &scene.emitters {
        let map = cpu.shadow_map(&casters, light, resolution).unwrap();
        let volume = cpu.light_volume(&map, tolerance).unwrap();
        let exact = MapRuns::walked(&map);
        for ray in &scene.rays {
            if let Some(path) = LightPath::new(ray, light, &scene.medium) {
                let exact = lit(&exact, &path);
                asked.differing += differing(&lit(&volume, &path), &exact);
                asked.lit += differing(&exact, &[]);
            }
        }
    }
    asked.differing / asked.lit
}

#[test]
fn mesh_and_map_converge_to_each_other_as_texels_shrink() {
    for embedded in [Embedded::City, Embedded::TexturedSpot, Embedded::Coil] {
        let scene = TestScene::new(embedded, 40, 23);
        for tolerance in [0.0, 0.25] {
            let shares = [64, 256, 1024].map(|n| share_that_differs(&scene, n, tolerance));
            println!("{} {tolerance}: {shares:?}", scene.name);
            // The coarsest texels are wider than wires.
            assert!(shares[1] < shares[0] && shares[2] < 0.5 * shares[1]);
        }
    }
}

/// Every texel of thin casters has its shadow, at its centre, wherever it is seen from.
#[test]
fn every_texel_keeps_its_shadow() {
    let cpu = Cpu::new();
    let medium = fog();
    for embedded in [Embedded::Fence, Embedded::Coil, Embedded::City] {
        let scene = TestScene::new(embedded, 8, 8);
        let casters = Casters::upload(&cpu, &scene.geometry).unwrap();
        for light in scene.emitters.iter().take(2) {
            let map = cpu.shadow_map(&casters, light, 150).unwrap();
            for tolerance in TOLERANCES {
                let volume = cpu.light_volume(&map, tolerance).unwrap();
                let (mut shadows, side) = (0, 150_usize);
                for (index, &depth) in map.depth().iter().enumerate() {
                    if depth == f32::MAX {
                        continue;
                    }
                    let face = &map.faces()[index / side / side];
                    let (column, row) = (index % side, index / side % side);
                    let centre = |i: usize| (2 * i + 1) as f32 / side as f32 - 1.0;
                    let (x, y) = (centre(column), -centre(row));
                    let (from, along, width) = match face.rays {
                        lighting::scene::raster::Rays::Parallel {
                            half_width,
                            half_height,
                        } => (
                            face.origin + x * half_width * face.right + y * half_height * face.up,
                            face.forward,
                            2.0 * half_width.min(half_height) / side as f32,
                        ),
                        lighting::scene::raster::Rays::Central { tan } => {
                            let way = face.forward + tan * (x * face.right + y * face.up);
                            (
                                face.origin,
                                way.normalize(),
                                2.0 * tan * depth / side as f32,
                            )
                        }
                    };
                    // Reciprocals of depths are within the tolerance: 1/(1 - 2/150).
                    let off = 1.03 * tolerance * width + 1e-5 * depth;
                    for (at, is_lit) in [(depth - off, true), (depth + off, false)] {
                        // Short, and across the light.
                        let point = from + at * along;
                        let across = along.any_orthonormal_vector();
                        let Some(ray) = Ray::new(point, across, 1e-7 * depth) else {
                            continue;
                        };
                        let Some(path) = LightPath::new(&ray, light, &medium) else {
                            continue;
                        };
                        shadows += 1;
                        let found = !lit(&volume, &path).is_empty();
                        assert_eq!(found, is_lit, "{}: {column} {row}", scene.name);
                    }
                }
                assert!(shadows > 1000, "{}: {shadows}", scene.name);
            }
        }
    }
}

/// A floor and walls are a few patches.
#[test]
fn a_city_has_far_fewer_patches_than_texels() {
    let cpu = Cpu::new();
    let scene = TestScene::new(Embedded::City, 8, 8);
    let casters = Casters::upload(&cpu, &scene.geometry).unwrap();
    let map = cpu.shadow_map(&casters, &scene.emitters[0], 1024).unwrap();
    let patches = TOLERANCES.map(|t| cpu.light_volume(&map, t).unwrap().patches());
    println!("{patches:?} patches of 1025² cells");
    assert!(3 * patches[2] < 1025 * 1025);
    assert!(patches[1] <= patches[2] && patches[2] <= patches[0]);
}

/// Nothing to see, a single texel, all dark, a light at the eye.
#[test]
fn extremes_have_sound_runs() {
    let cpu = Cpu::new();
    let mut random = Random::new(7);
    let medium = fog();
    for number in 0..48 {
        let geometry = casters(&mut random);
        let (light, eye) = light_and_eye(&mut random, number);
        let casters = Casters::upload(&cpu, &geometry).unwrap();
        let map = cpu.shadow_map(&casters, &light, 1).unwrap();
        for tolerance in [0.0, f32::NAN, -1.0, f32::INFINITY] {
            let volume = cpu.light_volume(&map, tolerance).unwrap();
            for ray in rays(&mut random, eye, &light).iter().take(100) {
                let Some(path) = LightPath::new(ray, &light, &medium) else {
                    continue;
                };
                let mut last = path.span().start;
                for part in lit(&volume, &path) {
                    assert!(last <= part.interval.start);
                    assert!(part.interval.start < part.interval.end);
                    last = part.interval.end;
                }
                assert!(last <= path.span().end);
            }
        }
    }
}

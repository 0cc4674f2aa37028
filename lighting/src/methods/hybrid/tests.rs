//! No shadow is outside of the volumes, and what is left out changes nothing.

use glam::{Quat, Vec3};
use reference::random::Random;

use gpu_backend::Cpu;

use super::asking::whole;
use super::search::Line;
use super::*;
use crate::methods::epipolar::MapRuns;
use crate::scene::{Bounds, Cone, Emission, Geometry, Medium, Mesh, PhaseFunction, Scene};
use crate::shadow_map::{Casters, RenderShadowMap};
use crate::{Emitter, Ray};

/// Texels per side of maps, no multiple of a cell. The axis of a light is in the middle of
/// a texel: on a border it would be rounded to either side.
pub(super) const MAP: u32 = 125;

fn vector(random: &mut Random, size: f32) -> Vec3 {
    random.vector(size).into()
}

/// Open meshes: slivers, wires thinner than a texel and large triangles, within ±6 m.
fn casters(random: &mut Random, count: u32) -> Geometry {
    let positions = (0..count).flat_map(|i| {
        let corner = vector(random, 6.0);
        let (long, short) = match i % 4 {
            0 => (random.between(1.0, 4.0), 1e-3),
            1 => (random.between(2.0, 6.0), random.between(1.0, 4.0)),
            _ => (random.between(0.05, 1.0), random.between(0.05, 1.0)),
        };
        [
            corner,
            corner + vector(random, long),
            corner + vector(random, short),
        ]
    });
    let mesh = Mesh {
        positions: positions.collect(),
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    };
    Geometry::new(&Scene::from(mesh)).unwrap()
}

/// A light and an eye: eyes before and behind a light, beside it and at it.
fn light_and_eye(random: &mut Random, number: u32) -> (Emitter, Vec3) {
    let position = vector(random, 5.0);
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, vector(random, 1.0).normalize_or(Vec3::X));
    let axis = rotation * Vec3::NEG_Z;
    let point = |position, range, emission| Emitter::point(position, Vec3::ONE, range, emission);
    let spot = |outer| Emission::spot(rotation, Cone { inner: 0.0, outer }, None).unwrap();
    let far = f32::INFINITY;
    let light = match number % 8 {
        0 | 1 => point(position, far, Emission::Isotropic),
        2 => point(position, far, spot(random.between(0.1, 1.3))),
        3 => point(position, random.between(2.0, 9.0), spot(1.0)),
        4 => point(position + 20.0 * axis, far, Emission::Isotropic),
        5 => point(position, far, Emission::Cosine { normal: axis }),
        6 => Emitter::directional(axis, Vec3::ONE),
        _ => Emitter::directional(Vec3::NEG_Y, Vec3::ONE),
    };
    let eye = match number / 8 % 6 {
        0 => vector(random, 5.0),
        1 => vector(random, 30.0),
        2 => position + random.between(0.1, 9.0) * axis,
        3 => position - random.between(0.1, 9.0) * axis,
        4 => position + random.between(0.1, 9.0) * axis.any_orthonormal_vector(),
        _ => position,
    };
    (light.unwrap(), eye)
}

/// Rays all around, close by the light and through it, along its axis, to the sky.
pub(super) fn rays(random: &mut Random, eye: Vec3, light: &Emitter, count: usize) -> Vec<Ray> {
    let towards = match light {
        Emitter::Point(point) => point.position() - eye,
        Emitter::Directional(sun) => -sun.direction(),
    };
    let new = |_| {
        let direction = match random.below(4) {
            0 => {
                let beside = random.log_uniform(1e-9, 1.0) as f32;
                towards + towards.length() * vector(random, beside)
            }
            1 => {
                let sign = if random.below(2) == 0 { 1.0 } else { -1.0 };
                let axis = [Vec3::X, Vec3::Y, Vec3::Z, towards][random.below(4) as usize];
                sign * axis
            }
            _ => vector(random, 1.0),
        };
        let length = match random.below(4) {
            0 => f32::INFINITY,
            _ => random.between(0.0, 30.0),
        };
        Ray::new(eye, direction.normalize_or(Vec3::X), length).unwrap()
    };
    (0..count).map(new).collect()
}

pub(super) fn fog() -> Medium {
    Medium::new(Vec3::splat(0.3), Vec3::ZERO, PhaseFunction::Isotropic).unwrap()
}

pub(super) type Case = (
    Random,
    Geometry,
    Emitter,
    Vec3,
    ShadowMap<Host>,
    ShadowVolumes<Host>,
);

/// A case with its map, of so many texels per side, and its volumes.
pub(super) fn case(number: u32, size: u32) -> Case {
    let mut random = Random::new(1000 + u64::from(number));
    let count = [3, 40, 200][number as usize % 3];
    let geometry = casters(&mut random, count);
    let (light, eye) = light_and_eye(&mut random, number);
    let cpu = Cpu::new();
    let triangles = Casters::upload(&cpu, &geometry).unwrap();
    let map = cpu.shadow_map(&triangles, &light, size).unwrap();
    let volumes = ShadowVolumes::new(&cpu, &geometry, &light, size).unwrap();
    (random, geometry, light, eye, map, volumes)
}

/// What a ray may be off by, as a distance: its positions are rounded.
#[cfg(feature = "trace")]
fn rounding(ray: &Ray, x: f32) -> f32 {
    8.0 * f32::EPSILON * (ray.origin().abs().max_element() + x.abs() + 10.0)
}

#[cfg(feature = "trace")]
#[test]
fn no_shadow_of_the_map_and_none_of_the_triangles_is_outside_of_the_volumes() {
    no_shadow_is_outside(1200, |_, _, volumes| volumes);
}

/// Of volumes that are made of those of the CPU, or in place of them.
#[cfg(feature = "trace")]
fn no_shadow_is_outside(
    rays_of_a_case: usize,
    made: impl Fn(&Geometry, &Emitter, ShadowVolumes<Host>) -> ShadowVolumes<Host>,
) {
    use crate::Interval;
    use crate::scene::trace::Tracer;
    use crate::visibility::Exact;

    // As many as are asked for, for longer hunts.
    let bounds = Bounds::new(Vec3::splat(-3.0), Vec3::new(2.0, 3.0, 4.0)).unwrap();
    let media = [fog(), fog().within(bounds)];
    let asked_for = std::env::var("PROPTEST_CASES").ok();
    let rays_of_a_case = asked_for.map_or(rays_of_a_case, |number| number.parse().unwrap());
    let (mut asked, mut dark, mut lit_rays, mut short) = (0, 0, 0, 0);
    for number in 0..96 {
        let (mut random, geometry, light, eye, map, volumes) = case(number, MAP - number % 2);
        let volumes = made(&geometry, &light, volumes);
        let tracer = Tracer::new(&geometry);
        let exact = Exact::new(&tracer);
        for ray in rays(&mut random, eye, &light, rays_of_a_case) {
            // Lights and eyes are inside of the fog, and outside of a box of it.
            let fog = &media[random.below(4) as usize / 3];
            let Some(path) = LightPath::new(&ray, &light, fog) else {
                continue;
            };
            let whole = whole(&path);
            let shortest = [0.0, 0.01, 1.0][random.below(3) as usize];
            let line = Line::new(&ray, map.faces()[0].origin);
            let span = volumes.span(&line, whole, shortest, &mut 0);
            asked += 1;
            lit_rays += usize::from(span.is_none());
            short += usize::from(span.is_some_and(|s| s.length() < 0.5 * whole.length()));
            let is_outside = |x: f32| !span.is_some_and(|s| s.start <= x && x <= s.end);
            for _ in 0..20 {
                let x = whole.start + random.unit() * (whole.end - whole.start);
                let is_lit = map.is_lit(ray.at(x));
                dark += usize::from(!is_lit);
                assert!(
                    is_lit || !is_outside(x),
                    "{number}: {x} of {ray:?}, {span:?}"
                );
            }
            let mut lit = Vec::new();
            exact.lit_intervals(&path, &mut lit);
            let mut from = whole.start;
            let end = [whole.end, f32::INFINITY].map(|x| Interval::new(x, x));
            for part in lit.iter().map(|lit| lit.interval).chain(end) {
                let to = part.start.min(whole.end);
                let inward = rounding(&ray, to);
                if from + inward < to - inward {
                    let ends = [from + inward, to - inward];
                    assert!(
                        !ends.into_iter().any(is_outside),
                        "{number}: dark from {from} to {to} of {ray:?}, {span:?}"
                    );
                }
                from = part.end;
            }
        }
    }
    // There is something to be wrong about.
    let all = 96 * rays_of_a_case;
    assert!(2 * asked > all && 40 * dark > asked, "{asked} {dark}");
    assert!(
        20 * lit_rays > asked && 20 * short > asked,
        "{lit_rays} {short}"
    );
}

#[test]
fn no_lit_sample_of_the_map_is_outside_of_the_volumes_of_light() {
    let asked_for = std::env::var("PROPTEST_CASES").ok();
    let rays_of_a_case = asked_for.map_or(1200, |number| number.parse().unwrap());
    let fog = fog();
    let (mut asked, mut lit, mut dark_rays, mut short) = (0, 0, 0, 0);
    for number in 0..96 {
        let (mut random, _, light, eye, mut map, _) = case(number, MAP - number % 2);
        let cpu = Cpu::new();
        if number % 3 == 0 {
            // Lights and eyes inside and outside.
            let casters = Casters::upload(&cpu, &room()).unwrap();
            map = cpu.shadow_map(&casters, &light, MAP).unwrap();
        }
        let volumes = cpu.lit_volumes(&map).unwrap();
        for ray in rays(&mut random, eye, &light, rays_of_a_case) {
            let Some(path) = LightPath::new(&ray, &light, &fog) else {
                continue;
            };
            let whole = whole(&path);
            let shortest = [0.0, 0.01, 1.0][random.below(3) as usize];
            let line = Line::new(&ray, map.faces()[0].origin);
            let span = volumes.search().span(&line, whole, shortest, &mut 0);
            asked += 1;
            dark_rays += usize::from(span.is_none());
            short += usize::from(span.is_some_and(|s| s.length() < 0.9 * whole.length()));
            for _ in 0..20 {
                let x = whole.start + random.unit() * (whole.end - whole.start);
                let is_lit = map.is_lit(ray.at(x));
                lit += usize::from(is_lit);
                let is_inside = span.is_some_and(|s| s.start <= x && x <= s.end);
                assert!(!is_lit || is_inside, "{number}: {x} of {ray:?}, {span:?}");
            }
        }
    }
    // There is something to be wrong about.
    assert!(asked > 30_000 && lit > asked, "{asked} {lit}");
    assert!(
        200 * dark_rays > asked && 40 * short > asked,
        "{dark_rays} {short}"
    );
}

/// Walls with a window, 6 m a side.
pub(super) fn room() -> Geometry {
    let wall = |corners: [Vec3; 4], positions: &mut Vec<Vec3>| {
        let [a, b, c, d] = corners;
        positions.extend([a, b, c, a, c, d]);
    };
    let mut positions = Vec::new();
    let corner = |x: f32, y: f32, z: f32| 3.0 * Vec3::new(x, y, z);
    for (axis, other) in [(0, 1), (1, 2), (2, 0)] {
        for side in [-1.0, 1.0] {
            let at = |u: f32, v: f32| {
                let mut at = [side; 3];
                (at[axis], at[other]) = (u, v);
                Vec3::from(at) * 3.0
            };
            let window = at(0.0, 0.0) == corner(1.0, 0.0, 0.0);
            let all = [-1.0, -0.25, 0.25, 1.0];
            let parts = all
                .windows(2)
                .flat_map(|u| all.windows(2).map(move |v| (u, v)));
            for (u, v) in parts {
                if window && u[0] == -0.25 && v[0] == -0.25 {
                    continue;
                }
                let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| at(u[i], v[j]));
                wall(corners, &mut positions);
            }
        }
    }
    let count = positions.len() as u32 / 3;
    let mesh = Mesh {
        positions,
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    };
    Geometry::new(&Scene::from(mesh)).unwrap()
}

#[test]
fn in_a_dark_room_the_map_is_asked_in_the_shaft_of_the_window_alone() {
    let cpu = Cpu::new();
    let geometry = room();
    let sun = Emitter::directional(Vec3::new(-1.0, -0.5, 0.1), Vec3::ONE).unwrap();
    let casters = Casters::upload(&cpu, &geometry).unwrap();
    let map = cpu.shadow_map(&casters, &sun, 500).unwrap();
    let shadows = Arc::new(ShadowVolumes::new(&cpu, &geometry, &sun, 500).unwrap());
    let light = Arc::new(cpu.lit_volumes(&map).unwrap());
    let mut random = Random::new(3);
    let eye = Vec3::new(-2.0, 1.0, 2.0);
    let rays = rays(&mut random, eye, &sun, 2000);
    let fog = fog();
    let inside: Vec<Ray> = rays
        .into_iter()
        .filter_map(|ray| {
            let far = ray.direction().abs() / (Vec3::splat(3.0) - ray.direction().signum() * eye);
            Ray::new(eye, ray.direction(), 0.999 / far.max_element())
        })
        .collect();
    let [mut all, mut known] = [0, 0];
    for ray in &inside {
        let path = LightPath::new(ray, &sun, &fog).unwrap();
        let without = Hybrid::new(&map, Some(shadows.clone()), 64).unwrap();
        let without = without.spread_over(Spread::Ray);
        let with = Hybrid::new(&map, Some(shadows.clone()), 64).unwrap();
        let with = with.with_lit_volumes(light.clone()).unwrap();
        let alone = Hybrid::new(&map, None, 64).unwrap();
        let alone = alone.with_lit_volumes(light.clone()).unwrap();
        all += without.asked(&path);
        known += with.spread_over(Spread::Ray).asked(&path);
        let [mut runs, mut expected] = [vec![], vec![]];
        alone
            .spread_over(Spread::Ray)
            .lit_intervals(&path, &mut runs);
        without.lit_intervals(&path, &mut expected);
        assert_eq!(runs, expected, "{ray:?}");
    }
    assert!(2 * known < all, "{known} of {all}");
    let choice = |volumes| {
        let steps = (64, Spread::Span);
        Choice::new(&shadows, volumes, &inside, &sun, &fog, steps).unwrap()
    };
    let (shadow, light) = (Some(&*shadows), Some(&*light));
    let of_shadow = choice(Volumes {
        shadow,
        light: None,
    });
    let of_light = choice(Volumes {
        shadow: None,
        light,
    });
    assert!(of_shadow.dark > 0.5 * of_shadow.asked, "{of_shadow:?}");
    assert!(of_light.is_worth_it(), "{of_light:?}");
    assert!(of_light.cost_at(&of_shadow) < of_shadow.cost_at(&of_shadow));
    // What is estimated without the map is not far from it.
    let estimated = choice(Volumes {
        shadow: None,
        light: Some(&LitVolumes::estimated(&shadows)),
    });
    let [cost, expected] = [estimated, of_light].map(|choice| choice.cost_at(&of_shadow));
    assert!(
        (cost - expected).abs() < 0.25 * expected,
        "{cost}, {expected}"
    );
}

/// To the last bit, which is what makes leaving out safe.
#[test]
fn known_steps_change_nothing() {
    let fog = fog();
    let [mut saved, mut dark] = [0; 2];
    for number in 0..96 {
        let (mut random, _, light, eye, mut map, mut volumes) = case(number, MAP);
        if number % 3 == 0 {
            let cpu = Cpu::new();
            let geometry = room();
            let casters = Casters::upload(&cpu, &geometry).unwrap();
            map = cpu.shadow_map(&casters, &light, MAP).unwrap();
            volumes = ShadowVolumes::new(&cpu, &geometry, &light, MAP).unwrap();
        }
        let volumes = Arc::new(volumes);
        let light_there = Arc::new(Cpu::new().lit_volumes(&map).unwrap());
        for ray in rays(&mut random, eye, &light, 200) {
            let Some(path) = LightPath::new(&ray, &light, &fog) else {
                continue;
            };
            for steps in [1, 3, 50, 400] {
                let all = Hybrid::new(&map, None, steps).unwrap();
                let known = Hybrid::new(&map, Some(volumes.clone()), steps).unwrap();
                let known = known.spread_over(Spread::Ray);
                let mut expected = Vec::new();
                all.lit_intervals(&path, &mut expected);
                saved += usize::from(known.asked(&path) < steps);
                let light = |hybrid: Hybrid<_, _>| hybrid.with_lit_volumes(light_there.clone());
                let of_light = light(Hybrid::new(&map, None, steps).unwrap()).unwrap();
                dark += usize::from(of_light.asked(&path) < steps);
                let both = Hybrid::new(&map, Some(volumes.clone()), steps).unwrap();
                let both = light(both).unwrap().spread_over(Spread::Ray);
                for hybrid in [known, of_light.spread_over(Spread::Ray), both] {
                    let mut found = Vec::new();
                    hybrid.lit_intervals(&path, &mut found);
                    assert_eq!(found, expected, "{number}, {steps} steps: {ray:?}");
                }
            }
        }
    }
    assert!(saved > 5000 && dark > 500, "{saved} {dark}");
}

#[test]
fn with_more_steps_runs_become_those_of_the_map() {
    let fog = fog();
    let mut sums = [[0.0_f64; 3]; 3];
    for number in 0..48 {
        let (mut random, _, light, eye, map, volumes) = case(number, MAP);
        let volumes = Arc::new(volumes);
        let of_light = Arc::new(Cpu::new().lit_volumes(&map).unwrap());
        let runs = MapRuns::walked(&map);
        for ray in rays(&mut random, eye, &light, 20) {
            let Some(path) = LightPath::new(&ray, &light, &fog) else {
                continue;
            };
            let whole = whole(&path);
            let length = |lit: &[LitInterval], [a, b]: [f32; 2]| -> f64 {
                let parts = lit.iter().map(|lit| lit.interval);
                let inside = parts.map(|p| f64::from(p.end.min(b)) - f64::from(p.start.max(a)));
                inside.map(|length| length.max(0.0)).sum()
            };
            let mut exact = Vec::new();
            runs.lit_intervals(&path, &mut exact);
            let spreads = [Spread::Ray, Spread::Span, Spread::Span];
            let spreads = spreads.into_iter().zip(&mut sums);
            let all = spreads.enumerate().flat_map(|(i, (spread, sums))| {
                let sums = sums.iter_mut().zip([16, 256, 16384]);
                sums.map(move |(sum, steps)| (i == 2, spread, steps, sum))
            });
            for (has_light, spread, steps, sum) in all {
                let mut lit = Vec::new();
                let mut hybrid = Hybrid::new(&map, Some(volumes.clone()), steps).unwrap();
                if has_light {
                    hybrid = hybrid.with_lit_volumes(of_light.clone()).unwrap();
                }
                hybrid.spread_over(spread).lit_intervals(&path, &mut lit);
                // In each tenth of the ray by itself.
                for tenth in 0..10 {
                    let at = |i: u32| whole.start + 0.1 * i as f32 * (whole.end - whole.start);
                    let part = [at(tenth), at(tenth + 1)];
                    let off = (length(&lit, part) - length(&exact, part)).abs();
                    *sum += off / f64::from(whole.end - whole.start);
                }
            }
        }
    }
    // First order in the length of a step.
    let means = sums.map(|sums| sums.map(|sum| sum / (48.0 * 20.0)));
    for mean in means {
        assert!(mean[1] < 0.15 * mean[0], "{means:?}");
        assert!(mean[2] < 0.05 * mean[1], "{means:?}");
        assert!(mean[2] < 1e-4, "{means:?}");
    }
    // Steps of a span are shorter.
    assert!(means[1][1] < 0.7 * means[0][1], "{means:?}");
}

/// A step of a ray to the sky is longer than the ball and its shadow.
#[test]
fn a_short_span_has_all_of_the_steps() {
    let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let plate = Mesh {
        positions: vec![corner(-1.0, 0.0), corner(1.0, 0.0), corner(0.0, 2.0)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let geometry = Geometry::new(&Scene::from(plate)).unwrap();
    let sun = Emitter::directional(Vec3::NEG_Z, Vec3::ONE).unwrap();
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &geometry).unwrap();
    let map = cpu.shadow_map(&casters, &sun, 1024).unwrap();
    let volumes = Arc::new(ShadowVolumes::new(&cpu, &geometry, &sun, 1024).unwrap());
    let fog = Medium::new(Vec3::splat(0.01), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let ray = Ray::new(Vec3::new(-50.0, 0.5, -1.0), Vec3::X, f32::INFINITY).unwrap();
    let path = LightPath::new(&ray, &sun, &fog).unwrap();
    let runs = |spread| {
        let hybrid = Hybrid::new(&map, Some(volumes.clone()), 16).unwrap();
        let mut lit = Vec::new();
        hybrid.spread_over(spread).lit_intervals(&path, &mut lit);
        lit
    };
    // Of 62 m each.
    assert_eq!(runs(Spread::Ray).len(), 1);
    let lit = runs(Spread::Span);
    let ends = lit
        .iter()
        .flat_map(|lit| [lit.interval.start, lit.interval.end]);
    let expected = [0.0, 49.25, 50.75, 1000.0];
    assert_eq!(lit.len(), 2, "{lit:?}");
    for (end, expected) in ends.zip(expected) {
        assert!((end - expected).abs() < 0.05, "{lit:?}");
    }
}

#[test]
fn boxes_of_fog_and_eyes_anywhere_have_finite_light_that_converges() {
    use crate::airlight::EquiAngular;
    use crate::{Gather, LitRays};

    let bounds = Bounds::new(Vec3::splat(-3.0), Vec3::new(2.0, 3.0, 4.0)).unwrap();
    let fog = fog().within(bounds);
    let cpu = Cpu::new();
    let quadrature = EquiAngular::new(16).unwrap();
    for number in 0..96 {
        let (mut random, _, light, eye, map, volumes) = case(number, MAP);
        let volumes = Arc::new(volumes);
        let rays = rays(&mut random, eye, &light, 100);
        let lit = LitRays::new(&rays, &light, &fog).joined();
        let sum = |radiance: &[[f32; 4]]| radiance.iter().map(|r| f64::from(r[0])).sum::<f64>();
        let mut expected = vec![[0.0; 4]; rays.len()];
        cpu.gather(&lit, &MapRuns::walked(&map), &quadrature, &mut expected)
            .unwrap();
        let [few, many] = [16, 4096].map(|steps| {
            let hybrid = Hybrid::new(&map, Some(volumes.clone()), steps).unwrap();
            let spreads = [Spread::Ray, Spread::Span];
            let hybrid = hybrid.spread_over(spreads[number as usize % 2]);
            let mut radiance = vec![[0.0; 4]; rays.len()];
            cpu.gather(&lit, &hybrid, &quadrature, &mut radiance)
                .unwrap();
            assert!(radiance.iter().flatten().all(|light| light.is_finite()));
            let pairs = radiance.iter().zip(&expected);
            pairs
                .map(|(a, b)| f64::from((a[0] - b[0]).abs()))
                .sum::<f64>()
        });
        let all = sum(&expected);
        assert!(
            many <= 0.01 * all + 0.1 * few,
            "{number}: {few} {many} of {all}"
        );
    }
}

#[test]
fn volumes_go_with_a_map_of_their_size() {
    let (.., geometry, light, _, map, _) = case(0, MAP);
    let cpu = Cpu::new();
    let others = ShadowVolumes::new(&cpu, &geometry, &light, 2 * MAP).unwrap();
    assert_eq!(others.resolution(), 2 * MAP);
    assert!(Hybrid::new(&map, Some(Arc::new(others)), 8).is_err());
    for resolution in [1, 7, 8, 9, 255, 3000] {
        let volumes = ShadowVolumes::new(&cpu, &geometry, &light, resolution).unwrap();
        assert!(volumes.cell() * 256 >= resolution && volumes.cell() >= 8);
        assert_eq!(volumes.bytes(), 4 * volumes.near().len() as u64);
    }
}

/// Casters of every size, and each of the lights.
#[test]
fn volumes_of_casters_are_those_of_their_geometry() {
    let cpu = Cpu::new();
    for number in 0..24 {
        let (_, geometry, light, .., volumes) = case(number, MAP);
        let casters = Casters::upload(&cpu, &geometry).unwrap();
        let same = cpu.shadow_volumes(&casters, &light, MAP).unwrap();
        assert_eq!(same.near(), volumes.near());
    }
}

/// Points of triangles are in the cells that they come within a texel of.
fn points_are_in_the_cells_around_them(
    random: &mut Random,
    geometry: &Geometry,
    volumes: &ShadowVolumes<Host>,
) {
    let cells = &volumes.cells;
    let size = f64::from(cells.cell);
    for triangle in geometry.triangles() {
        let [a, b, c] = triangle.map(|corner| (corner - cells.origin).as_dvec3());
        for _ in 0..20 {
            let [mut u, mut v] = [random.unit_f64(), random.unit_f64()];
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let point = a + u * (b - a) + v * (c - a);
            for (index, picture) in cells.pictures.iter().enumerate() {
                let at = picture.of_point(point);
                if at.z <= 0.0 {
                    continue;
                }
                let depth = match picture.is_central() {
                    true => point.length(),
                    false => point.dot(picture.forward()),
                };
                for [x, y] in [
                    [0.0, 0.0],
                    [0.99, 0.99],
                    [0.99, -0.99],
                    [-0.99, 0.99],
                    [-0.99; 2],
                ] {
                    let cell = [at.x / at.z + x, at.y / at.z + y].map(|texel| texel / size);
                    if !cell
                        .iter()
                        .all(|t| (0.0..f64::from(cells.side)).contains(t))
                    {
                        continue;
                    }
                    let near = volumes.near[cells.index(index, 0, cell.map(|t| t as u32))];
                    assert!(
                        f64::from(near) <= depth,
                        "{near} {depth} in {cell:?} of {index}, {} texels",
                        cells.resolution
                    );
                }
            }
        }
    }
}

#[test]
fn points_of_triangles_are_in_the_cells_around_them() {
    let cpu = Cpu::new();
    for number in 0..48 {
        let resolution = [1, 7, 125, 300, 1024][number as usize % 5];
        let (mut random, mut geometry, light, ..) = case(number, MAP);
        if number % 4 == 3 {
            geometry = room();
        }
        let volumes = ShadowVolumes::new(&cpu, &geometry, &light, resolution).unwrap();
        points_are_in_the_cells_around_them(&mut random, &geometry, &volumes);
    }
}

#[cfg(feature = "wgpu")]
mod on_gpu {
    use gpu_backend::{Download, assert_same_layout, testing};

    use super::super::cells::NOTHING;
    use super::super::volumes_gpu::{NEAR, NearRecord};
    use super::*;

    #[test]
    fn the_shader_that_makes_volumes_sees_cells_as_they_are() {
        let shader = testing::Shader::new(&NEAR).unwrap();
        assert_same_layout!(
            shader,
            "Near",
            NearRecord {
                pictures,
                cell,
                side,
                triangles,
                level,
                border,
                factor,
                less,
                most
            }
        );
    }

    /// On the GPU the volumes of the casters of a case.
    fn made(
        gpu: &(impl BuildShadowVolumes + Download),
        geometry: &Geometry,
        light: &Emitter,
        expected: &ShadowVolumes<Host>,
    ) -> ShadowVolumes<Host> {
        let casters = Casters::upload(gpu, geometry).unwrap();
        let there = gpu
            .shadow_volumes(&casters, light, expected.resolution())
            .unwrap();
        ShadowVolumes {
            cells: expected.cells.clone(),
            near: gpu.download(there.near()).unwrap(),
        }
    }

    #[cfg(feature = "trace")]
    #[test]
    fn no_shadow_is_outside_of_volumes_made_on_a_gpu() {
        let Some(gpu) = testing::gpu() else { return };
        no_shadow_is_outside(300, |geometry, light, volumes| {
            made(&gpu, geometry, light, &volumes)
        });
    }

    /// Casters around eyes and lights; walls that are in all pictures of a cube, and behind
    /// some; maps from a texel to many.
    #[test]
    fn volumes_of_a_gpu_are_little_larger_than_those_of_the_cpu() {
        let Some(gpu) = testing::gpu() else { return };
        let cpu = Cpu::new();
        let ([mut all, mut more, mut fewer], mut nearer) = ([0_u64; 3], 0.0);
        for number in 0..48 {
            let resolution = [1, 7, 125, 300, 1024][number as usize % 5];
            let (mut random, mut geometry, light, ..) = case(number, MAP);
            if number % 4 == 3 {
                geometry = room();
            }
            let expected = ShadowVolumes::new(&cpu, &geometry, &light, resolution).unwrap();
            let found = made(&gpu, &geometry, &light, &expected);
            points_are_in_the_cells_around_them(&mut random, &geometry, &found);
            let finest = expected.cells.finest();
            let mut again = found.near()[..finest].to_vec();
            again.resize(expected.cells.len(), 0.0);
            expected.cells.fill(&mut again, f32::min);
            assert_eq!(&again, found.near(), "{number}: levels");
            for (found, expected) in found.near()[..finest].iter().zip(expected.near()) {
                let [is_there, was_there] = [found, expected].map(|near| *near < 0.5 * NOTHING);
                all += u64::from(was_there);
                more += u64::from(is_there && !was_there);
                fewer += u64::from(!is_there && was_there);
                if is_there && was_there {
                    // In parallel light some are at 0 m.
                    let by = (expected - found).max(0.0) / expected.abs().max(0.1);
                    nearer += f64::from(by);
                }
            }
        }
        let nearer = nearer / all as f64;
        println!("{all} cells are nearer by {nearer:.5}; {more} are more and {fewer} fewer");
        assert!(all > 10_000);
        assert!(nearer < 1e-3 && 200 * more < all, "{nearer} {more} {all}");
    }
}

//! Grids against brute force over the index map they come from.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

mod common;

use bitvec::order::Lsb0;
use bitvec::slice::BitSlice;
use epipolar::Resolution;
use glam::Vec3;
use gpu_backend::{Cpu, Host};
use proptest::prelude::*;
use voxel_shadow::{
    BuildGrid, Error, Grid, Holes, IndexMap, Rectify, RectifyMasked, RectifyTriangles,
};

use common::{balls, build, camera, lattice, lights};

fn extruded(cpu: &Cpu, map: &IndexMap<Host>) -> Grid<Host> {
    let mut grid = Grid::new(cpu, map.resolution()).unwrap();
    cpu.voxelise(map, &mut grid).unwrap();
    cpu.extrude(&mut grid).unwrap();
    // What a grid held before is forgotten.
    let words = vec![0x5555_5555; map.resolution().words()];
    let mut at_once = Grid::from_words(map.resolution(), words).unwrap();
    cpu.build(map, &mut at_once).unwrap();
    assert_eq!(grid.words(), at_once.words(), "in one pass");
    grid
}

/// A voxel is in shadow exactly if its light ray is blocked at or before it.
fn is_brute_force(map: &IndexMap<Host>, grid: &Grid<Host>) {
    let resolution = map.resolution();
    let bits = resolution.bits() as usize;
    for alpha in 0..resolution.alpha() {
        for theta in 0..resolution.theta() {
            let texel: &BitSlice<u32, Lsb0> = grid.bits(alpha, theta);
            assert_eq!(texel.len(), bits);
            for (bit, found) in texel.iter().by_vals().enumerate() {
                let index = map.indices()[theta as usize * bits + bit];
                assert_eq!(found, index <= alpha, "({alpha}, {theta}, {bit})");
            }
        }
    }
}

#[test]
fn every_voxel_of_every_map_of_two_rays_is_brute_force() {
    let cpu = Cpu::single_threaded();
    for alpha in 1..=6 {
        let resolution = Resolution::new(alpha, 1, 32).unwrap();
        // All pairs of entries at the two ends of a word.
        for a in 0..=alpha {
            for b in 0..=alpha + 1 {
                let mut indices = vec![alpha; 32];
                indices[0] = a;
                indices[31] = b;
                let map = IndexMap::from_indices(resolution, indices).unwrap();
                is_brute_force(&map, &extruded(&cpu, &map));
            }
        }
    }
}

/// Maps of any size, with entries at and beyond both ends.
fn map() -> impl Strategy<Value = IndexMap<Host>> {
    (1..40_u32, 1..40_u32, 1..5_u32).prop_flat_map(|(alpha, theta, words)| {
        let resolution = Resolution::new(alpha, theta, 32 * words).unwrap();
        let entry = prop_oneof![
            Just(0),
            Just(alpha - 1),
            Just(alpha),
            Just(u32::MAX),
            0..alpha
        ];
        prop::collection::vec(entry, resolution.light_rays())
            .prop_map(move |indices| IndexMap::from_indices(resolution, indices).unwrap())
    })
}

proptest! {
    #![proptest_config(reference::property::cases(200))]

    #[test]
    fn every_voxel_is_brute_force_over_the_index_map(map in map()) {
        let one = extruded(&Cpu::single_threaded(), &map);
        is_brute_force(&map, &one);
        // And the same on any number of threads.
        let many = extruded(&Cpu::new(), &map);
        prop_assert_eq!(one.words(), many.words());
    }

    #[test]
    fn extruding_twice_changes_nothing_and_shadow_only_grows_away_from_the_light(map in map()) {
        let cpu = Cpu::new();
        let mut grid = extruded(&cpu, &map);
        let once = grid.words().clone();
        let row = map.resolution().words_per_row();
        for (word, next) in once.iter().zip(&once[row..]) {
            prop_assert_eq!(word & !next, 0);
        }
        cpu.extrude(&mut grid).unwrap();
        prop_assert_eq!(grid.words(), &once);
    }

    #[test]
    fn another_blocker_never_lights_a_voxel(map in map(), seed: u32) {
        let cpu = Cpu::new();
        let without = extruded(&cpu, &map);
        let nearer = map.indices().iter().zip(0_u32..).map(|(&index, i)| {
            let random = (i ^ seed).wrapping_mul(2_654_435_761) >> 8;
            index.min(random % (map.resolution().alpha() + 3))
        });
        let map = IndexMap::from_indices(map.resolution(), nearer.collect()).unwrap();
        let with = extruded(&cpu, &map);
        for (before, after) in without.words().iter().zip(with.words()) {
            prop_assert_eq!(before & !after, 0);
        }
    }
}

#[test]
fn grids_wider_than_a_block_of_columns_are_brute_force() {
    let resolution = Resolution::new(9, 150, 1024).unwrap();
    let indices = (0..resolution.light_rays() as u32)
        .map(|i| i.wrapping_mul(2_654_435_761) >> 28)
        .collect();
    let map = IndexMap::from_indices(resolution, indices).unwrap();
    is_brute_force(&map, &extruded(&Cpu::new(), &map));
}

#[test]
fn voxelising_forgets_what_a_grid_held_before() {
    let resolution = Resolution::new(4, 3, 32).unwrap();
    let cpu = Cpu::new();
    let mut grid = Grid::from_words(resolution, vec![u32::MAX; resolution.words()]).unwrap();
    let map = IndexMap::from_indices(resolution, vec![4; resolution.light_rays()]).unwrap();
    cpu.voxelise(&map, &mut grid).unwrap();
    assert!(grid.words().iter().all(|word| *word == 0));
}

#[test]
fn sizes_that_do_not_fit_are_errors() {
    let resolution = Resolution::new(4, 3, 32).unwrap();
    let other = Resolution::new(4, 3, 64).unwrap();
    let cpu = Cpu::new();
    let map = IndexMap::new(&cpu, other).unwrap();
    let mut grid = Grid::new(&cpu, resolution).unwrap();
    for error in [cpu.voxelise(&map, &mut grid), cpu.build(&map, &mut grid)] {
        let error = error.unwrap_err();
        assert!(matches!(error, Error::Resolution { actual, .. } if actual == other));
    }
    assert!(IndexMap::<Host>::from_indices(resolution, vec![0; 7]).is_err());
    assert!(Grid::<Host>::from_words(resolution, vec![0; 7]).is_err());
    let lattice = lattice(lights()[0], &camera(0.1, 20.0), [4, 4, 32]);
    let mut map = IndexMap::new(&cpu, resolution).unwrap();
    let nothing = |_: &epipolar::LightRay| f32::INFINITY;
    assert!(cpu.rectify(&lattice, &nothing, &mut map).is_err());
    assert!(
        cpu.rectify_triangles(&lattice, &Vec::new(), &mut map)
            .is_err()
    );
}

#[test]
fn blockers_of_any_distance_give_legal_indices() {
    let cpu = Cpu::new();
    for light in lights() {
        let lattice = lattice(light, &camera(0.0, 20.0), [16, 16, 32]);
        let mut map = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        for distance in [
            0.0,
            -0.0,
            1e-40,
            1e-20,
            1.0,
            1e18,
            1e37,
            f32::MAX,
            f32::INFINITY,
            f32::NAN,
            -1.0,
            -1e30,
            f32::NEG_INFINITY,
        ] {
            let blocker = |_: &epipolar::LightRay| distance;
            cpu.rectify(&lattice, &blocker, &mut map).unwrap();
            assert!(map.indices().iter().all(|index| *index <= 16));
            if !(distance.abs() < f32::MAX) {
                assert!(map.indices().iter().all(|index| *index == 16));
            }
            if distance == 0.0 && light.position().is_some() {
                // At the light: everything behind it is dark.
                assert!(map.indices().iter().all(|index| *index == 0));
            }
        }
    }
}

/// Triangles of spheres.
fn triangles() -> Vec<[Vec3; 3]> {
    let (rings, sides) = (12, 16);
    let mut triangles = Vec::new();
    for ball in balls() {
        let at = |ring: u32, side: u32| {
            let (polar, around) = (
                std::f32::consts::PI * ring as f32 / rings as f32,
                std::f32::consts::TAU * (side % sides) as f32 / sides as f32,
            );
            let (sin, cos) = polar.sin_cos();
            ball.centre + ball.radius * Vec3::new(sin * around.cos(), cos, sin * around.sin())
        };
        for ring in 0..rings {
            for side in 0..sides {
                let [a, b, c, d] = [
                    at(ring, side),
                    at(ring, side + 1),
                    at(ring + 1, side + 1),
                    at(ring + 1, side),
                ];
                triangles.push([a, b, c]);
                triangles.push([a, c, d]);
            }
        }
    }
    triangles
}

/// The first triangle on a light ray, in f64 and by another formula.
fn traced(ray: &epipolar::LightRay, triangles: &[[Vec3; 3]], parallel: bool) -> f32 {
    let (origin, direction) = (
        Vec3::from(ray.origin).as_dvec3(),
        Vec3::from(ray.direction).as_dvec3(),
    );
    let mut nearest = f64::INFINITY;
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| v.as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let p = direction.cross(e2);
        let determinant = e1.dot(p);
        if determinant == 0.0 {
            continue;
        }
        let s = origin - a;
        let u = s.dot(p) / determinant;
        let q = s.cross(e1);
        let v = direction.dot(q) / determinant;
        let t = e2.dot(q) / determinant;
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (parallel || t >= 0.0) {
            nearest = nearest.min(t);
        }
    }
    nearest as f32
}

/// Share of the light rays whose index may differ between two ways to
/// intersect: silhouettes and borders of voxels. Distances are off by
/// a few ULP of 10 m, 1e-5 of a voxel of 64 along α; a ray lies within 1e-6 m of
/// one of some hundred silhouette edges of 0.3 m, in 100 m² of its view, with a
/// chance of 1e-6. Together below 1e-4.
const OTHER_INDEX: f64 = 1e-4;

#[test]
fn triangles_are_where_a_ray_tracer_finds_them() {
    let cpu = Cpu::new();
    let triangles = triangles();
    let (mut all, mut different) = (0_u32, 0_u32);
    for light in lights() {
        let lattice = lattice(light, &camera(0.1, 20.0), [64, 64, 64]);
        let parallel = light.position().is_none();
        let mut expected = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        let tracer = |ray: &epipolar::LightRay| traced(ray, &triangles, parallel);
        cpu.rectify(&lattice, &tracer, &mut expected).unwrap();
        let mut found = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        cpu.rectify_triangles(&lattice, &triangles, &mut found)
            .unwrap();
        for (e, f) in expected.indices().iter().zip(found.indices()) {
            all += 1;
            different += u32::from(e != f);
        }
        // Nothing has a shadow of half a voxel where the light is at the eye.
        let is_blocked = found.indices().iter().any(|index| *index < 64);
        let is_apart = lattice.space().distance() > 0.01;
        assert_eq!(is_blocked, is_apart, "{light:?}");
        // And the threads do not matter.
        let mut single = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        Cpu::single_threaded()
            .rectify_triangles(&lattice, &triangles, &mut single)
            .unwrap();
        assert_eq!(found.indices(), single.indices());
    }
    assert!(
        f64::from(different) <= OTHER_INDEX * f64::from(all),
        "{different} of {all}"
    );
}

/// The corner where the coordinate of the third is less than a half, of every third
/// triangle.
struct Corners;

impl Holes for Corners {
    fn is_hole(&self, triangle: usize, _: f32, v: f32) -> bool {
        triangle.is_multiple_of(3) && v < 0.5
    }
}

#[test]
fn a_triangle_with_a_hole_is_what_is_left_of_it() {
    let cpu = Cpu::new();
    let whole = triangles();
    // Cut off along the line where the coordinate is a half.
    let left = |(number, [a, b, c]): (usize, &[Vec3; 3])| match number % 3 {
        0 => [0.5 * (*a + *c), 0.5 * (*b + *c), *c],
        _ => [*a, *b, *c],
    };
    let cut: Vec<_> = whole.iter().enumerate().map(left).collect();
    let (mut all, mut different) = (0_u32, 0_u32);
    for light in lights() {
        let lattice = lattice(light, &camera(0.1, 20.0), [64, 64, 64]);
        let mut expected = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        cpu.rectify_triangles(&lattice, &cut, &mut expected)
            .unwrap();
        let mut found = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        cpu.rectify_masked(&lattice, &whole, &Corners, &mut found)
            .unwrap();
        for (e, f) in expected.indices().iter().zip(found.indices()) {
            all += 1;
            different += u32::from(e != f);
        }
    }
    assert!(
        f64::from(different) <= OTHER_INDEX * f64::from(all),
        "{different} of {all}"
    );
}

#[test]
fn triangles_that_are_none_block_nothing() {
    let cpu = Cpu::new();
    let lattice = lattice(lights()[0], &camera(0.1, 20.0), [16, 16, 32]);
    let mut map = IndexMap::new(&cpu, lattice.resolution()).unwrap();
    let line = [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X];
    let point = [Vec3::Y; 3];
    let light = Vec3::new(1.0, 3.0, -2.0);
    let bad = [
        line,
        point,
        [light; 3],
        [Vec3::NAN, Vec3::X, Vec3::Y],
        [Vec3::INFINITY, Vec3::X, Vec3::Y],
    ];
    cpu.rectify_triangles(&lattice, &bad.to_vec(), &mut map)
        .unwrap();
    assert!(map.indices().iter().all(|index| *index == 16));
    cpu.rectify_triangles(&lattice, &Vec::new(), &mut map)
        .unwrap();
    assert!(map.indices().iter().all(|index| *index == 16));
}

#[test]
fn closed_meshes_leave_no_hole() {
    // A ball around the light blocks every light ray, whichever edges they meet.
    let cpu = Cpu::new();
    let light = Vec3::new(0.3, 1.9, 1.0);
    let mesh: Vec<_> = triangles()
        .into_iter()
        .take(12 * 16 * 2)
        .map(|triangle| triangle.map(|v| v - balls()[0].centre + light))
        .collect();
    let light = epipolar::Light::point(light).unwrap();
    let lattice = lattice(light, &camera(0.1, 20.0), [512, 256, 256]);
    let mut map = IndexMap::new(&cpu, lattice.resolution()).unwrap();
    cpu.rectify_triangles(&lattice, &mesh, &mut map).unwrap();
    let holes = map.indices().iter().filter(|index| **index == 512).count();
    assert_eq!(holes, 0);
}

#[test]
fn what_a_scene_shadows_does_not_depend_on_threads() {
    for light in lights() {
        let lattice = lattice(light, &camera(0.1, 20.0), [32, 48, 64]);
        let (map, grid) = build(&lattice, &balls());
        let cpu = Cpu::single_threaded();
        let mut again = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        let parallel = light.position().is_none();
        cpu.rectify(&lattice, &common::first(&balls(), parallel), &mut again)
            .unwrap();
        assert_eq!(map.indices(), again.indices());
        assert_eq!(grid.words(), extruded(&cpu, &again).words());
    }
}

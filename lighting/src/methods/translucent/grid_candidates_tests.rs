//! Density grids that shaders walk through, against the truth and against the CPU.

use glam::{Affine3A, EulerRot, Mat3, Quat, Vec3};
use gpu_backend::gpu::{Gpu, GpuMemory, Queued};
use gpu_backend::{Host, testing};
use reference::random::Random;
use transmittance::{Curve, Evaluate, Stream};

use super::candidates_tests::{agree, agree_under, errors, floor, lamp, lights, puffs, strand};
use super::{Casters, TransmittanceMap};
use crate::Emitter;
use crate::scene::procedural::{Embedded, smoke_grid};
use crate::scene::{
    Bounds, DensityGrid, Geometry, Interpolation, Light, Profile, Scene, Translucent,
};

fn sun(direction: Vec3) -> Emitter {
    Emitter::directional(direction, Vec3::ONE).expect("a light")
}

/// The curves of a map that shaders make.
fn made(
    gpu: &Gpu<Queued>,
    casters: &[Translucent],
    emitter: &Emitter,
    resolution: u32,
) -> transmittance::TransmittanceMap<Host, Curve<8>> {
    let (casters, clear) = (Casters::new(casters, None), Stream::<8>::new());
    let map = TransmittanceMap::<GpuMemory, Curve<8>>::build_in_shaders(
        gpu, &casters, emitter, resolution, &clear,
    );
    let map = map.expect("a map").expect("all of it in shaders");
    map.curves().download(gpu).expect("what was made")
}

/// Densities from 0 to 1, a third of them 0.
fn grid(
    random: &mut Random,
    [min, max]: [Vec3; 2],
    resolution: [u32; 3],
    scale: f32,
    interpolation: Interpolation,
) -> DensityGrid {
    let count = resolution.iter().product();
    let mut density = || (1.5 * random.unit() - 0.5).max(0.0);
    let density = (0..count).map(|_: u32| density()).collect();
    let bounds = Bounds::new(min, max).expect("a box");
    DensityGrid::new(bounds, resolution, density, scale, interpolation).expect("a grid")
}

/// Grids of every kind that overlap each other: turned, scaled, sheared and mirrored, of one
/// cell, flat, longer than wide.
fn grids(seed: u64) -> Vec<DensityGrid> {
    let mut random = Random::new(seed);
    let kinds = [
        ([1, 1, 1], Interpolation::Constant),
        ([1, 1, 1], Interpolation::Linear),
        ([7, 6, 5], Interpolation::Constant),
        ([6, 9, 4], Interpolation::Linear),
        ([1, 8, 5], Interpolation::Linear),
        ([19, 1, 2], Interpolation::Constant),
    ];
    let mut all = Vec::new();
    for (resolution, interpolation) in kinds {
        let low = Vec3::from_array([0; 3].map(|_| random.between(-0.9, -0.1)));
        let size = Vec3::from_array([0; 3].map(|_| random.between(0.3, 1.4)));
        let box_of = [low, low + size];
        let grid = grid(&mut random, box_of, resolution, 1.2, interpolation);
        let [a, b, c] = [0; 3].map(|_| random.between(-3.0, 3.0));
        let turn = Mat3::from_quat(Quat::from_euler(EulerRot::XYZ, a, b, c));
        let shear = Mat3::from_cols(
            Vec3::new(random.between(0.6, 1.4), 0.2, 0.0),
            Vec3::new(0.0, random.between(0.6, 1.4), -0.3),
            Vec3::new(0.1, 0.0, -random.between(0.6, 1.4)),
        );
        let shift = Vec3::new(random.between(-0.4, 0.4), 0.3, random.between(-0.4, 0.4));
        let transform = Affine3A::from_mat3_translation(turn * shear, shift);
        all.push(grid.clone());
        all.push(grid.with_transform(transform).expect("not flat"));
    }
    all
}

#[test]
fn grids_are_met_as_on_the_cpu() {
    for grid in grids(1) {
        agree(&[grid.into()], None, 21);
    }
}

#[test]
fn overlapping_grids_among_strands_balls_and_triangles_are_met_as_on_the_cpu() {
    let mut all: Vec<Translucent> = grids(2).into_iter().map(Translucent::from).collect();
    let ends = [Vec3::new(-1.0, 0.2, -0.5), Vec3::new(0.3, 0.9, 0.4)];
    all.insert(3, strand(&ends, 0.1, 0.7));
    all.insert(7, puffs(Profile::Soft));
    agree(&all, Some(&floor()), 37);
}

#[test]
fn lights_in_a_grid_and_on_its_faces_and_corners_are_met_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let smoke = [smoke_grid(1, 9.0).expect("a grid").into()];
    let casters = Casters::new(&smoke, None);
    for emitter in [
        lamp(Vec3::new(0.47, 0.55, 0.52)),
        lamp(Vec3::new(0.31, 0.99, 0.07)),
        lamp(Vec3::new(0.37, 1.0, 0.61)),
        lamp(Vec3::ZERO),
        lamp(Vec3::new(1.7, 0.31, 0.43)),
        lamp(Vec3::new(0.4, 40.0, 300.0)),
        // Along the cells of an axis.
        sun(Vec3::NEG_Y),
        sun(Vec3::X),
    ] {
        agree_under(&gpu, &casters, &emitter, 19);
    }
}

#[test]
fn a_plume_on_48_by_64_by_48_samples_is_met_as_on_the_cpu() {
    let turn = Affine3A::from_scale_rotation_translation(
        Vec3::new(1.5, 2.0, 1.2),
        Quat::from_rotation_x(0.7),
        Vec3::new(-0.6, -0.5, 0.2),
    );
    let smoke = smoke_grid(1, 12.0).expect("a grid");
    let turned = smoke.clone().with_transform(turn).expect("not flat");
    agree(&[smoke.into()], None, 61);
    agree(&[turned.into()], Some(&floor()), 33);
}

#[test]
fn grids_that_colour_the_light_have_curves_for_each_colour() {
    let tinted = |grid: DensityGrid, tint| grid.with_tint(tint).expect("a tint").into();
    let mut all = grids(4).into_iter();
    let mut next = || all.next().expect("12 grids");
    let casters = [
        tinted(next(), Vec3::new(1.0, 0.5, 0.0)),
        next().into(),
        puffs(Profile::Constant),
        tinted(next(), Vec3::new(0.0, 2.0, 3.0)),
    ];
    assert_eq!(Casters::new(&casters, None).channels(), 3);
    agree(&casters, Some(&floor()), 24);
}

#[test]
fn smoke_of_a_million_optical_depths_per_voxel_is_opaque_from_where_it_begins() {
    let Some(gpu) = testing::gpu() else { return };
    let mut random = Random::new(5);
    for scale in [1e6, 1e15] {
        let box_of = [Vec3::splat(-0.5), Vec3::splat(0.5)];
        let grid = grid(&mut random, box_of, [6; 3], scale, Interpolation::Constant);
        let casters = [grid.into()];
        for emitter in [
            lights()[0].clone(),
            lights()[2].clone(),
            lamp(Vec3::splat(0.11)),
        ] {
            // A ray that is off by 1e-6 m enters a voxel up to a hundred times that further on,
            // where it runs along the face of it.
            let casters = Casters::new(&casters, None);
            let (_, beyond) = errors(&gpu, &casters, &emitter, 23, 1e-4);
            println!("{beyond:.1e} beyond the bounds");
            assert!(beyond <= 1e-4, "{beyond}");
        }
    }
}

#[test]
fn a_grid_without_density_changes_nothing() {
    let Some(gpu) = testing::gpu() else { return };
    let clear = |density, tint| {
        let bounds = Bounds::new(Vec3::splat(-0.2), Vec3::splat(0.2)).expect("a box");
        let grid = DensityGrid::new(bounds, [2; 3], density, 1.0, Interpolation::Linear);
        Translucent::from(grid.and_then(|grid| grid.with_tint(tint)).expect("a grid"))
    };
    let around = puffs(Profile::Soft);
    let with = [
        clear(vec![0.0; 8], Vec3::ONE),
        around.clone(),
        clear(vec![1.0; 8], Vec3::ZERO),
    ];
    let without = [around];
    for emitter in lights() {
        let [one, other] = [&with[..], &without].map(|casters| made(&gpu, casters, &emitter, 40));
        let [width, height] = one.extent();
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            for depth in (0..20).map(|i| 0.3 * i as f32) {
                let [a, b] = [&one, &other].map(|map| map.texel(x, y).evaluate(depth));
                assert_eq!(a, b, "{x} {y}");
            }
        }
    }
}

#[test]
fn a_constant_grid_is_met_as_its_box() {
    let Some(gpu) = testing::gpu() else { return };
    let box_of = |resolution: [u32; 3], interpolation| {
        let count = resolution.iter().product::<u32>() as usize;
        let bounds = Bounds::new(Vec3::new(-0.4, 0.1, -0.3), Vec3::new(0.5, 0.8, 0.6));
        let bounds = bounds.expect("a box");
        let grid = DensityGrid::new(bounds, resolution, vec![0.8; count], 2.0, interpolation);
        [Translucent::from(grid.expect("a grid"))]
    };
    let one = box_of([1; 3], Interpolation::Constant);
    let many = box_of([5, 9, 8], Interpolation::Linear);
    for emitter in lights() {
        let [one, many] = [&one, &many].map(|casters| made(&gpu, casters, &emitter, 32));
        let [width, height] = one.extent();
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            for depth in (0..20).map(|i| 0.2 * i as f32) {
                let [a, b] = [&one, &many].map(|map| map.texel(x, y).transmittance(depth));
                let bound = many.texel(x, y).error_bound(depth);
                assert!((a - b).abs() <= bound + 2e-6, "{x} {y} {depth}: {a} {b}");
            }
        }
    }
}

#[test]
fn scenes_in_smoke_are_met_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    for embedded in [
        Embedded::SmokeRoom,
        Embedded::SmokeColumns,
        Embedded::SmokeHair,
    ] {
        let scene: Scene = embedded.build(1);
        let geometry = Geometry::new(&scene).expect("meshes");
        let casters = Casters::see_through(&scene.translucent, &geometry);
        for light in &scene.lights {
            let emitters = Light::emitters(light, 1).expect("a light");
            agree_under(&gpu, &casters, &emitters[0], 32);
        }
    }
}

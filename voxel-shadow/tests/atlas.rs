//! Atlases against separate grids.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

mod common;

use epipolar::{Lattice, LightRay, Resolution};
use glam::Vec3;
use gpu_backend::{Cpu, Host};
use proptest::prelude::*;
use voxel_shadow::{
    AtlasGrid, AtlasMap, BuildAtlas, BuildGrid, Error, Grid, IndexMap, RectifyAtlas, Sampling,
    ShadowVolume,
};

use common::{balls, build, camera, first, lattice, lights};

/// Words that a tile without a light keeps.
const UNTOUCHED: u32 = 0xA5A5_5A5A;

fn lattices(resolution: [u32; 3]) -> Vec<Lattice> {
    let view = camera(0.0, 20.0);
    let lights = lights().into_iter();
    lights
        .map(|light| lattice(light, &view, resolution))
        .collect()
}

/// Rectified and extruded, with two tiles to spare.
fn atlas(cpu: &Cpu, lattices: &[Lattice]) -> (AtlasMap<Host>, AtlasGrid<Host>) {
    let resolution = lattices[0].resolution();
    let tiles = lattices.len() + 2;
    let filled = |each: usize| vec![UNTOUCHED; tiles * each];
    let indices = filled(resolution.light_rays());
    let mut map = AtlasMap::from_indices(resolution, tiles, indices).unwrap();
    let words = filled(resolution.words());
    let mut grid = AtlasGrid::from_words(resolution, tiles, words).unwrap();
    let balls = balls();
    let blockers =
        |tile: usize, ray: &LightRay| first(&balls, lattices[tile].space().is_directional())(ray);
    cpu.rectify_atlas(lattices, &blockers, &mut map).unwrap();
    cpu.build_atlas(&map, lattices.len(), &mut grid).unwrap();
    (map, grid)
}

#[test]
fn tiles_are_separate_grids_bit_for_bit_whatever_their_order_and_the_threads() {
    let mut lattices = lattices([67, 33, 96]);
    for turn in 0..lattices.len() {
        lattices.rotate_left(turn);
        for cpu in [Cpu::single_threaded(), Cpu::with_threads(3).unwrap()] {
            let (map, grid) = atlas(&cpu, &lattices);
            let resolution = grid.resolution();
            let (rays, words) = (resolution.light_rays(), resolution.words());
            for (tile, lattice) in lattices.iter().enumerate() {
                let (one_map, one_grid) = build(lattice, &balls());
                assert_eq!(&map.indices()[tile * rays..][..rays], one_map.indices());
                assert_eq!(&grid.words()[tile * words..][..words], one_grid.words());
            }
            let used = lattices.len();
            assert!(map.indices()[used * rays..].iter().all(|i| *i == UNTOUCHED));
            assert!(grid.words()[used * words..].iter().all(|w| *w == UNTOUCHED));
        }
    }
}

#[test]
fn the_volume_of_a_tile_answers_as_that_of_a_grid() {
    let lattices = lattices([64, 48, 64]);
    let (_, grid) = atlas(&Cpu::new(), &lattices);
    for (tile, lattice) in lattices.iter().enumerate() {
        let (_, one) = build(lattice, &balls());
        for sampling in [Sampling::PAPER, Sampling::UNBIASED, Sampling::NEAREST] {
            let expected = ShadowVolume::new(lattice, &one, sampling).unwrap();
            let found = grid.volume(tile, lattice, sampling).unwrap();
            for i in 0..200 {
                let step = i as f32 / 200.0;
                let direction = Vec3::new(1.6 * step - 0.8, 0.4 * (9.0 * step).sin(), -1.0);
                let surface = if i % 3 == 0 {
                    f32::INFINITY
                } else {
                    20.0 * step
                };
                let [e, f] = [&expected, &found].map(|volume| {
                    let ray = volume.ray_shadow(direction, surface);
                    let lit: Vec<_> = ray.lit_runs().collect();
                    (lit, ray.lit_fraction())
                });
                assert_eq!(e, f);
                let point = common::EYE + 5.0 * step * direction;
                assert_eq!(expected.visibility(point), found.visibility(point));
            }
        }
    }
}

proptest! {
    #![proptest_config(reference::property::cases(100))]

    #[test]
    fn any_index_maps_give_the_bits_of_separate_grids(
        (alpha, theta, words, tiles) in (1..40_u32, 1..20_u32, 1..4_u32, 1..6_usize),
        seed in any::<u32>(),
    ) {
        let cpu = Cpu::with_threads(2).unwrap();
        let resolution = Resolution::new(alpha, theta, 32 * words).unwrap();
        let rays = resolution.light_rays();
        let entry = |i: usize| match (i as u32 ^ seed).wrapping_mul(2_654_435_761) >> 7 {
            some if some % 5 == 0 => u32::MAX,
            some => some % (alpha + 1),
        };
        let indices: Vec<u32> = (0..tiles * rays).map(entry).collect();
        let map = AtlasMap::from_indices(resolution, tiles, indices.clone()).unwrap();
        let mut grid = AtlasGrid::new(&cpu, resolution, tiles).unwrap();
        cpu.build_atlas(&map, tiles, &mut grid).unwrap();
        for (tile, found) in grid.words().chunks_exact(resolution.words()).enumerate() {
            let own = indices[tile * rays..][..rays].to_vec();
            let map = IndexMap::from_indices(resolution, own).unwrap();
            let mut one = Grid::new(&cpu, resolution).unwrap();
            cpu.voxelise(&map, &mut one).unwrap();
            cpu.extrude(&mut one).unwrap();
            prop_assert_eq!(found, &one.words()[..]);
        }
    }
}

#[test]
fn too_few_tiles_and_other_resolutions_are_errors() {
    let cpu = Cpu::new();
    let lattices = lattices([8, 8, 32]);
    let resolution = lattices[0].resolution();
    let lit = |_: usize, _: &LightRay| f32::MAX;
    let mut map = AtlasMap::new(&cpu, resolution, 2).unwrap();
    let error = cpu.rectify_atlas(&lattices, &lit, &mut map).unwrap_err();
    let needed = lattices.len();
    assert_eq!(error, Error::Tile { needed, tiles: 2 });
    cpu.rectify_atlas(&lattices[..2], &lit, &mut map).unwrap();
    let mut grid = AtlasGrid::new(&cpu, resolution, 3).unwrap();
    let error = cpu.build_atlas(&map, 3, &mut grid).unwrap_err();
    assert_eq!(
        error,
        Error::Tile {
            needed: 3,
            tiles: 2
        }
    );
    let other = Resolution::new(8, 8, 64).unwrap();
    let mut other = AtlasGrid::new(&cpu, other, 3).unwrap();
    let error = cpu.build_atlas(&map, 2, &mut other).unwrap_err();
    assert!(matches!(error, Error::Resolution { .. }));
    for tile in [3, usize::MAX] {
        let error = grid.volume(tile, &lattices[0], Sampling::NEAREST);
        assert!(matches!(error, Err(Error::Tile { tiles: 3, .. })));
    }
    assert!(AtlasGrid::<Host>::new(&cpu, resolution, usize::MAX).is_err());
    assert!(AtlasMap::<Host>::from_indices(resolution, 2, vec![0]).is_err());
    assert!(AtlasGrid::<Host>::from_words(resolution, 2, vec![0]).is_err());
    // No tiles at all.
    let mut none = AtlasGrid::new(&cpu, resolution, 0).unwrap();
    cpu.build_atlas(&map, 0, &mut none).unwrap();
    cpu.rectify_atlas(&[], &lit, &mut map).unwrap();
}

#[test]
fn the_capacity_is_what_fits_in_the_memory_for_an_atlas() {
    let cpu = Cpu::new();
    let cube = Resolution::new(128, 128, 128).unwrap();
    assert_eq!(cpu.atlas_capacity(cube), 4096);
    let largest = Resolution::new(16384, 16384, 128).unwrap();
    assert_eq!(cpu.atlas_capacity(largest), 0);
}

//! Atlases on a GPU against the CPU.

use epipolar::{Lattice, Light, LightRay, Resolution, Space};
use glam::Vec3;
use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;
use gpu_backend::testing::{self, Shader};
use gpu_backend::{Backend, Cpu, Download, assert_same_layout};
use reference::tolerances::Allowed;

use super::atlas::{AtlasBlockerSlot, BUILD, BuildParameters, RectifyParameters, rectify_shader};
use super::tests::{EYE, allowed, differing, disc_at, lattice};
use crate::{AtlasGrid, AtlasMap, BuildAtlas, Query, RectifyAtlas, Sampling};

/// Horizontal discs of radius 1.5 m, higher for each light.
struct Discs;

const DISCS: &str = "
    fn test_discs_first_blocker_of(tile: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
        let distance = (1.0 + 0.5 * f32(tile) - origin.y) / direction.y;
        let hit = origin.xz + distance * direction.xz;
        if distance > 0.0 && dot(hit, hit) < 2.25 {
            return distance;
        }
        return epi_INFINITE;
    }";

impl InShader<AtlasBlockerSlot> for Discs {
    fn part() -> Part {
        Part::new("test_discs").source(DISCS)
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

fn discs(tile: usize, ray: &LightRay) -> f32 {
    disc_at(1.0 + 0.5 * tile as f32, ray)
}

fn lattices(voxels: [u32; 3]) -> Vec<Lattice> {
    (0..5)
        .map(|i| {
            let light = Light::point(Vec3::new(1.0 + i as f32, 4.0, -2.0 - i as f32)).unwrap();
            lattice(Space::new(light, EYE).unwrap().rotated(i as f32), voxels)
        })
        .collect()
}

#[test]
fn structures_are_those_of_rust() {
    let shader = Shader::new(BUILD).unwrap();
    assert_same_layout!(
        shader,
        "Parameters",
        BuildParameters {
            rows,
            columns,
            tiles
        }
    );
    let shader = Shader::new(&rectify_shader::<Discs>().unwrap().finish(1)).unwrap();
    assert_same_layout!(
        shader,
        "Parameters",
        RectifyParameters { theta, bits, tiles }
    );
}

#[test]
fn indices_differ_in_the_stated_share_and_bits_given_the_indices_in_none() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let lattices = lattices([128, 48, 96]);
    let resolution = lattices[0].resolution();
    let (used, tiles) = (lattices.len(), lattices.len() + 2);
    let mut expected = AtlasMap::new(&cpu, resolution, tiles).unwrap();
    cpu.rectify_atlas(&lattices, &discs, &mut expected).unwrap();
    let mut map = AtlasMap::new(&gpu, resolution, tiles).unwrap();
    gpu.rectify_atlas(&lattices, &Discs, &mut map).unwrap();
    let found = gpu.download(map.indices()).unwrap();
    let rays = resolution.light_rays();
    for (tile, lattice) in lattices.iter().enumerate() {
        let [e, f] = [expected.indices(), &found].map(|all| &all[tile * rays..][..rays]);
        assert!(e.iter().any(|index| *index < 128));
        let share = differing(e, f);
        assert!(share <= allowed(lattice), "{share}");
    }

    // From what was rectified there; unused tiles keep what they held.
    let there = AtlasMap::from_indices(resolution, tiles, found).unwrap();
    let noise: Vec<u32> = (0..(tiles * resolution.words()) as u32)
        .map(|i| i.wrapping_mul(2_654_435_761))
        .collect();
    let mut expected = AtlasGrid::from_words(resolution, tiles, noise.clone()).unwrap();
    cpu.build_atlas(&there, used, &mut expected).unwrap();
    let words = gpu.upload(&noise).unwrap();
    let mut grid = AtlasGrid::from_words(resolution, tiles, words).unwrap();
    gpu.build_atlas(&map, used, &mut grid).unwrap();
    assert_eq!(&gpu.download(grid.words()).unwrap(), expected.words());

    // A query of a tile reads that tile.
    let directions: Vec<[f32; 4]> = (0..500)
        .map(|i| [0.9 - 1.8 * i as f32 / 500.0, 0.2, -1.0, 12.0])
        .collect();
    let rays = gpu.upload(&directions).unwrap();
    for (tile, lattice) in lattices.iter().enumerate() {
        let here = expected.volume(tile, lattice, Sampling::UNBIASED).unwrap();
        let there = grid.volume(tile, lattice, Sampling::UNBIASED).unwrap();
        let mut e = vec![0.0; directions.len()];
        cpu.lit_fraction(&here, &directions, &mut e).unwrap();
        let mut f = gpu.zeros(directions.len()).unwrap();
        gpu.lit_fraction(&there, &rays, &mut f).unwrap();
        let f = gpu.download(&f).unwrap();
        let allowed = Allowed::GpuQuery.error() as f32;
        let wrong = e.iter().zip(&f).filter(|(e, f)| (*e - *f).abs() > allowed);
        // One ray in 500 may be answered from another texel.
        assert!(wrong.count() <= 1, "{tile}");
    }
}

#[test]
fn what_can_be_bound_is_the_capacity() {
    let Some(gpu) = testing::gpu() else { return };
    let cube = Resolution::new(128, 128, 128).unwrap();
    let tiles = gpu.atlas_capacity(cube);
    assert!(tiles >= 512, "{tiles}");
}

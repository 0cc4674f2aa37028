//! Many grids in one pass, beside a build for each.

use gpu_backend::{Cpu, Host};
use lighting::shadow_map::{Casters, RenderShadowMap, RenderShadowMapAtlas, ShadowMap};
use lighting::voxelized::VoxelVolume;
use reference::scenes::TestScene;
use voxel_shadow::{
    AtlasGrid, AtlasMap, BuildAtlas, BuildGrid, Grid, IndexMap, Rectify, RectifyAtlas,
};

use super::{Embedded, SIDE, cube, emitters, eye, fastest, volumes};

/// 64 grids in one pass, and 64 builds of the same size and of 512³.
pub(super) fn few() {
    all_at_once_and_one_by_one(64);
}

/// The same of 256.
pub(super) fn many() {
    all_at_once_and_one_by_one(256);
}

fn all_at_once_and_one_by_one(lights: u32) {
    let scene = TestScene::new(Embedded::Pergola, 480, 270);
    let cpu = Cpu::new();
    let emitters = emitters(&scene, lights);
    let eye = eye(&scene);
    let casters = Casters::upload(&cpu, &scene.geometry).expect("memory");
    let all = cpu
        .shadow_map_atlas(&casters, &emitters, SIDE)
        .expect("memory");
    let each: Vec<ShadowMap<Host>> = emitters
        .iter()
        .map(|emitter| cpu.shadow_map(&casters, emitter, SIDE).expect("memory"))
        .collect();
    let mut together = volumes(&cpu, emitters.len());
    let mut separate: Vec<VoxelVolume<Host>> = emitters
        .iter()
        .map(|_| VoxelVolume::new(&cpu, cube(SIDE)).expect("memory"))
        .collect();
    let mut fine = VoxelVolume::new(&cpu, cube(512)).expect("memory");
    let [at_once, one_by_one, fine] = fastest(
        7,
        [
            &mut || {
                together
                    .update(&cpu, &emitters, &eye, &all)
                    .expect("a legal view");
            },
            &mut || {
                for ((volume, emitter), map) in separate.iter_mut().zip(&emitters).zip(&each) {
                    volume
                        .update(&cpu, emitter, &eye, map)
                        .expect("a legal view");
                }
            },
            &mut || {
                fine.update(&cpu, &emitters[0], &eye, &each[0])
                    .expect("a legal view");
            },
        ],
    );
    println!(
        "  {:.1} ms in one pass, {:.1} ms one by one: {:.2}×",
        1e3 * at_once,
        1e3 * one_by_one,
        one_by_one / at_once
    );
    println!(
        "  {lights} builds of 512³ take {:.1}× as long as the pass (the paper's 1850 ms for 256, with their use, against 8.5 ms)",
        f64::from(lights) * fine / at_once
    );
    let (mut lattices, mut tiles) = (Vec::new(), Vec::new());
    for (light, lattice) in together.with_voxels() {
        lattices.push(lattice.clone());
        // One of so many lights.
        tiles.push(light as u32);
    }
    let maps = all.of_tiles(&tiles).expect("maps of all lights");
    let mut indices = AtlasMap::new(&cpu, cube(SIDE), lattices.len()).expect("memory");
    let mut words = AtlasGrid::new(&cpu, cube(SIDE), lattices.len()).expect("memory");
    let mut grids: Vec<(IndexMap<Host>, Grid<Host>)> = separate
        .iter()
        .map(|_| {
            let indices = IndexMap::new(&cpu, cube(SIDE)).expect("memory");
            (indices, Grid::new(&cpu, cube(SIDE)).expect("memory"))
        })
        .collect();
    let [rectified] = fastest(
        7,
        [&mut || {
            cpu.rectify_atlas(&lattices, &maps, &mut indices)
                .expect("as many tiles");
        }],
    );
    let [built] = fastest(
        7,
        [&mut || {
            cpu.build_atlas(&indices, lattices.len(), &mut words)
                .expect("as many tiles");
        }],
    );
    let [each_rectified] = fastest(
        7,
        [&mut || {
            for ((volume, map), (indices, _)) in separate.iter().zip(&each).zip(&mut grids) {
                if let Some(lattice) = volume.lattice_in_use() {
                    cpu.rectify(lattice, map, indices).expect("one size");
                }
            }
        }],
    );
    let [each_built] = fastest(
        7,
        [&mut || {
            for (indices, grid) in &mut grids {
                cpu.voxelise(indices, grid).expect("one size");
                cpu.extrude(grid).expect("one size");
            }
        }],
    );
    println!(
        "  of the pass: rectify {:.1} ms, build {:.1} ms; one by one: {:.1} ms, {:.1} ms",
        1e3 * rectified,
        1e3 * built,
        1e3 * each_rectified,
        1e3 * each_built
    );
}

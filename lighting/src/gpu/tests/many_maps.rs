//! Maps of many lights: shaders without a device, and against the CPU with one.

use glam::Vec3;
use gpu_backend::gpu::{GpuMemory, InShader};
use gpu_backend::shader::Assembly;
use gpu_backend::testing::{self, Shader};
use gpu_backend::{Cpu, Download, Host, assert_same_layout};
use voxel_shadow::gpu::AtlasBlockerSlot;

use super::scenes::casters;
use crate::Emitter;
use crate::gpu::holes::{HOLES, Levels};
use crate::gpu::imperfect::{Picture, SPLAT, Splats};
use crate::gpu::map_atlas::{AtlasFaceRecord, NO_PICTURE};
use crate::scene::Emission;
use crate::shadow_map::holes_tests::holey;
use crate::shadow_map::{
    CasterPoints, FillHoles, Layout, LevelOfDetail, MOST_TEXELS, RenderImperfectMaps,
    RenderShadowMapAtlas, ShadowMapAtlas, TOGETHER, TileMaps,
};

#[test]
fn structures_are_those_of_rust() {
    let shader = Shader::new(&SPLAT).unwrap();
    assert_same_layout!(
        shader,
        "Splats",
        Splats {
            resolution,
            lights,
            clusters,
            most_texels
        }
    );
    assert_same_layout!(
        shader,
        "Picture",
        Picture {
            face,
            scale,
            kind,
            padding
        }
    );
    // The turns of loops of an invocation, whose cluster may have 64 splats of the largest
    // size: for each splat, row and texel one.
    let side = 2.0 * MOST_TEXELS + 1.0;
    assert!(64.0 * (1.0 + side * (1.0 + side)) < 50_000.0);

    let mut maps = Assembly::new(&["@compute @workgroup_size(1) fn nothing() {}"]);
    maps.fill::<AtlasBlockerSlot>(&<TileMaps<'_, GpuMemory> as InShader<AtlasBlockerSlot>>::part())
        .unwrap();
    let maps = Shader::new(&maps.finish(1)).unwrap();
    assert_same_layout!(maps, "light_AtlasFace", AtlasFaceRecord { face, picture });
    let value = |name: &str| maps.values(name).unwrap()[0];
    assert_eq!(value("light_NO_PICTURE"), f64::from(NO_PICTURE));
}

/// A cube at 128 texels has 24 × 128² bytes.
#[test]
fn as_many_cubes_fit_as_the_memory_for_an_atlas_holds() {
    assert_eq!(Cpu::new().map_capacity(128), (1 << 30) / (24 << 14));
    assert_eq!(Cpu::new().map_capacity(1), (1 << 30) / 24);
    assert_eq!(Cpu::new().map_capacity(65536), 0);
    let Some(gpu) = testing::gpu() else { return };
    let limits = gpu.context().limits();
    let most = (limits.max_storage_buffer_binding_size).min(limits.max_buffer_size);
    for side in [1, 128, 4096] {
        let (cube, capacity) = (24 * u64::from(side).pow(2), gpu.map_capacity(side) as u64);
        assert!(capacity * cube <= most && most < (capacity + 1) * cube);
    }
}

#[test]
fn imperfect_maps_are_those_of_the_cpu_but_for_texels_on_an_edge() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let geometry = casters();
    let point = |emission| {
        let position = geometry.bounds().max() + Vec3::splat(0.3);
        Emitter::point(position, Vec3::ONE, f32::INFINITY, emission).unwrap()
    };
    let lights = [
        point(Emission::Isotropic),
        point(Emission::Cosine {
            normal: Vec3::new(-1.0, -2.0, -1.0).normalize(),
        }),
        Emitter::directional(Vec3::new(0.1, -1.0, 0.2), Vec3::ONE).unwrap(),
    ];
    let here = CasterPoints::sample(&cpu, &geometry, 4096).unwrap();
    let there = CasterPoints::sample(&gpu, &geometry, 4096).unwrap();
    for level in [LevelOfDetail::Even, LevelOfDetail::Near] {
        let expected = cpu.imperfect_maps(&here, &lights, 64, 1000, level).unwrap();
        let found = gpu
            .imperfect_maps(&there, &lights, 64, 1000, level)
            .unwrap();
        let found = gpu.download(found.depth()).unwrap();
        let near = |a: f32, b: f32| a == b || (a - b).abs() <= 1e-5 * a.min(b);
        let pairs = expected.depth().iter().zip(&found);
        let different = pairs.filter(|(a, b)| !near(**a, **b)).count();
        println!("{level:?}: {different} of {} texels differ", found.len());
        // A side of a splat is within rounding, 1e-5 texels, of the border of a texel
        // with a chance of 4e-5, and a splat has a handful of texels along its sides.
        assert!(different * 500 <= found.len(), "{different}");
        assert!(expected.depth().iter().any(|depth| *depth < f32::MAX));
    }
    // None of anything.
    let none = CasterPoints::sample(&gpu, &geometry, 0).unwrap();
    let maps = gpu.imperfect_maps(&none, &lights, 16, 9, LevelOfDetail::Near);
    let depth = gpu.download(maps.unwrap().depth()).unwrap();
    assert!(depth.iter().all(|depth| *depth == f32::MAX));
    let maps = gpu.imperfect_maps(&there, &[], 16, 9, LevelOfDetail::Near);
    assert_eq!(maps.unwrap().lights(), 0);
}

#[test]
fn holes_are_filled_as_on_the_cpu_bit_for_bit() {
    let shader = Shader::new(&HOLES).unwrap();
    assert_same_layout!(
        shader,
        "Levels",
        Levels {
            pictures,
            fine_side,
            coarse_side,
            fine_first,
            coarse_first,
            is_picture,
            padding_a,
            padding_b
        }
    );
    let value = shader.values("TOGETHER").unwrap()[0];
    assert_eq!(value, f64::from(TOGETHER));
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    for (resolution, pictures) in [(1, 3), (2, 1), (5, 4), (37, 3), (64, 2)] {
        for (levels, share) in [(0, 0.5), (1, 0.1), (3, 0.6), (9, 0.9), (3, 1.0)] {
            let depth = holey(resolution, pictures, share, levels + resolution);
            let here =
                |depth| ShadowMapAtlas::<Host>::from_depth(Layout::default(), resolution, depth);
            let mut there = here(depth.clone()).upload(&gpu).unwrap();
            gpu.fill_holes(&mut there, levels).unwrap();
            let mut here = here(depth);
            cpu.fill_holes(&mut here, levels).unwrap();
            let bits = |all: &[f32]| all.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            let found = gpu.download(there.depth()).unwrap();
            assert_eq!(bits(&found), bits(here.depth()), "{resolution} {levels}");
        }
    }
    let none = ShadowMapAtlas::<Host>::from_depth(Layout::default(), 8, Vec::new());
    gpu.fill_holes(&mut none.upload(&gpu).unwrap(), 3).unwrap();
}

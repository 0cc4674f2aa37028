//! Enter and exit slices of triangles against those of the CPU.

use glam::DVec3;
use gpu_backend::{Cpu, Download, testing};
use proptest::prelude::*;

use super::super::PeeledMesh;
use crate::tests::mesh::{Beyond, Solid, Soup, lights, solid};
use crate::{
    Builder, DepthSource, Error, LightSpace, Mesh, Resolution, Slices, Surfaces, TileRect,
};

/// How many texels of a map have other slices than on the CPU, and how many
/// of those are off by more than one.
fn differing(expected: &dyn DepthSource, found: &dyn DepthSource, tile: TileRect) -> [usize; 2] {
    let read = |casters: &dyn DepthSource| {
        let (mut enter, mut exit) = (vec![0; tile.len()], vec![0; tile.len()]);
        casters.read(tile, &mut enter, &mut exit).unwrap();
        enter.into_iter().zip(exit)
    };
    let mut counts = [0; 2];
    for (a, b) in read(expected).zip(read(found)) {
        let off = a.0.abs_diff(b.0).max(a.1.abs_diff(b.1));
        counts[0] += usize::from(off > 0);
        counts[1] += usize::from(off > 1);
    }
    counts
}

/// The share of texels that may differ by one, of either of two slices; see
/// the documentation of [`PeeledMesh`].
fn allowed(light: &LightSpace, side: u32) -> f64 {
    let n = f64::from(side);
    let linear = 12.0 * n / f64::from(1 << 24);
    2.0 * match light.slices() {
        Slices::Linear => linear,
        // Depths are −1/distance of at most 1/near: a slice is
        // distance · L / N high.
        Slices::Logarithmic(ends) => {
            let l = (ends.far() / ends.near()).ln();
            let nearness = ends.far() / ends.near();
            linear * nearness / l + 2.0 * n / f64::from(1 << 21) * (1.0 + 1.0 / l)
        }
    }
}

fn whole(mesh: &Mesh) -> TileRect {
    let side = mesh.resolution().side();
    TileRect { x: 0, y: 0, side }
}

proptest! {
    #![proptest_config(reference::property::cases(40))]

    #[test]
    fn surfaces_are_peeled_off_as_on_the_cpu(
        solids in proptest::collection::vec(solid(), 0..10),
        removed in proptest::collection::vec(any::<prop::sample::Index>(), 0..2),
        light in proptest::sample::select(lights().to_vec()),
        side in proptest::sample::select(&[8_u32, 64, 128][..]),
    ) {
        let Some(gpu) = testing::gpu() else { return Ok(()) };
        let mut soup = Soup::of(&solids);
        for triangle in removed {
            if !soup.indices.is_empty() {
                soup.indices.swap_remove(triangle.index(soup.indices.len()));
            }
        }
        let mesh = soup.mesh(side, light);
        let peeled = PeeledMesh::new(&gpu, &mesh).unwrap();
        let tile = whole(&mesh);
        let [off, far_off] = differing(&mesh, &peeled, tile);
        // A few texels more, of maps that have few.
        let most = allowed(&light, side) * tile.len() as f64 + 4.0;
        prop_assert!((off as f64) <= most, "{} of {}", off, most);
        prop_assert!(far_off <= 2, "{} by more than one", far_off);
    }
}

#[test]
fn many_layers_are_peeled_off_in_several_passes() {
    let Some(gpu) = testing::gpu() else { return };
    // Boxes within boxes, and some behind those: 26 surfaces under the middle.
    let solids: Vec<Solid> = (0..13)
        .map(|i| Solid {
            centre: DVec3::new(0.0, 0.0, if i < 10 { 0.0 } else { -0.3 * f64::from(i - 8) }),
            half: DVec3::splat(0.02 * f64::from(1 + i.min(20 - i))),
            turn: glam::DQuat::from_rotation_z(0.3 * f64::from(i)),
        })
        .collect();
    for light in &lights()[..3] {
        let mesh = Soup::of(&solids).mesh(256, *light);
        let peeled = PeeledMesh::new(&gpu, &mesh).unwrap();
        let [off, far_off] = differing(&mesh, &peeled, whole(&mesh));
        let most = allowed(light, 256) * 65536.0 + 4.0;
        assert!((off as f64) <= most && far_off <= 2, "{off} {far_off}");
    }
}

#[test]
fn tiles_of_large_maps_differ_in_no_more_than_the_stated_share() {
    let Some(gpu) = testing::gpu() else { return };
    let solids: Vec<Solid> = (0..40)
        .map(|i| Solid {
            centre: DVec3::new(
                f64::from(i % 7) - 3.0,
                f64::from(i % 5) - 2.0,
                f64::from(i % 3),
            ) * 0.15,
            half: DVec3::new(0.05, 0.06, 0.08),
            turn: glam::DQuat::from_rotation_y(f64::from(i)),
        })
        .collect();
    let light = lights()[0];
    let mesh = Soup::of(&solids).mesh(4096, light);
    let peeled = PeeledMesh::new(&gpu, &mesh).unwrap();
    let mut counts = [0; 2];
    let side = 256;
    let tiles = [(4, 4), (7, 8), (8, 8), (11, 6)];
    for (x, y) in tiles {
        let tile = TileRect {
            x: x * side,
            y: y * side,
            side,
        };
        let [off, far_off] = differing(&mesh, &peeled, tile);
        counts = [counts[0] + off, counts[1] + far_off];
    }
    let texels = f64::from(tiles.len() as u32 * side * side);
    println!(
        "{counts:?} of {texels}, {} allowed",
        allowed(&light, 4096) * texels
    );
    assert!(
        (counts[0] as f64) <= allowed(&light, 4096) * texels,
        "{counts:?}"
    );
    assert!(counts[1] as f64 <= 1e-5 * texels, "{counts:?}");
}

#[test]
fn a_tile_beyond_the_device_is_refused_before_anything_is_made_for_it() {
    let Some(gpu) = testing::gpu() else { return };
    let side = 1 << 20;
    let resolution = Resolution::new(side).unwrap();
    let empty = Mesh::new(resolution, lights()[0], &[], &[]).unwrap();
    let peeled = PeeledMesh::new(&gpu, &empty).unwrap();
    // Lists for 2^30 blocks would take 24 GiB, and a while.
    let clock = std::time::Instant::now();
    let error = peeled.peel(whole(&empty)).unwrap_err();
    assert!(
        matches!(error, Error::Backend(gpu_backend::Error::TooLarge { .. })),
        "{error}"
    );
    assert!(clock.elapsed().as_secs_f64() < 5.0);
    let small = TileRect {
        side: 64,
        ..whole(&empty)
    };
    assert_eq!(differing(&empty, &peeled, small), [0; 2]);
}

#[test]
fn shadows_are_built_from_what_was_peeled_off() {
    let Some(gpu) = testing::gpu() else { return };
    let solid = Solid {
        centre: DVec3::ZERO,
        half: DVec3::new(0.3, 0.2, 0.1),
        turn: glam::DQuat::from_rotation_x(0.4),
    };
    let mesh = Soup::of(&[solid]).mesh(128, lights()[0]);
    let peeled = PeeledMesh::new(&gpu, &mesh).unwrap();
    let dag = Builder::new().build(&Cpu::new(), &peeled).unwrap();
    assert_eq!(dag.light(), Some(&lights()[0]));
    let expected = Builder::new().build(&Cpu::new(), &mesh).unwrap();
    let mut off = 0;
    for i in 0..128 * 128 {
        let texel = glam::UVec2::new(i % 128, i / 128);
        off += u32::from(dag.depth(texel).abs_diff(expected.depth(texel)) > 1);
    }
    assert!(off <= 2, "{off}");
    // Nothing at all.
    let empty = Mesh::new(Resolution::new(64).unwrap(), lights()[0], &[], &[]).unwrap();
    let peeled = PeeledMesh::new(&gpu, &empty).unwrap();
    assert_eq!(differing(&empty, &peeled, whole(&empty)), [0; 2]);
}

#[test]
fn a_mesh_with_holes_is_peeled_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let corners = [[0.05, 0.4, 0.1], [-0.4, -0.5, 0.0], [0.5, -0.3, 0.3]];
    let surfaces = Surfaces::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
    let holes = surfaces.with_holes(&[0], std::sync::Arc::new(Beyond(0.5)));
    let mesh = holes.seen_from(lights()[0], Resolution::new(128).unwrap());
    let peeled = PeeledMesh::new(&gpu, &mesh).unwrap();
    assert_eq!(differing(&mesh, &peeled, whole(&mesh)), [0; 2]);
    let texels = gpu.download(&peeled.peel(whole(&mesh)).unwrap()).unwrap();
    let (mut enter, mut exit) = (vec![0; 128 * 128], vec![0; 128 * 128]);
    mesh.read(whole(&mesh), &mut enter, &mut exit).unwrap();
    let pairs: Vec<_> = enter.into_iter().zip(exit).map(<[u32; 2]>::from).collect();
    assert_eq!(texels, pairs);
    assert!(texels.iter().any(|[enter, _]| *enter < 128));
}

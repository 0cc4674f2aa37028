//! Trees against the texels that they are made of, and on both backends. What they
//! find is tested against an oracle in the suites.

use glam::Vec3;
use gpu_backend::Cpu;
use reference::random::Random;

use super::fan::LEAF;
use super::*;
use crate::scene::{Emission, Geometry, Mesh, PhaseFunction, Scene};
use crate::shadow_map::{Casters, RenderShadowMap, locate};

/// Two hundred triangles.
fn casters() -> Geometry {
    let mut random = Random::new(77);
    let mut vector = |size: f32| Vec3::from(random.vector(size));
    let positions = (0..200).flat_map(|_| {
        let corner = vector(6.0);
        [corner, corner + vector(1.5), corner + vector(1.5)]
    });
    let mesh = Mesh {
        positions: positions.collect(),
        triangles: (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    };
    Geometry::new(&Scene::from(mesh)).unwrap()
}

fn lights() -> [Emitter; 3] {
    let point =
        |position| Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
    [
        point(Vec3::new(0.3, 0.2, -0.5)),
        point(Vec3::new(0.0, 30.0, 5.0)),
        Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE).unwrap(),
    ]
}

/// A picture from an eye.
fn rays() -> Vec<Ray> {
    let eye = Vec3::new(4.0, 1.0, 6.0);
    let pixel = |i: u32| {
        let (x, y) = (i % 40, i / 40);
        let direction = Vec3::new(0.05 * x as f32 - 1.0, 0.05 * y as f32 - 0.75, -1.0);
        Ray::new(eye, direction, 20.0).unwrap()
    };
    (0..1200).map(pixel).collect()
}

fn fog() -> Medium {
    Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap()
}

/// Calls `texel` with the leaf and the depth of texels that a ray meets, a hundred in
/// each picture.
fn for_each_texel(
    runs: &MapRuns<&ShadowMap<Host>, Host>,
    path: &LightPath<'_>,
    mut texel: impl FnMut(Node, f32),
) {
    let Trees { fans, nodes } = runs.trees.as_ref().unwrap();
    let (map, ray) = (runs.map(), path.ray());
    let (faces, side) = (map.faces(), map.resolution());
    let line = Line::new(ray, &faces[0]);
    let span = [path.span().start, path.span().end].map(|x| line.position(x));
    line.for_each_picture(&runs.projections, span, |face, a, b| {
        let Some(face) = face else { return };
        let pictures = line.pictures(&runs.projections[face]);
        let walk = Walk::new(&line, pictures, [a, b], side);
        let eye = eye_picture(&runs.projections[face], fans.eye, &faces[0]);
        let Some((fan, slice)) = fans.find(&walk, face, eye, pictures[1]) else {
            return;
        };
        let tree = (fan.nodes + slice * fan.nodes_per_slice()) as usize;
        for step in 0..100 {
            let s = a + (f64::from(step) + 0.5) / 100.0 * (b - a);
            let place = locate(faces, side, ray.at(line.distance(s)));
            // At the border of two pictures.
            let Some(place) = place.filter(|place| place.face == face) else {
                continue;
            };
            let [column, row] = place.texel.map(|at| (at as u32).min(side - 1));
            let cell = if walk.is_row_major() { row } else { column };
            let cell = fan.seen_from_side(cell.into(), side) - i64::from(fan.first_cell);
            let leaf = tree + (1 << fan.height) + (cell >> LEAF) as usize;
            let depth = map.depth()[((face as u32 * side + row) * side + column) as usize];
            texel(nodes[leaf], depth);
        }
    });
}

#[test]
fn every_node_holds_the_texels_that_rays_of_its_slice_meet() {
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &casters()).unwrap();
    let (rays, fog) = (rays(), fog());
    for light in lights() {
        let map = cpu.shadow_map(&casters, &light, 96).unwrap();
        let trees = MapRuns::new(&cpu, &map, &rays, &light, &fog).unwrap();
        assert!(trees.bytes() > 0);
        let mut met = 0;
        for ray in &rays {
            let Some(path) = LightPath::new(ray, &light, &fog) else {
                continue;
            };
            for_each_texel(&trees, &path, |leaf, depth| {
                assert!(leaf[0] <= depth && depth <= leaf[1], "{depth} in {leaf:?}");
                met += 1;
            });
        }
        assert!(met > 50 * rays.len(), "{met} texels of {light:?}");
        let Trees { fans, nodes } = trees.trees.as_ref().unwrap();
        for fan in fans.fans.iter().flatten() {
            let per_slice = fan.nodes_per_slice() as usize;
            for tree in
                nodes[fan.nodes as usize..][..per_slice * fan.slices as usize].chunks(per_slice)
            {
                for index in 2..per_slice {
                    let (parent, child) = (tree[index / 2], tree[index]);
                    assert!(parent[0] <= child[0] && parent[1] >= child[1]);
                }
            }
        }
    }
}

#[test]
fn no_rays_need_no_trees_and_answer_by_walking() {
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &casters()).unwrap();
    for light in lights() {
        let map = cpu.shadow_map(&casters, &light, 32).unwrap();
        let trees = MapRuns::new(&cpu, &map, &[], &light, &fog()).unwrap();
        assert_eq!(trees.bytes(), 0);
        let (fog, ray) = (fog(), rays()[700]);
        let path = LightPath::new(&ray, &light, &fog).unwrap();
        let (mut expected, mut actual) = (Vec::new(), Vec::new());
        MapRuns::walked(&map).lit_intervals(&path, &mut expected);
        trees.lit_intervals(&path, &mut actual);
        assert_eq!(actual, expected);
        assert!(!actual.is_empty());
    }
}

#[cfg(feature = "wgpu")]
mod on_gpu {
    use gpu_backend::gpu::GpuMemory;
    use gpu_backend::testing::{self, Shader};
    use gpu_backend::{Download, assert_same_layout};
    use reference::tolerances::Allowed;

    use super::super::gpu::{BLOCKS, BUILD, BlocksRecord, BuildRecord, FanRecord};
    use super::*;

    #[test]
    fn the_shader_that_makes_trees_sees_fans_as_they_are() {
        let shader = Shader::new(&BUILD).unwrap();
        assert_same_layout!(
            shader,
            "light_Fan",
            FanRecord {
                eye,
                first,
                density,
                slices,
                first_cell,
                height,
                nodes,
                padding_a,
                padding_b,
                padding_c
            }
        );
        assert_same_layout!(
            shader,
            "Build",
            BuildRecord {
                fan,
                index,
                resolution,
                padding_a,
                padding_b
            }
        );
        let leaf = shader.values("light_LEAF").unwrap();
        assert_eq!(leaf, [f64::from(fan::LEAF)]);
        let block = shader.values("light_BLOCK").unwrap();
        assert_eq!(block, [f64::from(blocks::BLOCK)]);
        assert_same_layout!(
            Shader::new(&BLOCKS).unwrap(),
            "Blocks",
            BlocksRecord {
                resolution,
                blocks,
                padding_a,
                padding_b
            }
        );
    }

    #[test]
    fn trees_of_both_backends_agree_but_for_texels_at_the_border_of_a_slice() {
        let Some(gpu) = testing::gpu() else { return };
        let cpu = Cpu::new();
        let casters = Casters::upload(&cpu, &casters()).unwrap();
        let (rays, fog) = (rays(), fog());
        // The last block of a hundred texels is half a one.
        for (light, side) in lights().into_iter().zip([96, 100, 100]) {
            let map = cpu.shadow_map(&casters, &light, side).unwrap();
            let expected = MapRuns::new(&cpu, &map, &rays, &light, &fog).unwrap();
            let there: ShadowMap<GpuMemory> = map.upload(&gpu).unwrap();
            let actual = MapRuns::new(&gpu, &there, &rays, &light, &fog).unwrap();
            let (expected, actual) = (expected.trees.unwrap(), actual.trees.unwrap());
            assert_eq!(expected.fans, actual.fans);
            let actual = gpu.download(&actual.nodes).unwrap();
            // The first node of a heap is none.
            let different = expected.nodes.iter().zip(&actual).filter(|(e, g)| e != g);
            let share = different.count() as f64 / actual.len() as f64;
            println!("{share:.5} of the nodes differ");
            assert!(
                share <= Allowed::GpuTreeNodes.error(),
                "{share} of the nodes differ"
            );
        }
    }
}

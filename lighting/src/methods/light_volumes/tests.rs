//! The mesh against the texels that it is made of, and rays against the mesh. What rays
//! find is tested against the map in the suites.

use glam::{DVec3, Quat, Vec3};
use gpu_backend::Cpu;
use reference::random::Random;

use super::*;
use crate::scene::{
    Cone, Emission, Emitter, Geometry, Medium, Mesh as Triangles, PhaseFunction, Scene,
};
use crate::shadow_map::{Casters, EMPTY, RenderShadowMap, ShadowMap};
use crate::{Gather, LitRays, Ray, airlight};

const RESOLUTION: u32 = 96;

/// A floor of two triangles and a hundred smaller ones.
fn casters() -> Geometry {
    let mut random = Random::new(2010);
    let mut vector = |size: f32| Vec3::from(random.vector(size));
    let floor = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)];
    let floor = floor.map(|(x, z)| Vec3::new(x, -6.0 + 0.1 * x, z));
    let small = (0..100).flat_map(|_| {
        let corner = vector(6.0);
        [corner, corner + vector(1.5), corner + vector(1.5)]
    });
    let mesh = Triangles {
        positions: floor.into_iter().chain(small).collect(),
        triangles: [[0, 1, 2], [0, 2, 3]]
            .into_iter()
            .chain((0..100).map(|i| [3 * i + 4, 3 * i + 5, 3 * i + 6]))
            .collect(),
        ..Triangles::default()
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

fn fog(density: f32) -> Medium {
    let sigma = Vec3::splat(density);
    Medium::new(sigma, Vec3::ZERO, PhaseFunction::Isotropic).unwrap()
}

/// Rays all around.
fn rays(count: usize) -> Vec<Ray> {
    let mut random = Random::new(5);
    let mut vector = |size: f32| Vec3::from(random.vector(size));
    (0..count)
        .map(|_| {
            let direction = vector(1.0).normalize_or(Vec3::X);
            Ray::new(vector(8.0), direction, 20.0).unwrap()
        })
        .collect()
}

fn maps() -> Vec<(Emitter, ShadowMap<Host>)> {
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &casters()).unwrap();
    let map = |light: Emitter| {
        let map = cpu.shadow_map(&casters, &light, RESOLUTION).unwrap();
        (light, map)
    };
    lights().into_iter().map(map).collect()
}

/// The height of a vertex of a cell of a picture.
fn height(volume: &LightVolume<Host>, face: usize, x: i64, y: i64) -> f32 {
    let n = i64::from(RESOLUTION);
    let [x, y] = [x, y].map(|i| (i - 1).clamp(0, n - 1));
    volume.heights[((face as i64 * n + y) * n + x) as usize]
}

#[test]
fn every_node_holds_its_vertices_and_patches_are_near_them() {
    let cpu = Cpu::new();
    for (light, map) in maps() {
        let volume = cpu.light_volume(&map, 0.25).unwrap();
        let (mesh, layout) = (volume.mesh(), volume.layout);
        let mut large = 0;
        for face in 0..volume.faces.len() {
            for level in 1..=layout.levels() {
                let side = i64::from(layout.side(level));
                for (x, y) in (0..side * side).map(|i| (i % side, i / side)) {
                    let node = mesh.node(face, level, x, y);
                    let (least, greatest) = (node[0].min(node[1]), node[0].max(node[1]));
                    let size = 1_i64 << level;
                    let patch =
                        (node[0] >= node[1]).then(|| mesh.patch(face, level, [x * size, y * size]));
                    large += usize::from(patch.is_some() && level > 3);
                    let last = i64::from(RESOLUTION) + 1;
                    let [mut low, mut high] = [EMPTY, f32::MIN];
                    for (i, j) in (0..=size).flat_map(|i| (0..=size).map(move |j| (i, j))) {
                        let (column, row) = (x * size + i, y * size + j);
                        let vertex = height(&volume, face, column, row);
                        if column <= last && row <= last {
                            (low, high) = (low.min(vertex), high.max(vertex));
                        }
                        let Some(patch) = patch else { continue };
                        let [u, v] = [i, j].map(|i| i as f64 / size as f64);
                        let plane = patch.plane(u, v);
                        let off = plane.base + plane.x * u + plane.y * v - f64::from(vertex);
                        assert!(off.abs() <= 0.25 * layout.width_at(vertex), "{light:?}");
                    }
                    assert_eq!((least, greatest), (low, high), "{light:?} {level} {x} {y}");
                }
            }
        }
        assert!(large > 10, "{large} for {light:?}");
    }
}

/// What the mesh says of a point: the patch that the light sees there, if the point is
/// well before or behind it.
fn says(volume: &LightVolume<Host>, line: &Line, s: f64) -> Option<bool> {
    let mut answer = None;
    let around = 1e-6 * (1.0 + s.abs());
    line.for_each_picture(
        &volume.projections,
        [s - around, s + around],
        |face, _, _| {
            let Some(face) = face else {
                answer = Some(true);
                return;
            };
            let [at, slope] = line.pictures(&volume.projections[face]);
            let at: DVec3 = at + s * slope;
            let n = f64::from(RESOLUTION);
            let cell = [at.x, at.y].map(|x| 0.5 * (n * (1.0 + x / at.z) + 1.0));
            let index = cell.map(|x| (x.floor() as i64).clamp(0, i64::from(RESOLUTION)));
            let mesh = volume.mesh();
            let mut level = volume.layout.levels();
            while level > 0 && {
                let node = mesh.node(face, level, index[0] >> level, index[1] >> level);
                node[0] < node[1]
            } {
                level -= 1;
            }
            let patch = mesh.patch(face, level, index.map(|i| i >> level << level));
            let [u, v] = [0, 1].map(|axis| (cell[axis] - patch.origin[axis]) / patch.size);
            let plane = patch.plane(u, v);
            let surface = plane.base + plane.x * u + plane.y * v;
            let height = match line.parallel_depth() {
                Some([base, slope]) => base + slope * s,
                None => -1.0 / at.z,
            };
            // Not at a border of the surface, where another plane begins.
            let inside = |x: f64| (x - (4.0 * x).round() / 4.0).abs() > 1e-3;
            let is_clear = (surface - height).abs() > 1e-3 * height.abs();
            if is_clear && inside(cell[0]) && inside(cell[1]) && (u - v).abs() > 1e-3 {
                answer = Some(height <= surface);
            }
        },
    );
    answer
}

#[test]
fn a_point_is_lit_alike_on_every_ray_through_it() {
    let cpu = Cpu::new();
    let (rays, medium) = (rays(3000), fog(1.0));
    for (light, map) in maps() {
        for tolerance in [0.0, 0.25, 2.0] {
            let volume = cpu.light_volume(&map, tolerance).unwrap();
            let (mut asked, mut lit) = (0, Vec::new());
            for ray in &rays {
                let Some(path) = LightPath::new(ray, &light, &medium) else {
                    continue;
                };
                lit.clear();
                volume.lit_intervals(&path, &mut lit);
                let line = Line::new(ray, &volume.faces[0]);
                for i in 0..10 {
                    let Interval { start, end } = path.span();
                    let x = start + (end - start) * (i as f32 + 0.5) / 10.0;
                    let found = lit.iter().any(|part| {
                        let Interval { start, end } = part.interval;
                        start <= x && x < end
                    });
                    let Some(expected) = says(&volume, &line, line.position(x)) else {
                        continue;
                    };
                    asked += 1;
                    assert_eq!(found, expected, "{x} of {ray:?}, {light:?}, {tolerance}");
                }
            }
            assert!(asked > 20_000, "{asked}");
        }
    }
}

#[cfg(feature = "rayon")]
#[test]
fn threads_change_nothing() {
    let [one, three] = [Cpu::single_threaded(), Cpu::with_threads(3).unwrap()];
    for (_, map) in maps() {
        let [a, b] = [&one, &three].map(|cpu| cpu.light_volume(&map, 0.25).unwrap());
        assert_eq!((a.heights, a.nodes), (b.heights, b.nodes));
    }
}

#[test]
fn a_light_that_sees_nothing_has_one_patch_and_lights_all_air() {
    let cpu = Cpu::new();
    // All casters are below.
    let upwards = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let cone = Cone {
        inner: 0.1,
        outer: 0.5,
    };
    let emission = Emission::spot(upwards, cone, None).unwrap();
    let above = Vec3::new(0.0, 7.0, 0.0);
    let light = Emitter::point(above, Vec3::ONE, f32::INFINITY, emission).unwrap();
    let casters = Casters::upload(&cpu, &casters()).unwrap();
    let map = cpu.shadow_map(&casters, &light, 33).unwrap();
    let volume = cpu.light_volume(&map, 0.25).unwrap();
    assert_eq!(volume.patches(), 1);
    let medium = fog(1.0);
    let mut lit = Vec::new();
    let rays = rays(3000);
    let paths = (rays.iter()).filter_map(|ray| LightPath::new(ray, &light, &medium));
    let mut seen = 0;
    for path in paths {
        lit.clear();
        volume.lit_intervals(&path, &mut lit);
        assert_eq!(lit.len(), 1);
        assert_eq!(lit[0].interval, path.span());
        seen += 1;
    }
    assert!(seen > 50, "{seen}");
}

/// From next to no air to air that nothing gets through.
#[test]
fn light_is_finite_at_every_optical_depth() {
    let cpu = Cpu::new();
    let evaluator = airlight::EquiAngular::new(4).unwrap();
    for (light, map) in maps() {
        let volume = cpu.light_volume(&map, 0.25).unwrap();
        let mut rays = rays(200);
        if let Emitter::Point(point) = &light {
            // The light at the eye.
            rays.push(Ray::new(point.position(), Vec3::X, f32::INFINITY).unwrap());
        }
        for density in [0.0, 1e-6, 1.0, 1e6] {
            let medium = fog(density);
            let lit = LitRays::new(&rays, &light, &medium).joined();
            let mut radiance = vec![[0.0; 4]; rays.len()];
            cpu.gather(&lit, &volume, &evaluator, &mut radiance)
                .unwrap();
            assert!(
                radiance
                    .iter()
                    .flatten()
                    .all(|x| x.is_finite() && *x >= 0.0)
            );
        }
    }
}

#[cfg(feature = "wgpu")]
mod on_gpu {
    use gpu_backend::gpu::GpuMemory;
    use gpu_backend::testing::{self, Shader};
    use gpu_backend::{Download, assert_same_layout};
    use reference::tolerances::Allowed;

    use super::super::gpu::{HEIGHTS, HeightsRecord, LEVEL, LayoutRecord, LevelRecord};
    use super::super::mesh::{LARGEST_PATCH, NEAREST, STEEP};
    use super::*;

    #[test]
    fn the_shaders_that_make_meshes_see_their_records_as_they_are() {
        let shader = Shader::new(&LEVEL).unwrap();
        assert_same_layout!(
            shader,
            "light_volume_Layout",
            LayoutRecord {
                width,
                tolerance,
                resolution,
                pictures,
                levels,
                padding_a,
                padding_b,
                first
            }
        );
        assert_same_layout!(
            shader,
            "Level",
            LevelRecord {
                mesh,
                level,
                nodes,
                padding_a,
                padding_b
            }
        );
        let constants = [
            ("light_volume_LARGEST_PATCH", f64::from(LARGEST_PATCH)),
            ("light_volume_NEAREST", f64::from(NEAREST)),
            ("light_volume_STEEP", f64::from(STEEP)),
        ];
        for (name, expected) in constants {
            assert_eq!(shader.values(name).unwrap(), [expected]);
        }
        assert_same_layout!(
            Shader::new(&HEIGHTS).unwrap(),
            "Heights",
            HeightsRecord {
                tan,
                resolution,
                texels,
                padding
            }
        );
    }

    #[test]
    fn meshes_of_both_backends_agree_but_for_patches_at_the_tolerance() {
        let Some(gpu) = testing::gpu() else { return };
        let cpu = Cpu::new();
        let near =
            |e: f32, g: f32| (e - g).abs() <= Allowed::GpuVolumeHeight.error() as f32 * e.abs();
        for (_, map) in maps() {
            let expected = cpu.light_volume(&map, 0.25).unwrap();
            let there: ShadowMap<GpuMemory> = map.upload(&gpu).unwrap();
            let actual = gpu.light_volume(&there, 0.25).unwrap();
            assert_eq!(expected.layout, actual.layout);
            let heights = gpu.download(&actual.heights).unwrap();
            assert!(
                expected
                    .heights
                    .iter()
                    .zip(heights)
                    .all(|(e, g)| near(*e, g))
            );
            let nodes = gpu.download(&actual.nodes).unwrap();
            let differ = |(e, g): &(&Node, &Node)| !(near(e[0], g[0]) && near(e[1], g[1]));
            let different = expected.nodes.iter().zip(&nodes).filter(differ).count();
            let share = different as f64 / nodes.len() as f64;
            println!("{share:.5} of the nodes differ");
            assert!(share <= Allowed::GpuVolumeNodes.error(), "{share}");
        }
    }
}

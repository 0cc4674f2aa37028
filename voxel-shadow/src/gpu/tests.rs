//! Shaders without a device, and steps against the CPU with one.

use epipolar::gpu::{EPIPOLAR, PHI};
use epipolar::{Lattice, Light, LightRay, Resolution, Space, Spacing, ViewVolume};
use glam::Vec3;
use gpu_backend::gpu::{Argument, Gpu, GpuMemory, InShader, Kernel, Queued, Workgroups};
use gpu_backend::shader::Part;
use gpu_backend::testing::{self, Shader};
use gpu_backend::{Backend, Cpu, Download, Host, assert_same_layout};
use reference::tolerances::Allowed;

use super::build::{self, BLOCK, EXTRUDE, Scan, VOXELISE, extrude_by};
use super::depth_layers::DepthViewsRecord;
use super::query::{self, INTERVALS, QUERY};
use super::rectify::{self, PASS, TriangleParameters, triangles_shader};
use super::*;
use crate::{
    BuildGrid, DepthViews, Grid, Holes, IndexMap, LitInterval, Query, Rectify, RectifyMasked,
    RectifyTriangles, Sampling, ShadowVolume, Weights,
};

/// A horizontal disc of radius 1.5 m, 2 m above the ground.
struct Disc;

const DISC: &str = "
    fn test_disc_first_blocker(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
        let distance = (2.0 - origin.y) / direction.y;
        let hit = origin.xz + distance * direction.xz;
        if distance > 0.0 && dot(hit, hit) < 2.25 {
            return distance;
        }
        return epi_INFINITE;
    }";

impl InShader<FirstBlockerSlot> for Disc {
    fn part() -> Part {
        Part::new("test_disc").source(DISC)
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

fn disc(ray: &LightRay) -> f32 {
    disc_at(2.0, ray)
}

pub(super) fn disc_at(height: f32, ray: &LightRay) -> f32 {
    let distance = (height - ray.origin[1]) / ray.direction[1];
    let x = ray.origin[0] + distance * ray.direction[0];
    let z = ray.origin[2] + distance * ray.direction[2];
    if distance > 0.0 && x * x + z * z < 2.25 {
        distance
    } else {
        f32::MAX
    }
}

pub(super) const EYE: Vec3 = Vec3::new(0.2, 1.7, 8.0);

/// From a space around [`EYE`], with so many voxels.
pub(super) fn lattice(space: Space, [alpha, theta, bits]: [u32; 3]) -> Lattice {
    let view = ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [0.9, 0.6], 0.0, 20.0).unwrap();
    let resolution = Resolution::new(alpha, theta, bits).unwrap();
    Lattice::new(space, &view, resolution, Spacing::Angle).unwrap()
}

/// In view, beside it, behind the eye, parallel.
fn lattices(alpha: u32, theta: u32, bits: u32) -> Vec<Lattice> {
    [
        Light::point(Vec3::new(1.0, 3.0, -2.0)).unwrap(),
        Light::point(Vec3::new(9.0, 6.0, 2.0)).unwrap(),
        Light::point(Vec3::new(0.4, 4.2, 14.0)).unwrap(),
        // From below: the disc lies behind the eye's level.
        Light::directional(Vec3::new(0.6, 0.5, -0.3)).unwrap(),
    ]
    .into_iter()
    .map(|light| lattice(Space::new(light, EYE).unwrap(), [alpha, theta, bits]))
    .collect()
}

#[test]
fn depth_layers_fit_the_slot_and_have_the_layout_of_rust() {
    let shader = rectify::shader::<DepthLayers<'_>>().unwrap();
    let shader = Shader::new(&shader.finish(1)).unwrap();
    assert_same_layout!(
        shader,
        "vsv_DepthViews",
        DepthViewsRecord {
            matrices,
            count,
            empty
        }
    );
}

#[test]
fn depth_layers_of_a_cube_block_the_rays_that_they_block_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let lamp = Vec3::new(1.0, 3.0, -2.0);
    let lattice = lattice(
        Space::new(Light::point(lamp).unwrap(), EYE).unwrap(),
        [256, 128, 96],
    );
    // Faces that were cleared to one depth each, or are empty.
    let views = DepthViews::cube(lamp, 0.05).unwrap();
    let depths = [0.02, 0.05, 0.0, 0.04, 0.01, 0.0];
    let device = gpu.context().device();
    let cube = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: 4,
            height: 4,
            depth_or_array_layers: 6,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    for (face, depth) in (0..).zip(depths) {
        let view = cube.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: face,
            array_layer_count: Some(1),
            ..Default::default()
        });
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(depth),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
    }
    gpu.context().queue().submit([encoder.finish()]);
    let layers = cube.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    });
    let resolution = lattice.resolution();
    let mut found = IndexMap::new(&gpu, resolution).unwrap();
    gpu.rectify(&lattice, &DepthLayers::new(&views, &layers), &mut found)
        .unwrap();
    let found = gpu.download(found.indices()).unwrap();
    let mut expected = IndexMap::new(&Cpu::new(), resolution).unwrap();
    let first = |ray: &LightRay| views.first_blocker(ray, |face, _| depths[face]);
    Cpu::new().rectify(&lattice, &first, &mut expected).unwrap();
    let differ = |far: u32| {
        let pairs = expected.indices().iter().zip(&found);
        pairs.filter(|(a, b)| a.abs_diff(**b) > far).count()
    };
    let share = |count: usize| count as f64 / found.len() as f64;
    assert!(expected.indices().iter().any(|index| *index < 256));
    assert!(share(differ(0)) < 2e-3, "{}", share(differ(0)));
    // Rays along the edge between two faces.
    assert!(share(differ(1)) < 1e-3, "{}", share(differ(1)));
}

#[test]
fn the_part_is_fit_for_other_shaders_and_all_structures_are_those_of_rust() {
    let contract = "
        fn epi_bound(index: u32) -> vec2<f32> { return vec2(f32(index)); }
        fn vsv_word(index: u32) -> u32 { return index; }";
    let part = Shader::new(&[EPIPOLAR, PHI, SHADOW, contract]).unwrap();
    // No bindings, no entry points, no other names.
    part.require_part(&["epi_", "vsv_"]).unwrap();
    assert_same_layout!(
        part,
        "vsv_Sampling",
        SamplingRecord {
            alpha_bias,
            phi_bias,
            axis,
            interpolate
        }
    );
    assert_same_layout!(
        part,
        "vsv_LitInterval",
        LitInterval {
            start,
            end,
            visibility
        }
    );
    for parts in [QUERY, INTERVALS] {
        let shader = Shader::new(parts).unwrap();
        assert_same_layout!(
            shader,
            "Parameters",
            query::Parameters {
                lattice,
                sampling,
                count,
                capacity,
                first_word
            }
        );
    }
    for parts in [VOXELISE, EXTRUDE] {
        let shader = Shader::new(parts).unwrap();
        assert_same_layout!(shader, "Parameters", build::Parameters { rows, columns });
    }
    let value = |name: &str| Shader::new(EXTRUDE).unwrap().values(name).unwrap()[0];
    assert_eq!(value("SEGMENTS") * value("ROWS"), f64::from(BLOCK));
    assert_eq!(value("SEGMENTS") * value("COLUMNS"), 256.0);
    Shader::new(&triangles_shader::<Half>().unwrap().finish(1)).unwrap();
    let shader = Shader::new(&triangles_shader::<()>().unwrap().finish(1)).unwrap();
    assert_same_layout!(
        shader,
        "Parameters",
        TriangleParameters {
            lattice,
            first,
            end
        }
    );
    Shader::new(&rectify::shader::<Disc>().unwrap().finish(1)).unwrap();
}

/// Numbers without a pattern.
fn random(i: u32, seed: u32) -> u32 {
    let mixed = (i ^ seed.wrapping_mul(0x9E37_79B9)).wrapping_mul(2_654_435_761);
    (mixed ^ (mixed >> 15)).wrapping_mul(0x85EB_CA6B) >> 3
}

#[test]
fn bits_are_those_of_the_cpu_for_the_same_index_map() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    for (alpha, theta, bits) in [
        (1, 1, 32),
        (7, 3, 32),
        (128, 5, 96),
        (129, 17, 128),
        (300, 9, 1024),
        (1000, 3, 64),
        // The largest: two full levels.
        (16384, 1, 32),
    ] {
        let resolution = Resolution::new(alpha, theta, bits).unwrap();
        let indices = (0..resolution.light_rays() as u32)
            .map(|i| match random(i, alpha) % 8 {
                0 => 0,
                1 => alpha - 1,
                2 => alpha,
                3 => u32::MAX,
                _ => random(i, theta) % alpha,
            })
            .collect();
        let map = IndexMap::from_indices(resolution, indices).unwrap();
        let mut expected = Grid::new(&cpu, resolution).unwrap();
        cpu.voxelise(&map, &mut expected).unwrap();
        let map_there = map.upload(&gpu).unwrap();
        // Whatever the grid held before.
        let noise: Vec<u32> = (0..resolution.words() as u32)
            .map(|i| random(i, 5))
            .collect();
        let mut grid = Grid::from_words(resolution, gpu.upload(&noise).unwrap()).unwrap();
        gpu.voxelise(&map_there, &mut grid).unwrap();
        let context = format!("{resolution:?}");
        assert_eq!(
            &gpu.download(grid.words()).unwrap(),
            expected.words(),
            "{context}"
        );
        cpu.extrude(&mut expected).unwrap();
        // By either scan, from what the other has not touched; twice is once.
        let voxels = gpu.download(grid.words()).unwrap();
        for scan in [Scan::Blocks, Scan::Columns] {
            let mut grid = Grid::from_words(resolution, gpu.upload(&voxels).unwrap()).unwrap();
            for _ in 0..2 {
                extrude_by(&gpu, &mut grid, scan).unwrap();
                assert_eq!(
                    &gpu.download(grid.words()).unwrap(),
                    expected.words(),
                    "{context} {scan:?}"
                );
            }
        }
        gpu.extrude(&mut grid).unwrap();
        assert_eq!(&gpu.download(grid.words()).unwrap(), expected.words());
    }
    let one = Resolution::new(4, 4, 32).unwrap();
    let other = Resolution::new(4, 4, 64).unwrap();
    let map = IndexMap::new(&gpu, one).unwrap();
    let mut grid = Grid::new(&gpu, other).unwrap();
    assert!(gpu.voxelise(&map, &mut grid).is_err());
}

/// The share of the indices that differ.
pub(super) fn differing(expected: &[u32], found: &[u32]) -> f64 {
    let differ = expected.iter().zip(found).filter(|(e, f)| e != f);
    differ.count() as f64 / found.len() as f64
}

/// The share of the indices that may differ.
pub(super) fn allowed(lattice: &Lattice) -> f64 {
    let [low, high] = lattice.ranges().alpha();
    let width = (high - low) / f64::from(lattice.resolution().alpha());
    2.0 * Allowed::GpuAngle.error() / width + Allowed::GpuSilhouetteTexels.error()
}

#[test]
fn rectified_indices_differ_in_no_more_than_the_stated_share() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    for lattice in lattices(256, 192, 192) {
        let mut expected = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        cpu.rectify(&lattice, &disc, &mut expected).unwrap();
        assert!(expected.indices().iter().any(|index| *index < 256));
        let mut map = IndexMap::new(&gpu, lattice.resolution()).unwrap();
        gpu.rectify(&lattice, &Disc, &mut map).unwrap();
        let found = gpu.download(map.indices()).unwrap();
        let share = differing(expected.indices(), &found);
        println!("{share:.1e} of {:.1e}", allowed(&lattice));
        assert!(share <= allowed(&lattice), "{share}");
    }
}

/// A fan of triangles that makes the disc.
fn fan() -> Vec<[Vec3; 3]> {
    let sides = 90_u32;
    let at = |i: u32| {
        let angle = std::f32::consts::TAU * (i % sides) as f32 / sides as f32;
        Vec3::new(1.5 * angle.cos(), 2.0, 1.5 * angle.sin())
    };
    (0..sides)
        .map(|i| [Vec3::new(0.0, 2.0, 0.0), at(i), at(i + 1)])
        .collect()
}

#[test]
fn triangles_block_the_same_rays_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let triangles = fan();
    let there = gpu.upload(&triangles).unwrap();
    for lattice in lattices(128, 96, 96) {
        let mut expected = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        cpu.rectify_triangles(&lattice, &triangles, &mut expected)
            .unwrap();
        let mut map = IndexMap::new(&gpu, lattice.resolution()).unwrap();
        gpu.rectify_triangles(&lattice, &there, &mut map).unwrap();
        let found = gpu.download(map.indices()).unwrap();
        let share = differing(expected.indices(), &found);
        assert!(share <= allowed(&lattice), "{share}");
        // No triangle at all.
        let none = gpu.upload::<[Vec3; 3]>(&[]).unwrap();
        gpu.rectify_triangles(&lattice, &none, &mut map).unwrap();
        let found = gpu.download(map.indices()).unwrap();
        assert!(found.iter().all(|index| *index == 128));
    }
}

/// Triangles that block nothing are as many as would end the loops of software drivers
/// in a single pass, and as begin the third.
#[test]
fn triangles_in_several_passes_block_the_same_rays_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let fan = fan();
    let (begun, ended) = fan.split_at(45);
    let far = [[
        Vec3::splat(1e4),
        Vec3::splat(1e4 + 1.0),
        Vec3::new(1e4, 0.0, 0.0),
    ]];
    let between = far.repeat(2 * PASS as usize);
    let triangles = [begun, &between, ended].concat();
    assert!(triangles.len() > 65_535);
    let there = gpu.upload(&triangles).unwrap();
    let lattice = &lattices(64, 24, 32)[0];
    for holes in [false, true] {
        let mut expected = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        let mut map = IndexMap::new(&gpu, lattice.resolution()).unwrap();
        if holes {
            cpu.rectify_masked(lattice, &triangles, &Half, &mut expected)
                .unwrap();
            gpu.rectify_masked(lattice, &there, &Half, &mut map)
                .unwrap();
        } else {
            cpu.rectify_triangles(lattice, &triangles, &mut expected)
                .unwrap();
            gpu.rectify_triangles(lattice, &there, &mut map).unwrap();
        }
        let share = differing(expected.indices(), &gpu.download(map.indices()).unwrap());
        assert!(share <= 2.0 * allowed(lattice), "{share}");
    }
}

/// Every other triangle has a hole beyond the middle of its second side.
struct Half;

impl Holes for Half {
    fn is_hole(&self, triangle: usize, u: f32, _: f32) -> bool {
        triangle % 2 == 1 && u > 0.5
    }
}

impl InShader<HolesSlot> for Half {
    fn part() -> Part {
        Part::new("test_half").source(
            "
fn test_half_is_hole(triangle: u32, at: vec2<f32>) -> bool {
    return triangle % 2u == 1u && at.x > 0.5;
}",
        )
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

#[test]
fn holes_let_the_same_rays_through_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let triangles = fan();
    let there = gpu.upload(&triangles).unwrap();
    for lattice in lattices(128, 96, 96) {
        let mut whole = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        cpu.rectify_triangles(&lattice, &triangles, &mut whole)
            .unwrap();
        let mut expected = IndexMap::new(&cpu, lattice.resolution()).unwrap();
        cpu.rectify_masked(&lattice, &triangles, &Half, &mut expected)
            .unwrap();
        let mut map = IndexMap::new(&gpu, lattice.resolution()).unwrap();
        gpu.rectify_masked(&lattice, &there, &Half, &mut map)
            .unwrap();
        let found = gpu.download(map.indices()).unwrap();
        let share = differing(expected.indices(), &found);
        // The rims of holes are silhouettes as well.
        assert!(share <= 2.0 * allowed(&lattice), "{share}");
        let blocked = |map: &IndexMap<Host>| map.indices().iter().filter(|i| **i < 128).count();
        assert!(blocked(&expected) <= blocked(&whole));
        assert!(blocked(&whole) < 100 || blocked(&expected) < blocked(&whole));
    }
}

/// Rays over the picture with surfaces at several distances.
fn rays() -> Vec<[f32; 4]> {
    (0..4000_u32)
        .map(|i| {
            let unit = |k: u32| random(4 * i + k, 3) as f32 / (1_u32 << 29) as f32;
            let direction = Vec3::new(1.7 * unit(0) - 0.85, 1.1 * unit(1) - 0.55, -1.0);
            let surface = match i % 5 {
                0 => 0.0,
                1 => f32::MAX,
                _ => 20.0 * unit(2),
            };
            direction.extend(surface).into()
        })
        .collect()
}

fn error(allowed: Allowed) -> f32 {
    allowed.error() as f32
}

fn compare(what: &str, expected: &[f32], found: &[f32], scale: f32) {
    let wrong = expected
        .iter()
        .zip(found)
        .filter(|(e, f)| !((*e - *f).abs() <= error(Allowed::GpuQuery) * scale))
        .count();
    assert!(
        wrong as f32 <= error(Allowed::GpuOtherTexel) * expected.len() as f32,
        "{what}: {wrong} of {}",
        expected.len()
    );
}

fn queries(gpu: &Gpu<Queued>, lattice: &Lattice, grid: &Grid<Host>, sampling: Sampling) {
    let cpu = Cpu::new();
    let bits = lattice.resolution().bits();
    let grid_there = grid.upload(gpu).unwrap();
    let here = ShadowVolume::new(lattice, grid, sampling).unwrap();
    let there = ShadowVolume::new(lattice, &grid_there, sampling).unwrap();
    let rays = rays();
    let count = rays.len();
    let rays_there = gpu.upload(&rays).unwrap();
    let weights: Vec<f32> = (0..bits).map(|i| 1.0 + (i % 3) as f32).collect();
    let weights = Weights::new(&weights).unwrap();

    let mut expected = vec![0.0; count];
    let mut found = gpu.zeros(count).unwrap();
    cpu.lit_fraction(&here, &rays, &mut expected).unwrap();
    gpu.lit_fraction(&there, &rays_there, &mut found).unwrap();
    compare(
        "lit fraction",
        &expected,
        &gpu.download(&found).unwrap(),
        1.0,
    );

    cpu.weighted_sum(&here, &weights, &rays, &mut expected)
        .unwrap();
    gpu.weighted_sum(&there, &weights, &rays_there, &mut found)
        .unwrap();
    let total = weights.sums()[bits as usize];
    compare(
        "weighted sum",
        &expected,
        &gpu.download(&found).unwrap(),
        total,
    );

    // Points on the rays.
    let eye = Vec3::from(lattice.space().eye());
    let points: Vec<[f32; 4]> = rays
        .iter()
        .map(|ray| {
            let direction = Vec3::new(ray[0], ray[1], ray[2]);
            (eye + ray[3].min(25.0) * direction).extend(0.0).into()
        })
        .collect();
    let points_there = gpu.upload(&points).unwrap();
    cpu.visibility(&here, &points, &mut expected).unwrap();
    gpu.visibility(&there, &points_there, &mut found).unwrap();
    compare("visibility", &expected, &gpu.download(&found).unwrap(), 1.0);

    let wrong = differing_intervals(gpu, &here, &there, &rays);
    assert!(
        wrong as f32 <= error(Allowed::GpuOtherTexel) * count as f32,
        "{wrong} of {count}"
    );
}

/// How many rays have other lit intervals than on the CPU.
fn differing_intervals(
    gpu: &Gpu<Queued>,
    here: &ShadowVolume<'_, Host>,
    there: &ShadowVolume<'_, GpuMemory>,
    rays: &[[f32; 4]],
) -> usize {
    let (cpu, count) = (Cpu::new(), rays.len());
    let rays = rays.to_vec();
    let rays_there = gpu.upload(&rays).unwrap();
    let capacity = 3;
    let mut expected = vec![LitInterval::default(); capacity * count];
    let mut expected_counts = vec![0; count];
    cpu.lit_intervals(here, &rays, &mut expected, &mut expected_counts)
        .unwrap();
    let mut intervals = gpu.zeros::<LitInterval>(capacity * count).unwrap();
    let mut counts = gpu.zeros(count).unwrap();
    gpu.lit_intervals(there, &rays_there, &mut intervals, &mut counts)
        .unwrap();
    let found = gpu.download(&intervals).unwrap();
    let counts = gpu.download(&counts).unwrap();
    let same = |i: usize| {
        let kept = capacity.min(counts[i] as usize);
        let (e, f) = (&expected[capacity * i..], &found[capacity * i..]);
        expected_counts[i] == counts[i] && all_close(&e[..kept], &f[..kept])
    };
    (0..count).filter(|i| !same(*i)).count()
}

fn all_close(expected: &[LitInterval], found: &[LitInterval]) -> bool {
    let close = |a: f32, b: f32| (a - b).abs() <= error(Allowed::GpuQueryEnds) * a.abs().max(1.0);
    expected.iter().zip(found).all(|(e, f)| {
        close(e.start, f.start)
            && close(e.end, f.end)
            && (e.visibility - f.visibility).abs() <= error(Allowed::GpuQuery)
    })
}

/// What stands beside the entry point for lit intervals, voxel by voxel.
const LIT_VOXELS: &str = "
@compute @workgroup_size(64)
fn lit_voxels(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let i = invocation.x;
    if i >= parameters.count {
        return;
    }
    var cursor = vsv_cursor(parameters.lattice, parameters.sampling, rays[i].xyz, rays[i].w);
    var run: vsv_Run;
    loop {
        let voxel = vsv_next_voxel(parameters.lattice, parameters.sampling, &cursor, &run);
        if voxel.visibility <= 0.0 || counts[i] == parameters.capacity {
            break;
        }
        intervals[i * parameters.capacity + counts[i]] = voxel;
        counts[i] += 1u;
    }
}";

#[test]
fn no_part_of_a_ray_along_the_axis_of_a_sun_begins_at_infinity() {
    let Some(gpu) = testing::gpu() else { return };
    let parts = [INTERVALS, &[LIT_VOXELS]].concat();
    let (capacity, mut infinite) = (40, 0);
    for direction in [
        [1.0, -0.6, 0.0],
        [1.0, -0.6, 1.0],
        [1.0, -0.6, -1.0],
        [1.0, 0.0, 0.0],
    ] {
        let sun = Light::directional(direction).unwrap();
        let lattice = lattice(Space::new(sun, EYE).unwrap(), [16, 16, 32]);
        let resolution = lattice.resolution();
        let words = (0..resolution.words() as u32).map(|i| random(i, 5) << 3);
        let grid = Grid::<Host>::from_words(resolution, words.collect()).unwrap();
        let grid_there = grid.upload(&gpu).unwrap();
        let [axis, ..] = lattice.space().frame().map(Vec3::from);
        // No direction counts as that of the axis, and is on it without rounding.
        let rays: Vec<[f32; 4]> = [axis, -axis, 0.1 * axis, Vec3::ZERO]
            .iter()
            .flat_map(|d| [0.0, 5.0, f32::MAX].map(|surface| d.extend(surface).into()))
            .collect();
        let rays_there = gpu.upload(&rays).unwrap();
        for sampling in [Sampling::NEAREST, Sampling::UNBIASED, Sampling::PAPER] {
            let here = ShadowVolume::new(&lattice, &grid, sampling).unwrap();
            let there = ShadowVolume::new(&lattice, &grid_there, sampling).unwrap();
            assert_eq!(differing_intervals(&gpu, &here, &there, &rays), 0);
            let mut voxels = gpu.zeros::<LitInterval>(capacity * rays.len()).unwrap();
            let mut counts = gpu.zeros::<u32>(rays.len()).unwrap();
            gpu.dispatch(
                &Kernel {
                    label: "lit voxels",
                    parts: &parts,
                    entry: "lit_voxels",
                    constants: &[],
                },
                &[&[
                    Argument::uniform(query::Parameters::new(&there, rays.len(), capacity)),
                    Argument::table(lattice.bounds()),
                    Argument::read(there.words()),
                    Argument::read(&rays_there),
                    Argument::write(&mut voxels),
                    Argument::write(&mut counts),
                ]],
                Workgroups::covering(rays.len(), 64),
            )
            .unwrap();
            let voxels = gpu.download(&voxels).unwrap();
            let counts = gpu.download(&counts).unwrap();
            for (i, ray) in rays.iter().enumerate() {
                let shadow = here.ray_shadow(Vec3::from_slice(ray), ray[3]);
                let expected: Vec<_> = shadow.lit_voxels().collect();
                let found = &voxels[capacity * i..][..counts[i] as usize];
                assert_eq!(expected.len(), found.len(), "{ray:?}");
                assert!(all_close(&expected, found), "{expected:?} {found:?}");
                infinite += usize::from(shadow.runs().count() > shadow.lit_runs().count());
            }
        }
    }
    assert!(infinite > 0, "runs at infinity, which are no parts");
}

#[test]
fn queries_agree_with_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    for bits in [32, 128, 160] {
        for lattice in lattices(96, 96, bits) {
            let resolution = lattice.resolution();
            let mut map = IndexMap::new(&cpu, resolution).unwrap();
            let mut grid = Grid::new(&cpu, resolution).unwrap();
            cpu.rectify(&lattice, &disc, &mut map).unwrap();
            cpu.voxelise(&map, &mut grid).unwrap();
            cpu.extrude(&mut grid).unwrap();
            for sampling in [Sampling::NEAREST, Sampling::PAPER] {
                queries(&gpu, &lattice, &grid, sampling);
            }
        }
    }
}

#[test]
fn empty_and_wrong_batches_are_handled_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let lattice = lattices(8, 8, 32).swap_remove(0);
    let grid = Grid::new(&gpu, lattice.resolution()).unwrap();
    let volume = ShadowVolume::new(&lattice, &grid, Sampling::PAPER).unwrap();
    let none = gpu.zeros::<[f32; 4]>(0).unwrap();
    let mut results = gpu.zeros::<f32>(0).unwrap();
    gpu.lit_fraction(&volume, &none, &mut results).unwrap();
    let some = gpu.zeros::<[f32; 4]>(2).unwrap();
    assert!(gpu.lit_fraction(&volume, &some, &mut results).is_err());
    assert!(gpu.visibility(&volume, &some, &mut results).is_err());
    let weights = Weights::new(&[1.0; 3]).unwrap();
    let mut results = gpu.zeros::<f32>(2).unwrap();
    assert!(
        gpu.weighted_sum(&volume, &weights, &some, &mut results)
            .is_err()
    );
    // No directions at all: towards the light, and dark.
    gpu.lit_fraction(&volume, &some, &mut results).unwrap();
    assert_eq!(gpu.download(&results).unwrap(), [0.0, 0.0]);
}

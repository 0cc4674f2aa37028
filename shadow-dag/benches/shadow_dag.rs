//! Building, baking and asking, as ratios within one run.
//!
//! Groups are algorithms, ids variants and sizes; throughput in texels for
//! building, voxels or rays for questions. With the feature `wgpu` batches run
//! on a GPU too, if there is one.

#[allow(dead_code, reason = "the figures use other parts of it")]
mod scenes;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{IVec3, Vec3};
use gpu_backend::{Cpu, Download};
use scenes::Maps;
use shadow_dag::{
    Builder, DepthSource, FilterSize, Form, Mesh, Query, RayRecord, Resolution, Rule, ShadowDag,
    Surfaces, TileRect,
};

fn city(side: u32) -> Mesh {
    let resolution = Resolution::new(side).expect("a power of two");
    scenes::city(resolution, 20, 2).expect("a sound scene")
}

fn build(c: &mut Criterion) {
    let mut group = c.benchmark_group("build");
    group.sample_size(10);
    let cpu = Cpu::new();
    for side in [2048, 4096] {
        let mut maps = Maps::of(&city(side)).expect("maps of a mesh");
        group.throughput(Throughput::Elements(u64::from(side).pow(2)));
        for open in [false, true] {
            maps.open = open;
            for (name, rule, culling) in [
                ("2014", Rule::Sintorn2014, false),
                ("2015 without culling", Rule::Kampe2015, false),
                ("2015", Rule::Kampe2015, true),
                ("aligned", Rule::Aligned, true),
            ] {
                let builder = Builder::new().rule(rule).culling(culling);
                let kind = if open { "open" } else { "closed" };
                group.bench_function(BenchmarkId::new(format!("{kind}, {name}"), side), |b| {
                    b.iter(|| builder.build(&cpu, &maps).expect("built"));
                });
            }
        }
    }
    group.finish();
}

fn bake(c: &mut Criterion) {
    let mut group = c.benchmark_group("bake");
    group.sample_size(10);
    let cpu = Cpu::new();
    for side in [2048, 4096, 8192] {
        let mesh = city(side);
        group.throughput(Throughput::Elements(u64::from(side).pow(2)));
        group.bench_function(BenchmarkId::new("without maps", side), |b| {
            b.iter(|| Builder::new().bake(&cpu, &mesh).expect("baked"));
        });
        if side == 2048 {
            group.bench_function(BenchmarkId::new("through maps", side), |b| {
                b.iter(|| Builder::new().build(&cpu, &mesh).expect("built"));
            });
        }
    }
    group.finish();
}

/// What comes before a bake of many triangles, beside the whole of it.
fn sort(c: &mut Criterion) {
    let mut group = c.benchmark_group("sort");
    group.sample_size(10);
    let resolution = Resolution::new(8192).expect("a power of two");
    let (positions, indices) = scenes::hills(474);
    let light = scenes::sun().expect("a sound light");
    group.throughput(Throughput::Elements(indices.len() as u64));
    let id = |what: &str| BenchmarkId::new(what, indices.len());
    let sorted = || Surfaces::new(&positions[..], &indices[..]).expect("sound triangles");
    group.bench_function(id("solids"), |b| b.iter(sorted));
    let surfaces = sorted();
    group.bench_function(id("seen from a sun"), |b| {
        b.iter(|| surfaces.seen_from(light, resolution));
    });
    let cpu = Cpu::new();
    group.bench_function(id("and baked"), |b| {
        b.iter(|| {
            let mesh = sorted().seen_from(light, resolution);
            Builder::new().bake(&cpu, &mesh).expect("baked")
        });
    });
    group.finish();
}

/// A floor that encloses nothing under posts that do, seen by a sun and by a
/// lamp.
fn floor(c: &mut Criterion) {
    let mut group = c.benchmark_group("floor");
    group.sample_size(10);
    let cpu = Cpu::new();
    for side in [2048, 4096, 8192] {
        let resolution = Resolution::new(side).expect("a power of two");
        let [sun, lamp] = scenes::posts(resolution).expect("a sound scene");
        group.throughput(Throughput::Elements(u64::from(side).pow(2)));
        group.bench_function(BenchmarkId::new("sun", side), |b| {
            b.iter(|| Builder::new().bake(&cpu, &sun).expect("baked"));
        });
        // Its slices are no planes: the time grows with the texels.
        if side == 2048 {
            group.bench_function(BenchmarkId::new("lamp", side), |b| {
                b.iter(|| Builder::new().bake(&cpu, &lamp).expect("baked"));
            });
        }
    }
    group.finish();
}

/// Receivers on the visible surface, row by row as a screen would ask, with
/// the offset that a filter of width 9 needs.
fn receivers(maps: &Maps) -> Vec<IVec3> {
    let side = maps.resolution().side();
    let (width, height) = (512, 256);
    (0..width * height)
        .map(|i| {
            let (x, y) = (side / 4 + i % width, side / 3 + i / width);
            IVec3::new(x as i32, y as i32, maps.enter(x, y) as i32 - 3)
        })
        .collect()
}

fn ask(c: &mut Criterion) {
    let mut group = c.benchmark_group("ask");
    let maps = Maps::of(&city(8192)).expect("maps of a mesh");
    let plain = Builder::new().build(&Cpu::new(), &maps).expect("built");
    let packed = plain.to_form(Form::Packed).expect("packed");
    let voxels = receivers(&maps);
    group.throughput(Throughput::Elements(voxels.len() as u64));
    let size = FilterSize::new(9).expect("an odd width");
    let forms: [(&str, &ShadowDag); 2] = [("plain", &plain), ("packed", &packed)];
    for (name, dag) in forms {
        group.bench_function(BenchmarkId::new("voxel", name), |b| {
            b.iter(|| voxels.iter().filter(|voxel| dag.is_lit(**voxel)).count());
        });
        group.bench_function(BenchmarkId::new("9x9", name), |b| {
            b.iter(|| {
                voxels
                    .iter()
                    .map(|voxel| dag.filter(*voxel, size))
                    .sum::<f32>()
            });
        });
    }
    group.bench_function(BenchmarkId::new("9x9", "shadow map"), |b| {
        b.iter(|| {
            let share = |voxel: &IVec3| maps.filter(voxel.x, voxel.y, voxel.z, 4);
            black_box(voxels.iter().map(share).sum::<f32>())
        });
    });
    group.finish();
}

/// What a compressed file costs to write and to read, beside a packed one.
fn files(c: &mut Criterion) {
    let mut group = c.benchmark_group("file");
    group.sample_size(10);
    let side = 8192;
    let dag = Builder::new()
        .bake(&Cpu::new(), &city(side))
        .expect("baked");
    let packed = dag.to_form(Form::Packed).expect("packed");
    let compressed = packed.compress();
    group.throughput(Throughput::Bytes(packed.as_bytes().len() as u64));
    group.bench_function(BenchmarkId::new("compress", side), |b| {
        b.iter(|| packed.compress());
    });
    for (name, file) in [("packed", packed.as_bytes()), ("compressed", &compressed)] {
        group.bench_function(BenchmarkId::new(format!("read {name}"), side), |b| {
            b.iter(|| ShadowDag::read(file).expect("read"));
        });
    }
    group.finish();
}

/// Questions in batches, where the nodes are.
fn batches<B: Query + Download>(c: &mut Criterion, name: &str, backend: &B) {
    let mut group = c.benchmark_group("batch");
    group.sample_size(10);
    let maps = Maps::of(&city(4096)).expect("maps of a mesh");
    let plain = Builder::new().build(&Cpu::new(), &maps).expect("built");
    let voxels = receivers(&maps);
    let size = FilterSize::new(9).expect("an odd width");
    // Along the surface, at a slant to all axes.
    let ray = |voxel: &IVec3| RayRecord::new(voxel.as_vec3(), Vec3::new(1.0, 0.3, -0.2), 512.0);
    let rays: Vec<_> = voxels.iter().step_by(128).map(ray).collect();
    let voxels: Vec<[i32; 4]> = voxels
        .iter()
        .map(|voxel| voxel.extend(0).to_array())
        .collect();
    let there = backend.upload(&voxels).expect("uploaded");
    let rays_there = backend.upload(&rays).expect("uploaded");
    let mut lit = backend.zeros(voxels.len()).expect("made");
    let mut shares = backend.zeros(voxels.len()).expect("made");
    let mut lengths = backend.zeros(rays.len()).expect("made");
    for form in [Form::Plain, Form::Packed] {
        let dag = plain
            .to_form(form)
            .expect("turned")
            .upload(backend)
            .expect("uploaded");
        let id = |what: &str| BenchmarkId::new(format!("{name}, {what}"), format!("{form:?}"));
        group.throughput(Throughput::Elements(voxels.len() as u64));
        group.bench_function(id("voxel"), |b| {
            b.iter(|| {
                backend.is_lit(&dag, &there, &mut lit).expect("asked");
                backend.wait().expect("done");
            });
        });
        group.bench_function(id("9x9"), |b| {
            b.iter(|| {
                backend
                    .filter(&dag, size, &there, &mut shares)
                    .expect("asked");
                backend.wait().expect("done");
            });
        });
        group.throughput(Throughput::Elements(rays.len() as u64));
        group.bench_function(id("ray"), |b| {
            b.iter(|| {
                backend
                    .lit_length(&dag, &rays_there, &mut lengths)
                    .expect("asked");
                backend.wait().expect("done");
            });
        });
    }
    group.finish();
}

/// Reads one tile of a large map.
fn peel(c: &mut Criterion, name: &str, casters: &dyn DepthSource) {
    let tile = TileRect {
        x: 1024,
        y: 1024,
        side: 512,
    };
    let (mut enter, mut exit) = (vec![0; tile.len()], vec![0; tile.len()]);
    let mut group = c.benchmark_group("peel");
    group.sample_size(10);
    group.throughput(Throughput::Elements(tile.len() as u64));
    group.bench_function(BenchmarkId::new(name, 4096), |b| {
        b.iter(|| casters.read(tile, &mut enter, &mut exit).expect("read"));
    });
    group.finish();
}

fn backends(c: &mut Criterion) {
    let mesh = city(4096);
    batches(c, "cpu", &Cpu::new());
    peel(c, "cpu", &mesh);
    #[cfg(feature = "wgpu")]
    match gpu_backend::gpu::Gpu::request() {
        Ok(gpu) => {
            let name = gpu_backend::Backend::name(&gpu).to_owned();
            batches(c, &name, &gpu);
            let peeled = shadow_dag::gpu::PeeledMesh::new(&gpu, &mesh).expect("uploaded");
            peel(c, &name, &peeled);
        }
        Err(error) => println!("skipped: {error}"),
    }
}

criterion_group!(benches, build, bake, sort, floor, files, ask, backends);
criterion_main!(benches);

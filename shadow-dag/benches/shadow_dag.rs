//! Building, baking and asking, as ratios within one run.
//!
//! Groups are algorithms, ids variants and sizes; throughput in texels for
//! building, voxels for questions.

#[allow(dead_code, reason = "the figures use other parts of it")]
mod scenes;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::IVec3;
use gpu_backend::Cpu;
use scenes::Maps;
use shadow_dag::{Builder, Casters, FilterSize, Form, Mesh, Resolution, Rule, ShadowDag};

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

criterion_group!(benches, build, bake, ask);
criterion_main!(benches);

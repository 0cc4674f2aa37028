//! Questions in batches on one thread, beside a dense shadow map of 16 bits.
//!
//! `voxels` are single voxels and `windows` filters of 9 × 9 texels: in front of the visible
//! surface row by row, as a picture asks, and anywhere. The map has the same batches, and sums
//! rows of a window as vectors, with the best instructions that the processor has.

#[allow(dead_code, reason = "other benches use other parts of it")]
mod scenes;

use std::hint::black_box;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use glam::IVec3;
use gpu_backend::Cpu;
use reference::random::Random;
use scenes::Maps;
use shadow_dag::{Builder, FilterSize, Form, Resolution, ShadowDag};

const SIDE: u32 = 4096;
/// Texels on either side of the middle of a window.
const HALF: u32 = 4;
/// The picture that asks.
const PICTURE: [u32; 2] = [512, 256];
/// Questions that the map answers at a time.
const CHUNK: usize = 256;

/// The first shadowed slice of every texel.
struct Dense {
    depths: Vec<u16>,
}

impl Dense {
    fn of(maps: &Maps) -> Self {
        let texels = 0..SIDE * SIDE;
        Self {
            depths: texels
                .map(|i| maps.enter(i % SIDE, i / SIDE) as u16)
                .collect(),
        }
    }

    fn is_lit_batch(&self, cpu: &Cpu, voxels: &[IVec3], lit: &mut [bool]) {
        cpu.for_each_chunk(lit, CHUNK, |first, lit| {
            for (lit, voxel) in lit.iter_mut().zip(&voxels[first..]) {
                let depth = self.depths[(voxel.y as u32 * SIDE + voxel.x as u32) as usize];
                *lit = (voxel.z as u16) < depth;
            }
        });
    }

    fn filter_batch(&self, cpu: &Cpu, voxels: &[IVec3], lit: &mut [f32]) {
        let arch = pulp::Arch::new();
        cpu.for_each_chunk(lit, CHUNK, |first, lit| {
            arch.dispatch(Windows(self, &voxels[first..], lit));
        });
    }

    /// The lit share of the window around a voxel that is not at the rim of the map.
    #[inline(always)]
    fn filter(&self, voxel: IVec3) -> f32 {
        const WIDTH: u32 = 2 * HALF + 1;
        let (x, y, z) = (voxel.x as u32, voxel.y as u32, voxel.z as u16);
        // One vector holds a row; the lanes behind the window do not count.
        let mut lit = [0_u16; 16];
        for y in y - HALF..=y + HALF {
            let first = (y * SIDE + x - HALF) as usize;
            for (lit, depth) in lit.iter_mut().zip(&self.depths[first..first + 16]) {
                *lit += u16::from(z < *depth);
            }
        }
        let lit: u16 = lit[..WIDTH as usize].iter().sum();
        f32::from(lit) / (WIDTH * WIDTH) as f32
    }
}

struct Windows<'a>(&'a Dense, &'a [IVec3], &'a mut [f32]);

impl pulp::WithSimd for Windows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for (voxel, lit) in self.1.iter().zip(self.2) {
            *lit = self.0.filter(*voxel);
        }
    }
}

/// Voxels in front of the surface, by the texels of a picture and anywhere.
fn lists(maps: &Maps) -> [(&'static str, Vec<IVec3>); 2] {
    let [width, height] = PICTURE;
    let at = |x: u32, y: u32| IVec3::new(x as i32, y as i32, maps.enter(x, y) as i32 - 3);
    let rows = (0..width * height).map(|i| at(SIDE / 4 + i % width, SIDE / 3 + i / width));
    let mut random = Random::new(1);
    let mut place = || 16 + (random.bits() % u64::from(SIDE - 32)) as u32;
    let anywhere = (0..width * height).map(|_| at(place(), place()));
    [("rows", rows.collect()), ("anywhere", anywhere.collect())]
}

/// Copies a list of voxels: what memory allows.
fn copy(group: &mut BenchmarkGroup<'_, WallTime>, list: &[IVec3]) {
    group.throughput(Throughput::Elements(list.len() as u64));
    let mut target = list.to_vec();
    group.bench_function("copy", |bencher| {
        bencher.iter(|| black_box(&mut target[..]).copy_from_slice(black_box(list)));
    });
}

fn lookups(criterion: &mut Criterion) {
    let resolution = Resolution::new(SIDE).expect("a power of two");
    let mesh = scenes::city(resolution, 20, 2).expect("a sound scene");
    let maps = Maps::of(&mesh).expect("maps of a mesh");
    let plain = Builder::new().build(&Cpu::new(), &maps).expect("built");
    let packed = plain.to_form(Form::Packed).expect("packed");
    let dense = Dense::of(&maps);
    let lists = lists(&maps);
    let forms: [(&str, &ShadowDag); 2] = [("plain", &plain), ("packed", &packed)];
    let size = FilterSize::new(2 * HALF + 1).expect("an odd width");
    let cpu = Cpu::single_threaded();

    let mut group = criterion.benchmark_group("voxels");
    copy(&mut group, &lists[0].1);
    for (order, list) in &lists {
        let mut expected = vec![false; list.len()];
        let mut lit = vec![false; list.len()];
        group.bench_function(format!("dense/{order}"), |bencher| {
            bencher.iter(|| dense.is_lit_batch(&cpu, black_box(list), &mut expected));
        });
        for (form, dag) in forms {
            let mut ask = || dag.is_lit_batch(&cpu, black_box(list), &mut lit);
            ask().expect("as many places");
            group.bench_function(format!("{form}/{order}"), |bencher| bencher.iter(&mut ask));
        }
        dense.is_lit_batch(&cpu, list, &mut expected);
        assert!(lit == expected, "both are lit in front of the same depth");
    }
    group.finish();

    let mut group = criterion.benchmark_group("windows");
    copy(&mut group, &lists[0].1);
    for (order, list) in &lists {
        let mut shares = vec![0.0; list.len()];
        group.bench_function(format!("dense/{order}"), |bencher| {
            bencher.iter(|| dense.filter_batch(&cpu, black_box(list), &mut shares));
        });
        for (form, dag) in forms {
            let mut ask = || dag.filter_batch(&cpu, black_box(list), size, &mut shares);
            group.bench_function(format!("{form}/{order}"), |bencher| bencher.iter(&mut ask));
        }
    }
    group.finish();
}

criterion_group!(benches, lookups);
criterion_main!(benches);

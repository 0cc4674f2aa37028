//! The steps of a shadow volume, each beside what it is measured by: the scan
//! beside a plain copy of the same buffer, a query of 128 bits beside 128 lookups
//! in the shadow map that the volume was made from, and rectification beside the
//! lookups that it is made from.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use epipolar::{Lattice, Light, LightRay, Resolution, Space, Spacing, ViewVolume};
use glam::Vec3;
use gpu_backend::Cpu;
use voxel_shadow::{
    AtlasGrid, AtlasMap, BuildAtlas, BuildGrid, Grid, IndexMap, LitInterval, Query, Rectify,
    RectifyAtlas, RectifyTriangles, Sampling, ShadowVolume,
};

const EYE: Vec3 = Vec3::new(0.0, 2.0, 12.0);
const LAMP: Vec3 = Vec3::new(1.0, 5.0, 0.0);
const FAR: f32 = 40.0;

/// A forest of posts, 0.3 m wide and 3 m high.
fn posts() -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for i in -8..=8 {
        for j in -8..=8 {
            let foot = Vec3::new(2.3 * i as f32 + 0.4 * j as f32, 0.0, 2.1 * j as f32);
            let corner = |x: f32, y: f32, z: f32| foot + Vec3::new(0.15 * x, y, 0.15 * z);
            for (a, b) in [
                ((-1.0, -1.0), (1.0, -1.0)),
                ((1.0, -1.0), (1.0, 1.0)),
                ((1.0, 1.0), (-1.0, 1.0)),
                ((-1.0, 1.0), (-1.0, -1.0)),
            ] {
                let quad = [
                    corner(a.0, 0.0, a.1),
                    corner(b.0, 0.0, b.1),
                    corner(b.0, 3.0, b.1),
                    corner(a.0, 3.0, a.1),
                ];
                triangles.push([quad[0], quad[1], quad[2]]);
                triangles.push([quad[0], quad[2], quad[3]]);
            }
        }
    }
    triangles
}

/// A plain cube shadow map with the nearest texel, as lean as it can be.
struct CubeMap {
    resolution: usize,
    depth: Vec<f32>,
}

impl CubeMap {
    /// From the triangles, ray by ray through the texels' centres.
    fn new(resolution: usize, triangles: &[[Vec3; 3]]) -> Self {
        let mut depth = vec![f32::MAX; 6 * resolution * resolution];
        for triangle in triangles {
            let [a, b, c] = triangle.map(|corner| corner - LAMP);
            let normal = (b - a).cross(c - a);
            let edges = [b.cross(c), c.cross(a), a.cross(b)];
            for face in 0..6 {
                // Few triangles: the box of their corners on the face is enough.
                let flat = [a, b, c].map(|v| Self::on_face(v, face));
                let behind = flat.iter().any(|(z, _, _)| *z <= 1e-3);
                let bound = |pick: fn(&(f32, f32, f32)) -> f32| {
                    let values = flat.map(|v| pick(&v) / v.0);
                    let low = values.into_iter().fold(f32::INFINITY, f32::min);
                    let high = values.into_iter().fold(f32::NEG_INFINITY, f32::max);
                    if behind { (-1.0, 1.0) } else { (low, high) }
                };
                let texel = |value: f32| {
                    let scaled = 0.5 * (1.0 + value.clamp(-1.0, 1.0)) * resolution as f32;
                    (scaled as usize).min(resolution - 1)
                };
                let (u, v) = (bound(|v| v.1), bound(|v| v.2));
                for row in texel(v.0)..=texel(v.1) {
                    for column in texel(u.0)..=texel(u.1) {
                        let centre = |i: usize| (2 * i + 1) as f32 / resolution as f32 - 1.0;
                        let ray = Self::direction(face, centre(column), centre(row)).normalize();
                        let sides = edges.map(|edge| edge.dot(ray));
                        let inside =
                            sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
                        let distance = a.dot(normal) / ray.dot(normal);
                        if inside && distance > 0.0 {
                            let at = (face * resolution + row) * resolution + column;
                            depth[at] = depth[at].min(distance);
                        }
                    }
                }
            }
        }
        Self { resolution, depth }
    }

    fn on_face(v: Vec3, face: usize) -> (f32, f32, f32) {
        let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
        match face / 2 {
            0 => (sign * v.x, v.y, v.z),
            1 => (sign * v.y, v.x, v.z),
            _ => (sign * v.z, v.x, v.y),
        }
    }

    fn direction(face: usize, u: f32, v: f32) -> Vec3 {
        let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
        match face / 2 {
            0 => Vec3::new(sign, u, v),
            1 => Vec3::new(u, sign, v),
            _ => Vec3::new(u, v, sign),
        }
    }

    /// The depth in the direction of `v`.
    #[inline]
    fn depth(&self, v: Vec3) -> f32 {
        let a = v.abs();
        let face = if a.x >= a.y && a.x >= a.z {
            usize::from(v.x < 0.0)
        } else if a.y >= a.z {
            2 + usize::from(v.y < 0.0)
        } else {
            4 + usize::from(v.z < 0.0)
        };
        let (z, u, w) = Self::on_face(v, face);
        let scale = 0.5 * self.resolution as f32;
        let texel = |x: f32| ((x / z * scale + scale) as usize).min(self.resolution - 1);
        self.depth[(face * self.resolution + texel(w)) * self.resolution + texel(u)]
    }

    #[inline]
    fn is_lit(&self, point: Vec3) -> bool {
        let v = point - LAMP;
        v.length() <= self.depth(v)
    }
}

fn view() -> ViewVolume {
    ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [0.8, 0.45], 0.0, FAR).expect("a view")
}

fn lattice(alpha: u32, theta: u32, bits: u32) -> Lattice {
    let space = Space::new(Light::point(LAMP).expect("a light"), EYE).expect("a space");
    let resolution = Resolution::new(alpha, theta, bits).expect("a resolution");
    Lattice::new(space, &view(), resolution, Spacing::Angle).expect("a lattice")
}

/// The rays of a picture, and where they end.
fn rays(width: u32, height: u32) -> Vec<[f32; 4]> {
    let mut rays = Vec::new();
    for row in 0..height {
        for column in 0..width {
            let x = 0.8 * (2.0 * (column as f32 + 0.5) / width as f32 - 1.0);
            let y = 0.45 * (1.0 - 2.0 * (row as f32 + 0.5) / height as f32);
            let direction = Vec3::new(x, y, -1.0).normalize();
            let ground = if direction.y < 0.0 {
                (-EYE.y / direction.y).min(FAR)
            } else {
                FAR
            };
            rays.push(direction.extend(ground).to_array());
        }
    }
    rays
}

/// One thread, and all of them.
fn backends() -> [(&'static str, Cpu); 2] {
    [
        ("one thread", Cpu::single_threaded()),
        ("all threads", Cpu::new()),
    ]
}

fn build(criterion: &mut Criterion) {
    let triangles = posts();
    let map = CubeMap::new(1024, &triangles);
    let source = |ray: &LightRay| map.depth(ray.direction.into());
    let lattice = lattice(512, 512, 512);
    let resolution = lattice.resolution();
    for (name, cpu) in backends() {
        let mut index_map = IndexMap::new(&cpu, resolution).expect("memory");
        let mut grid = Grid::new(&cpu, resolution).expect("memory");
        let mut group = criterion.benchmark_group("build 512^3");
        group.throughput(Throughput::Elements(resolution.light_rays() as u64));
        group.bench_function(BenchmarkId::new("rectify", name), |b| {
            b.iter(|| {
                cpu.rectify(&lattice, &source, &mut index_map)
                    .expect("rectify");
            });
        });
        group.bench_function(BenchmarkId::new("rectify triangles", name), |b| {
            b.iter(|| {
                cpu.rectify_triangles(&lattice, &triangles, &mut index_map)
                    .expect("rectify");
            });
        });
        group.throughput(Throughput::Bytes(4 * resolution.words() as u64));
        group.bench_function(BenchmarkId::new("voxelise", name), |b| {
            b.iter(|| cpu.voxelise(&index_map, &mut grid).expect("voxelise"));
        });
        group.bench_function(BenchmarkId::new("extrude", name), |b| {
            b.iter(|| cpu.extrude(&mut grid).expect("extrude"));
        });
        group.bench_function(BenchmarkId::new("voxelise and extrude", name), |b| {
            b.iter(|| cpu.build(&index_map, &mut grid).expect("build"));
        });
        group.finish();
    }

    // The light rays and their blockers, of which no index is made.
    let bits = resolution.bits() as usize;
    let mut distances = vec![0.0; resolution.light_rays()];
    let mut group = criterion.benchmark_group("build 512^3");
    group.throughput(Throughput::Elements(resolution.light_rays() as u64));
    group.bench_function("first blockers", |b| {
        b.iter(|| {
            for (theta, plane) in distances.chunks_exact_mut(bits).enumerate() {
                for (bit, distance) in plane.iter_mut().enumerate() {
                    *distance = source(&lattice.light_ray(theta, bit));
                }
            }
            black_box(&distances);
        });
    });
    let mut copy = distances.clone();
    group.bench_function("copy", |b| {
        b.iter(|| {
            copy.copy_from_slice(black_box(&distances));
            black_box(&copy);
        });
    });
    group.finish();
}

fn scan(criterion: &mut Criterion) {
    // 128 MiB, more than any cache here.
    let resolution = Resolution::new(1024, 1024, 1024).expect("a resolution");
    let mut group = criterion.benchmark_group("scan of 128 MiB");
    group.throughput(Throughput::Bytes(4 * resolution.words() as u64));
    for (name, cpu) in backends() {
        let mut grid = Grid::new(&cpu, resolution).expect("memory");
        group.bench_function(BenchmarkId::new("extrude", name), |b| {
            b.iter(|| cpu.extrude(&mut grid).expect("extrude"));
        });
        let source = vec![1_u32; resolution.words()];
        let mut target = vec![0_u32; resolution.words()];
        group.bench_function(BenchmarkId::new("copy", name), |b| {
            b.iter(|| {
                cpu.for_each_chunk(&mut target, 1 << 16, |first, chunk| {
                    chunk.copy_from_slice(&source[first..first + chunk.len()]);
                });
                black_box(&target);
            });
        });
    }
    group.finish();
}

/// 64 grids of 128³ in one atlas, and one after the other.
fn atlas(criterion: &mut Criterion) {
    const LIGHTS: usize = 64;
    let map = CubeMap::new(128, &posts());
    let one = lattice(128, 128, 128);
    let resolution = one.resolution();
    let lattices = vec![one.clone(); LIGHTS];
    let first = |ray: &LightRay| map.depth(ray.direction.into());
    let first_of = |_: usize, ray: &LightRay| map.depth(ray.direction.into());
    let mut group = criterion.benchmark_group("64 grids of 128^3");
    group.throughput(Throughput::Bytes((4 * LIGHTS * resolution.words()) as u64));
    for (name, cpu) in backends() {
        let mut map = AtlasMap::new(&cpu, resolution, LIGHTS).expect("memory");
        let mut grid = AtlasGrid::new(&cpu, resolution, LIGHTS).expect("memory");
        group.bench_function(BenchmarkId::new("rectify in one pass", name), |b| {
            b.iter(|| {
                cpu.rectify_atlas(&lattices, &first_of, &mut map)
                    .expect("rectify");
            });
        });
        group.bench_function(BenchmarkId::new("build in one pass", name), |b| {
            b.iter(|| cpu.build_atlas(&map, LIGHTS, &mut grid).expect("build"));
        });
        let mut maps: Vec<_> = (0..LIGHTS)
            .map(|_| IndexMap::new(&cpu, resolution).expect("memory"))
            .collect();
        let mut grids: Vec<_> = (0..LIGHTS)
            .map(|_| Grid::new(&cpu, resolution).expect("memory"))
            .collect();
        group.bench_function(BenchmarkId::new("rectify separately", name), |b| {
            b.iter(|| {
                for map in &mut maps {
                    cpu.rectify(&one, &first, map).expect("rectify");
                }
            });
        });
        group.bench_function(BenchmarkId::new("build separately", name), |b| {
            b.iter(|| {
                for (map, grid) in maps.iter().zip(&mut grids) {
                    cpu.voxelise(map, grid).expect("voxelise");
                    cpu.extrude(grid).expect("extrude");
                }
            });
        });
    }
    group.finish();
}

fn query(criterion: &mut Criterion) {
    /// Intervals of a ray that are kept.
    const PLACES: usize = 24;
    let map = CubeMap::new(1024, &posts());
    let source = |ray: &LightRay| map.depth(ray.direction.into());
    let cpu = Cpu::single_threaded();
    let rays = rays(320, 180);
    let lattice = lattice(512, 512, 128);
    let resolution = lattice.resolution();
    let mut index_map = IndexMap::new(&cpu, resolution).expect("memory");
    let mut grid = Grid::new(&cpu, resolution).expect("memory");
    cpu.rectify(&lattice, &source, &mut index_map)
        .expect("rectify");
    cpu.voxelise(&index_map, &mut grid).expect("voxelise");
    cpu.extrude(&mut grid).expect("extrude");

    let mut group = criterion.benchmark_group("query of 128 bits");
    group.throughput(Throughput::Elements(rays.len() as u64));
    for (name, sampling) in [
        (
            "nearest",
            Sampling {
                interpolate: false,
                ..Sampling::PAPER
            },
        ),
        ("interpolated", Sampling::PAPER),
    ] {
        let volume = ShadowVolume::new(&lattice, &grid, sampling).expect("a volume");
        let mut intervals = Vec::new();
        group.bench_function(BenchmarkId::new("lit intervals", name), |b| {
            b.iter(|| {
                for ray in &rays {
                    intervals.clear();
                    let direction = Vec3::new(ray[0], ray[1], ray[2]);
                    volume
                        .ray_shadow(direction, ray[3])
                        .lit_intervals(&mut intervals);
                    black_box(&intervals);
                }
            });
        });
        let mut many = vec![LitInterval::default(); PLACES * rays.len()];
        let mut counts = vec![0; rays.len()];
        group.bench_function(BenchmarkId::new("many lit intervals", name), |b| {
            b.iter(|| {
                cpu.lit_intervals(&volume, &rays, &mut many, &mut counts)
                    .expect("a batch");
            });
        });
        group.bench_function(BenchmarkId::new("lit intervals ray by ray", name), |b| {
            b.iter(|| {
                volume.ray_shadows(&rays, |i, ray| {
                    let places = &mut many[i * PLACES..][..PLACES];
                    let mut count = 0;
                    for interval in ray.lit_runs() {
                        if let Some(place) = places.get_mut(count) {
                            *place = interval;
                        }
                        count += 1;
                    }
                    counts[i] = count as u32;
                });
            });
        });
        let mut fractions = vec![0.0; rays.len()];
        group.bench_function(BenchmarkId::new("lit fraction", name), |b| {
            b.iter(|| {
                cpu.lit_fraction(&volume, &rays, &mut fractions)
                    .expect("a batch");
            });
        });
    }
    // What a march does: lit intervals of 128 equal steps.
    let mut intervals: Vec<LitInterval> = Vec::new();
    group.bench_function("128 lookups", |b| {
        b.iter(|| {
            for ray in &rays {
                intervals.clear();
                let direction = Vec3::new(ray[0], ray[1], ray[2]);
                let step = ray[3] / 128.0;
                let mut open = false;
                for i in 0..128 {
                    let start = i as f32 * step;
                    let lit = map.is_lit(EYE + (start + 0.5 * step) * direction);
                    if lit && open {
                        if let Some(last) = intervals.last_mut() {
                            last.end = start + step;
                        }
                    } else if lit {
                        intervals.push(LitInterval {
                            start,
                            end: start + step,
                            visibility: 1.0,
                        });
                    }
                    open = lit;
                }
                black_box(&intervals);
            }
        });
    });
    let mut copy = rays.clone();
    group.bench_function("copy", |b| {
        b.iter(|| {
            copy.copy_from_slice(black_box(&rays));
            black_box(&copy);
        });
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3));
    targets = build, scan, atlas, query
}
criterion_main!(benches);

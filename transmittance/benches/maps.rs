//! Time of making and asking maps on each backend: per segment, and per receiver.
//!
//! 64 × 64 texels of hair in smoke, 120 segments each, in random order. GPUs
//! take part with the feature `wgpu` and a driver of `gpu-backend`.

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main,
};
use gpu_backend::{Backend, Cpu, Download};
use transmittance::{
    Area, BlockerSegment, BuildMap, CaptureSegments, Curve, Error, Exponential, Filter, Linear,
    Lists, Order, Packed, PackedHalf, QueryMap, Receiver, SegmentLists, Stored, Stream,
    TransmittanceMap,
};

#[path = "../tests/support/mod.rs"]
mod support;

use support::streams;

const SIDE: usize = 64;

/// The segments of all texels, and where those of each begin.
fn scene() -> (Vec<u32>, Vec<BlockerSegment>) {
    let (mut offsets, mut segments) = (vec![0], Vec::new());
    for texel in 0..(SIDE * SIDE) as u64 {
        // Without walls, which end every curve early.
        let mut stream = streams::hair_in_smoke(2 * texel + 1);
        streams::Random::new(texel).shuffle(&mut stream);
        segments.extend(stream);
        offsets.push(segments.len() as u32);
    }
    (offsets, segments)
}

/// Points in the hair and behind it.
fn receivers() -> Vec<Receiver> {
    let mut random = streams::Random::new(1);
    let mut unit = || random.unit();
    (0..1 << 18)
        .map(|_| Receiver {
            position: [unit() * SIDE as f32, unit() * SIDE as f32],
            depth: 20.0 + 100.0 * unit(),
        })
        .collect()
}

type ListsOf<B> = SegmentLists<<B as Backend>::Memory>;

fn build<B, A, P>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    backend: &B,
    name: &str,
    lists: &ListsOf<B>,
    clear: &A,
) -> Result<(), Error>
where
    B: BuildMap<A, ListsOf<B>, P> + Download,
    P: Stored,
{
    let mut map = TransmittanceMap::<_, P>::new(backend, [SIDE, SIDE])?;
    group.bench_function(BenchmarkId::new(backend.name(), name), |bench| {
        bench.iter(|| {
            backend.build_map(clear, lists, &mut map)?;
            Ok::<(), Error>(backend.wait()?)
        });
    });
    Ok(())
}

fn builds<B>(criterion: &mut Criterion, backend: &B) -> Result<(), Error>
where
    B: Download + CaptureSegments,
    B: BuildMap<Curve<4, Linear>, ListsOf<B>, Packed<4, Linear>>,
    B: BuildMap<Curve<8, Linear>, ListsOf<B>, Packed<8, Linear>>,
    B: BuildMap<Curve<16, Linear>, ListsOf<B>, Packed<16, Linear>>,
    B: BuildMap<Curve<8>, ListsOf<B>, Packed<8>> + BuildMap<Curve<8>, ListsOf<B>, Curve<8>>,
    B: BuildMap<Room, ListsOf<B>, Packed<8>> + BuildMap<Stream<8>, ListsOf<B>, Packed<8>>,
{
    let (offsets, segments) = scene();
    let lists = Lists::new([SIDE, SIDE], &offsets, &segments)?.upload(backend)?;
    let mut group = criterion.benchmark_group("map/build");
    group.throughput(Throughput::Elements(segments.len() as u64));
    group.sample_size(10);
    let group = &mut group;
    let linear = "paper linear";
    build::<B, _, Packed<4, Linear>>(
        group,
        backend,
        &format!("{linear} 4"),
        &lists,
        &Curve::<4, Linear>::new(),
    )?;
    build::<B, _, Packed<8, Linear>>(
        group,
        backend,
        &format!("{linear} 8"),
        &lists,
        &Curve::<8, Linear>::new(),
    )?;
    build::<B, _, Packed<16, Linear>>(
        group,
        backend,
        &format!("{linear} 16"),
        &lists,
        &Curve::<16, Linear>::new(),
    )?;
    let exponential = Curve::<8>::new();
    build::<B, _, Packed<8>>(group, backend, "paper exponential 8", &lists, &exponential)?;
    build::<B, _, Curve<8>>(group, backend, "with bounds 8", &lists, &exponential)?;
    build::<B, _, Packed<8>>(group, backend, "room 16 for 8", &lists, &Room::new())?;
    build::<B, _, Packed<8>>(group, backend, "room 32 for 8", &lists, &Stream::<8>::new())?;

    // Captured: the segments of all texels in turn.
    let texels: Vec<u32> = (0..segments.len() as u32)
        .map(|i| i % (SIDE * SIDE) as u32)
        .collect();
    let numbers: Vec<f32> = segments
        .iter()
        .flat_map(|s| [s.entry(), s.exit(), s.optical_depth()[0]])
        .collect();
    let (texels, numbers) = (backend.upload(&texels)?, backend.upload(&numbers)?);
    for (order, name) in [
        (Order::Captured, "capture"),
        (Order::FrontToBack, "capture and sort"),
    ] {
        group.bench_function(BenchmarkId::new(backend.name(), name), |bench| {
            bench.iter(|| {
                backend.capture_segments([SIDE, SIDE], &texels, &numbers, 200, order)?;
                Ok::<(), Error>(backend.wait()?)
            });
        });
    }
    Ok(())
}

/// Room for 16 nodes, of which 8 are left.
type Room = Stream<8, Area, Exponential, 1, 2>;

fn query<B, P>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    backend: &B,
    name: &str,
) -> Result<(), Error>
where
    B: QueryMap<P> + Download,
    P: Stored + From<Curve<8>>,
{
    let (offsets, segments) = scene();
    let cpu = Cpu::new();
    let lists = Lists::new([SIDE, SIDE], &offsets, &segments)?;
    let mut map = TransmittanceMap::<_, P>::new(&cpu, [SIDE, SIDE])?;
    cpu.build_map(&Room::new(), &lists, &mut map)?;
    let map = map.upload(backend)?;
    let receivers = receivers();
    let mut results = backend.zeros(receivers.len())?;
    let receivers = backend.upload(&receivers)?;
    for filter in [Filter::Nearest, Filter::Bilinear, Filter::Square(3)] {
        let name = match filter {
            Filter::Square(side) => format!("{name} {side} x {side}"),
            other => format!("{name} {other:?}").to_lowercase(),
        };
        group.bench_function(BenchmarkId::new(backend.name(), name), |bench| {
            bench.iter(|| {
                backend.query_map(&map, &receivers, filter, &mut results)?;
                Ok::<(), Error>(backend.wait()?)
            });
        });
    }
    Ok(())
}

fn queries<B>(criterion: &mut Criterion, backend: &B) -> Result<(), Error>
where
    B: QueryMap<Packed<8>> + QueryMap<PackedHalf<8>> + Download,
{
    let mut group = criterion.benchmark_group("map/query");
    group.throughput(Throughput::Elements(receivers().len() as u64));
    group.sample_size(10);
    query::<B, Packed<8>>(&mut group, backend, "f32 8")?;
    query::<B, PackedHalf<8>>(&mut group, backend, "f16 8")
}

fn maps(criterion: &mut Criterion) {
    let cpu = Cpu::new();
    builds(criterion, &cpu).expect("sound lists");
    queries(criterion, &cpu).expect("sound lists");
    #[cfg(feature = "wgpu")]
    match gpu_backend::gpu::Gpu::request() {
        Ok(gpu) => {
            builds(criterion, &gpu).expect("a device that works");
            queries(criterion, &gpu).expect("a device that works");
        }
        Err(error) => println!("skipped on GPUs: {error}"),
    }
}

criterion_group!(benches, maps);
criterion_main!(benches);

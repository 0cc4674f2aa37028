//! Time per segment and per question of every method, on smoke and hair.
//!
//! Compare within one run; the errors that belong to these times are printed by
//! `tests/quality.rs`.

use std::hint::black_box;

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main,
};
use transmittance::baseline::{Captured, Deep, FourierCurve, Moments, OpacityCurve, Range};
use transmittance::{
    Accumulate, Area, BlockerSegment, Curve, Evaluate, Exponential, Linear, Maximum, Packed,
    PackedHalf, Sorted, Stream,
};

mod plain;
#[path = "../../tests/support/mod.rs"]
mod support;

use plain::Plain;
use support::streams;

/// 32 rays of each kind, in random order.
fn rays(kind: fn(u64) -> Vec<BlockerSegment>) -> Vec<Vec<BlockerSegment>> {
    let ray = |seed| {
        let mut ray = kind(seed);
        streams::Random::new(seed).shuffle(&mut ray);
        ray
    };
    (0..32).map(ray).collect()
}

fn made<A: Accumulate + Clone>(clear: &A, ray: &[BlockerSegment]) -> A::Curve {
    let mut accumulator = clear.clone();
    for segment in ray {
        accumulator.insert(segment);
    }
    accumulator.finish()
}

/// Making a curve, per segment.
fn make<A: Accumulate + Clone>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    rays: &[Vec<BlockerSegment>],
    clear: &A,
) {
    let segments: usize = rays.iter().map(Vec::len).sum();
    group.throughput(Throughput::Elements(segments as u64));
    group.bench_function(BenchmarkId::from_parameter(name), |bench| {
        bench.iter(|| {
            for ray in rays {
                black_box(made(clear, black_box(ray)));
            }
        });
    });
}

fn insertion(criterion: &mut Criterion) {
    let range = Range::new(0.0, 300.0).expect("a range");
    for (kind, rays) in [
        ("smoke", rays(streams::columns_of_smoke)),
        ("hair", rays(streams::hair)),
    ] {
        let mut group = criterion.benchmark_group(format!("insert/{kind}"));
        let (group, rays) = (&mut group, &rays[..]);
        make(group, "plain linear 8", rays, &Plain::<8, 10>::new());
        make(group, "plain linear 16", rays, &Plain::<16, 18>::new());
        make(group, "paper linear 4", rays, &Curve::<4, Linear>::new());
        make(group, "paper linear 8", rays, &Curve::<8, Linear>::new());
        make(group, "paper linear 16", rays, &Curve::<16, Linear>::new());
        make(group, "paper exponential 8", rays, &Curve::<8>::new());
        make(group, "stream area 8", rays, &Stream::<8>::new());
        make(group, "stream area 16", rays, &Stream::<16>::new());
        make(
            group,
            "stream area 8 room 16",
            rays,
            &Stream::<8, Area, Exponential, 1, 2>::new(),
        );
        make(
            group,
            "stream maximum 8",
            rays,
            &Stream::<8, Maximum>::new(),
        );
        make(
            group,
            "sorted stream area 8",
            rays,
            &Sorted::new(Stream::<8>::new()),
        );
        make(group, "uncompressed", rays, &Captured::new());
        make(group, "deep 0.01", rays, &Deep::new(0.01).expect("a bound"));
        make(
            group,
            "deep 0.002",
            rays,
            &Deep::new(0.002).expect("a bound"),
        );
        make(group, "opacity 32", rays, &OpacityCurve::<32>::new(range));
        make(group, "fourier 16", rays, &FourierCurve::<16>::new(range));
        make(
            group,
            "moments 8",
            rays,
            &Moments::new(8, range).expect("8 moments"),
        );
    }
}

/// Asking a curve, per depth.
fn ask<E: Evaluate>(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, curves: &[E]) {
    const DEPTHS: usize = 64;
    let questions = (curves.len() * DEPTHS) as u64;
    group.throughput(Throughput::Elements(questions));
    group.bench_function(BenchmarkId::from_parameter(name), |bench| {
        bench.iter(|| {
            let mut sum = 0.0;
            for curve in curves {
                for depth in 0..DEPTHS {
                    // Depths as receivers have them, in no order.
                    let depth = (depth * 37 % DEPTHS) as f32 * 4.5;
                    sum += curve.evaluate(black_box(depth))[0];
                }
            }
            sum
        });
    });
}

/// A curve for each ray.
fn all<A: Accumulate + Clone>(rays: &[Vec<BlockerSegment>], clear: &A) -> Vec<A::Curve> {
    rays.iter().map(|ray| made(clear, ray)).collect()
}

fn evaluation(criterion: &mut Criterion) {
    let range = Range::new(0.0, 300.0).expect("a range");
    let rays = rays(streams::columns_of_smoke);
    let mut group = criterion.benchmark_group("evaluate/smoke");
    let group = &mut group;
    let curves = all(&rays, &Stream::<8>::new());
    ask(group, "curve 8", &curves);
    let packed: Vec<_> = curves.iter().copied().map(Packed::from).collect();
    ask(group, "packed 8", &packed);
    let half: Vec<_> = curves.iter().copied().map(PackedHalf::from).collect();
    ask(group, "packed half 8", &half);
    ask(group, "plain linear 8", &all(&rays, &Plain::<8, 10>::new()));
    let linear: Vec<Packed<16, Linear>> = all(&rays, &Curve::<16, Linear>::new())
        .into_iter()
        .map(Packed::from)
        .collect();
    ask(group, "packed linear 16", &linear);
    ask(
        group,
        "plain linear 16",
        &all(&rays, &Plain::<16, 18>::new()),
    );
    ask(group, "uncompressed", &all(&rays, &Captured::new()));
    ask(
        group,
        "deep 0.01",
        &all(&rays, &Deep::new(0.01).expect("a bound")),
    );
    ask(
        group,
        "opacity 32",
        &all(&rays, &OpacityCurve::<32>::new(range)),
    );
    ask(
        group,
        "fourier 16",
        &all(&rays, &FourierCurve::<16>::new(range)),
    );
    for count in [4, 6, 8] {
        let clear = Moments::new(count, range).expect("4, 6 or 8 moments");
        ask(group, &format!("moments {count}"), &all(&rays, &clear));
    }
}

criterion_group!(benches, insertion, evaluation);
criterion_main!(benches);

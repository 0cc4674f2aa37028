//! Segments per second of every evaluator, one core, over three lists.
//!
//! The easy list has rays in directions spread over the sphere, with D and the
//! length within a factor of ten of 1 m, in fog of 0.3/m. The stiff one has
//! lengths from 1e-6 of D to infinity, D from 1 mm to 1 km, and half of its
//! rays within a few degrees of the light or away from it.
//!
//! The third has the steps of a march: parts of a hundredth of the easy ones. The
//! march is along rays of 64 steps each, as long as the easy ones.
//!
//! Each group copies its list, for comparison with what memory allows; see
//! `tests/scripts/kernel_ratios.py`.
//!
//! Before it measures, the bench prints each evaluator's largest and median
//! error on each list: time says nothing without it.

use std::f32::consts::{LN_2, LOG2_E, PI};
use std::hint::black_box;

use airlight::{
    Evaluator, Exact, FrameTable, Framed, PhaseFunction, Quadrature, Segment, SunTable, Table,
};
use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main,
};
use reference::random::Random;

const SIGMA_T: f32 = 0.3;
const COUNT: usize = 4096;

/// Midpoint steps of equal length, as many for each segment: what a march
/// without visibility costs. Vectorised over blocks like the tables.
struct March {
    steps: u32,
}

impl March {
    #[inline(always)]
    fn block(&self, sigma_t: f32, segments: &[Segment; 64], airlight: &mut [f32; 64]) {
        let mut sum = [0.0_f32; 64];
        let share = 1.0 / self.steps as f32;
        for step in 0..self.steps {
            let t = (step as f32 + 0.5) * share;
            for (sum, segment) in sum.iter_mut().zip(segments) {
                let Segment { x, s, h, length } = *segment;
                let s = s + t * length;
                let d2 = s * s + h * h;
                *sum += exp(-sigma_t * (x + t * length + d2.sqrt())) / d2;
            }
        }
        for ((airlight, sum), segment) in airlight.iter_mut().zip(sum).zip(segments) {
            *airlight = sum * share * segment.length * (0.25 / PI);
        }
    }
}

/// `e^x` for x ≤ 0, as the tables compute it.
#[inline(always)]
fn exp(x: f32) -> f32 {
    const ROUND: f32 = 12_582_912.0;
    let x = x * LOG2_E;
    let rounded = x + ROUND;
    let f = x - (rounded - ROUND);
    let power = 1.000_000_1
        + f * (LN_2
            + f * (0.240_221_07 + f * (0.055_503_57 + f * (0.009_676_032 + f * 0.001_339_086_3))));
    let power = f32::from_bits(power.to_bits().wrapping_add(rounded.to_bits() << 23));
    if x > -100.0 { power } else { 0.0 }
}

struct MarchBatch<'a>(&'a March, f32, &'a [Segment], &'a mut [f32]);

impl pulp::WithSimd for MarchBatch<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let (blocks, _) = self.2.as_chunks::<64>();
        let (outs, _) = self.3.as_chunks_mut::<64>();
        for (segments, airlight) in blocks.iter().zip(outs) {
            self.0.block(self.1, segments, airlight);
        }
    }
}

impl Evaluator for March {
    fn airlight(&self, sigma_t: f32, segment: &Segment) -> f32 {
        let mut airlight = [0.0; 64];
        self.block(sigma_t, &[*segment; 64], &mut airlight);
        airlight[0]
    }

    fn airlight_batch(&self, sigma_t: f32, segments: &[Segment], airlight: &mut [f32]) {
        pulp::Arch::new().dispatch(MarchBatch(self, sigma_t, segments, airlight));
    }
}

fn segment(distance: f64, gamma: f64, x: f64, length: f64) -> Segment {
    Segment {
        x: x as f32,
        s: (x - distance * gamma.cos()) as f32,
        h: (distance * gamma.sin()) as f32,
        length: length as f32,
    }
}

fn easy() -> Vec<Segment> {
    let mut random = Random::new(1);
    let mut log = |low: f64, high: f64| (low.ln() + (high / low).ln() * random.unit_f64()).exp();
    let mut angle = Random::new(1);
    (0..COUNT)
        .map(|_| {
            let distance = log(0.3, 10.0);
            let gamma = (1.0 - 2.0 * angle.unit_f64()).acos();
            segment(distance, gamma, 0.0, log(0.3, 10.0) * distance)
        })
        .collect()
}

fn stiff() -> Vec<Segment> {
    let mut random = Random::new(1);
    (0..COUNT)
        .map(|i| {
            let mut log =
                |low: f64, high: f64| (low.ln() + (high / low).ln() * random.unit_f64()).exp();
            let distance = log(1e-3, 1e3);
            let gamma = match i % 4 {
                0 => log(1e-6, 0.1),
                1 => std::f64::consts::PI - log(1e-6, 0.1),
                _ => log(0.1, 3.0),
            };
            let length = if i % 8 == 3 {
                f64::INFINITY
            } else {
                log(1e-6, 10.0) * distance
            };
            let x = if i % 2 == 0 {
                0.0
            } else {
                log(0.01, 2.0) * distance
            };
            segment(distance, gamma, x, length)
        })
        .collect()
}

/// Largest and median relative error where the result is a normal number.
fn errors(evaluator: &dyn Evaluator, phase: PhaseFunction, list: &[Segment]) -> [f64; 2] {
    let Ok(exact) = Exact::new(phase) else {
        return [f64::NAN; 2];
    };
    let mut airlight = vec![0.0; list.len()];
    evaluator.airlight_batch(SIGMA_T, list, &mut airlight);
    let mut errors: Vec<f64> = list
        .iter()
        .zip(airlight)
        .map(|(segment, value)| (value, exact.airlight(SIGMA_T.into(), &(*segment).into())))
        .filter(|&(_, truth)| truth > f64::from(f32::MIN_POSITIVE) && truth < f64::from(f32::MAX))
        .map(|(value, truth)| (f64::from(value) / truth - 1.0).abs())
        .collect();
    errors.sort_by(f64::total_cmp);
    [errors[errors.len() - 1], errors[errors.len() / 2]]
}

fn evaluators(criterion: &mut Criterion) {
    let henyey = |g| PhaseFunction::HenyeyGreenstein { g };
    let table = |phase: PhaseFunction, kibibytes| {
        Table::new(&phase, kibibytes).expect("the parameters are in range")
    };
    let iso = PhaseFunction::Isotropic;
    let cases: Vec<(String, PhaseFunction, Box<dyn Evaluator>)> = [
        ("table/isotropic, 64 KiB", iso, 64),
        ("table/isotropic, 32 KiB", iso, 32),
        ("table/isotropic, 16 KiB", iso, 16),
        ("table/Rayleigh, 64 KiB", PhaseFunction::Rayleigh, 64),
        ("table/Henyey-Greenstein 0.6, 64 KiB", henyey(0.6), 64),
        ("table/Henyey-Greenstein 0.95, 64 KiB", henyey(0.95), 64),
        ("table/Henyey-Greenstein -0.6, 64 KiB", henyey(-0.6), 64),
        (
            "table/Schlick 0.8, 64 KiB",
            PhaseFunction::Schlick { k: 0.8 },
            64,
        ),
        (
            "table/Cornette-Shanks 0.8, 64 KiB",
            PhaseFunction::CornetteShanks { g: 0.8 },
            64,
        ),
    ]
    .into_iter()
    .map(|(name, phase, kibibytes)| {
        let evaluator: Box<dyn Evaluator> = Box::new(table(phase, kibibytes));
        (name.to_owned(), phase, evaluator)
    })
    .chain([(
        "sun/512".to_owned(),
        iso,
        Box::new(SunTable::new()) as Box<dyn Evaluator>,
    )])
    .chain(
        [
            ("quadrature/isotropic, 1e-4", iso),
            ("quadrature/Henyey-Greenstein 0.6, 1e-4", henyey(0.6)),
            ("quadrature/Rayleigh, 1e-4", PhaseFunction::Rayleigh),
        ]
        .map(|(name, phase)| {
            let quadrature = Quadrature::with_tolerance(phase, 1e-4).expect("in range");
            let evaluator: Box<dyn Evaluator> = Box::new(quadrature);
            (name.to_owned(), phase, evaluator)
        }),
    )
    .chain(
        [
            ("exact/isotropic", iso),
            ("exact/Henyey-Greenstein 0.6", henyey(0.6)),
        ]
        .map(|(name, phase)| {
            let exact = Exact::new(phase).expect("in range");
            let evaluator: Box<dyn Evaluator> = Box::new(exact);
            (name.to_owned(), phase, evaluator)
        }),
    )
    .chain([32_u32, 64, 128, 512, 2048].map(|steps| {
        let march: Box<dyn Evaluator> = Box::new(March { steps });
        (format!("march/{steps} steps"), iso, march)
    }))
    .collect();

    let mut steps = easy();
    for segment in &mut steps {
        segment.length *= 0.01;
    }
    for (list_name, list) in [("easy", easy()), ("stiff", stiff()), ("steps", steps)] {
        let mut group = criterion.benchmark_group(list_name);
        group.throughput(Throughput::Elements(list.len() as u64));
        copy(&mut group, &list);
        for (name, phase, evaluator) in &cases {
            let [largest, median] = errors(&**evaluator, *phase, &list);
            println!("{list_name}: {name}: largest error {largest:.1e}, median {median:.1e}");
            let mut airlight = vec![0.0; list.len()];
            group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
                bencher.iter(|| {
                    evaluator.airlight_batch(SIGMA_T, black_box(&list), &mut airlight);
                });
            });
        }
        group.finish();
    }
}

/// Copies a list of segments: what memory allows.
fn copy(group: &mut BenchmarkGroup<'_, WallTime>, list: &[Segment]) {
    let mut target = list.to_vec();
    group.bench_function("copy", |bencher| {
        bencher.iter(|| black_box(&mut target[..]).copy_from_slice(black_box(list)));
    });
}

/// Steps of rays: by the published table, by a table as segments of a batch, and by its
/// march.
fn march(criterion: &mut Criterion) {
    const STEPS: usize = 64;
    let phase = PhaseFunction::Isotropic;
    let table = Table::new(&phase, 64).expect("the parameters are in range");
    let rays: Vec<Segment> = easy().into_iter().take(COUNT / STEPS).collect();
    let end = |ray: &Segment, i: usize| ray.length * (i as f32 / STEPS as f32);
    let ends: Vec<f32> = (rays.iter())
        .flat_map(|ray| (1..=STEPS).map(move |i| end(ray, i)))
        .collect();
    let steps: Vec<Segment> = (rays.iter())
        .flat_map(|ray| (0..STEPS).map(move |i| ray.part(end(ray, i), end(ray, i + 1))))
        .collect();
    let mut airlight = vec![0.0; steps.len()];
    let mut group = criterion.benchmark_group("march");
    group.throughput(Throughput::Elements(steps.len() as u64));
    copy(&mut group, &steps);
    let evaluators: [(&str, &dyn Evaluator); 2] = [
        ("sun/512", &SunTable::new()),
        ("table/isotropic, 64 KiB", &table),
    ];
    for (name, evaluator) in evaluators {
        group.bench_function(name, |bencher| {
            bencher.iter(|| evaluator.airlight_batch(SIGMA_T, black_box(&steps), &mut airlight));
        });
    }
    group.bench_function("march/isotropic, 64 KiB", |bencher| {
        bencher.iter(|| {
            let chunks = ends.chunks(STEPS).zip(airlight.chunks_mut(STEPS));
            for (ray, (ends, airlight)) in rays.iter().zip(chunks) {
                table.march(SIGMA_T, black_box(ray), ends, airlight);
            }
        });
    });
    group.finish();
}

/// Tables of a frame: how long they take to make, and the steps of rays all around, one
/// by one and with one lookup for each, beside those of the table for all frames.
fn frame(criterion: &mut Criterion) {
    let phase = PhaseFunction::Isotropic;
    let (rows, distance) = (128, 2.0);
    let mut group = criterion.benchmark_group("frame table");
    for rows in [64, 128, 256] {
        group.bench_function(BenchmarkId::new("build", rows), |bencher| {
            bencher.iter(|| FrameTable::new(&phase, SIGMA_T, black_box(distance), rows));
        });
    }
    let table = FrameTable::new(&phase, SIGMA_T, distance, rows).expect("in range");
    let all = Table::new(&phase, 64).expect("in range");
    let fallback = Quadrature::with_tolerance(phase, 1e-5).expect("in range");
    let framed = Framed::new(table.clone(), fallback);
    let distance = f64::from(distance);
    let (rays, count, length) = (64, 64, 0.125);
    let angles = (0..rays).map(|i| (1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(rays)).acos());
    let angles: Vec<f64> = angles.collect();
    let steps: Vec<Segment> = (angles.iter())
        .flat_map(|&gamma| {
            (0..count).map(move |i| segment(distance, gamma, length * f64::from(i), length))
        })
        .collect();
    let mut airlight = vec![0.0; steps.len()];
    group.throughput(Throughput::Elements(steps.len() as u64));
    let evaluators: [(&str, &dyn Evaluator); 2] = [("table", &all), ("one by one", &framed)];
    for (name, evaluator) in evaluators {
        let [largest, median] = errors(evaluator, phase, &steps);
        println!("steps of a frame: {name}: largest error {largest:.1e}, median {median:.1e}");
        group.bench_function(BenchmarkId::new("steps", name), |bencher| {
            bencher.iter(|| evaluator.airlight_batch(SIGMA_T, black_box(&steps), &mut airlight));
        });
    }
    group.bench_function(BenchmarkId::new("steps", "one lookup each"), |bencher| {
        bencher.iter(|| {
            let mut unknown = 0;
            for (&gamma, airlight) in angles.iter().zip(airlight.chunks_mut(count as usize)) {
                let (foot, h) = (distance * gamma.cos(), distance * gamma.sin());
                let Some(ray) = table.ray(foot as f32, h as f32) else {
                    continue;
                };
                let mut before = ray.at(0.0);
                for (i, airlight) in airlight.iter_mut().enumerate() {
                    let here = ray.at(length as f32 * (i + 1) as f32);
                    let light = before.zip(here).and_then(|(a, b)| ray.between(&a, &b));
                    unknown += u32::from(light.is_none());
                    *airlight = light.unwrap_or(0.0);
                    before = here;
                }
            }
            unknown
        });
    });
    group.finish();
}

criterion_group!(benches, evaluators, march, frame);
criterion_main!(benches);

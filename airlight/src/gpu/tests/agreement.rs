//! Evaluators on a GPU against the CPU, which defines the result.

use std::f64::consts::PI;

use gpu_backend::gpu::{Gpu, InShader, Queued};
use gpu_backend::{Backend, Buffer, Cpu, Download, Error, testing};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use reference::tolerances::Allowed;

use crate::gpu::EvaluatorSlot;
use crate::{
    EvaluateAirlight, Evaluator, FrameTable, Framed, PhaseFunction, Quadrature, Segment, SunTable,
    Table, stiff,
};

/// The relative error that rounding may bring into an airlight behind an
/// optical depth.
fn rounding(depth: f64) -> f64 {
    Allowed::GpuAirlight.error() + depth * Allowed::GpuAirlightDepth.error()
}

fn depth(sigma_t: f32, segment: &Segment) -> f64 {
    let [x, s, h] = [segment.x, segment.s, segment.h].map(f64::from);
    f64::from(sigma_t) * (x + s.hypot(h))
}

pub(super) fn evaluated<A>(
    gpu: &Gpu<Queued>,
    evaluator: &A,
    sigma_t: f32,
    segments: &[Segment],
) -> Vec<f32>
where
    A: Evaluator + InShader<EvaluatorSlot>,
{
    let segments = gpu.upload(segments).unwrap();
    let mut airlight = gpu.zeros(segments.len()).unwrap();
    gpu.evaluate_airlight(evaluator, sigma_t, &segments, &mut airlight)
        .unwrap();
    gpu.download(&airlight).unwrap()
}

/// The stiff cases with the few extinctions that batches have: a case is
/// scaled to the nearest of them, by which its airlight is divided.
pub(super) fn batches(number: usize) -> Vec<(f32, Vec<Segment>)> {
    let mut batches: Vec<(f32, Vec<Segment>)> = Vec::new();
    for (sigma_t, segment) in stiff::cases(number) {
        let batch = 10_f32.powi(sigma_t.log10().round() as i32);
        // Scaling by a factor leaves 0 and signs as they are.
        let factor = sigma_t / batch;
        let Segment { x, s, h, length } = segment;
        let [x, s, h, length] = [x, s, h, length].map(|v| v * factor);
        let segment = Segment { x, s, h, length };
        match batches.iter_mut().find(|(sigma_t, _)| *sigma_t == batch) {
            Some((_, segments)) => segments.push(segment),
            None => batches.push((batch, vec![segment])),
        }
    }
    // In all directions: vacuum, and the optical depth of 100 that leaves next
    // to nothing.
    let rays = |distance: f64| {
        let angles = (0..=40).map(|i| PI * f64::from(i) / 40.0);
        angles.flat_map(move |angle| {
            [0.3, 1.0, 2.0, f64::INFINITY].map(|length| Segment {
                x: 0.0,
                s: (-distance * angle.cos()) as f32,
                h: if angle == PI {
                    0.0
                } else {
                    (distance * angle.sin()) as f32
                },
                length: (distance * length) as f32,
            })
        })
    };
    for (sigma_t, distance) in [
        (0.0, 1.0),
        (1e8, 1e-6),
        (100.0, 1.0),
        (1e-4, 1e6),
        (8e7, 1e-6),
    ] {
        batches.push((sigma_t, rays(distance).collect()));
    }
    batches
}

/// Compares over the stiff cases; all must be within `border` of the CPU, and
/// all but a `share` within rounding.
fn compare<A>(gpu: &Gpu<Queued>, name: &str, evaluator: &A, border: f64, share: f64)
where
    A: Evaluator + InShader<EvaluatorSlot>,
{
    let (mut all, mut different, mut worst) = (0, 0, 0.0_f64);
    for (sigma_t, segments) in batches(4000) {
        let actual = evaluated(gpu, evaluator, sigma_t, &segments);
        for (segment, actual) in segments.iter().zip(actual) {
            let expected = evaluator.airlight(sigma_t, segment);
            assert!(
                (0.0..=f32::MAX).contains(&actual),
                "{name}: {actual} for {sigma_t} {segment:?}"
            );
            if expected == f32::INFINITY {
                assert_eq!(actual, f32::MAX, "{name}: {sigma_t} {segment:?}");
            }
            if !expected.is_normal() {
                // Below the range on one side, next to its end on the other.
                assert!(
                    expected > 0.0 || actual < 1.001 * f32::MIN_POSITIVE,
                    "{name}: {expected} on the CPU, {actual} on the GPU for {sigma_t} {segment:?}"
                );
                continue;
            }
            let rounding = rounding(depth(sigma_t, segment));
            let error = (f64::from(actual) / f64::from(expected) - 1.0).abs();
            let is_lowest = expected < 1.001 * f32::MIN_POSITIVE;
            assert!(
                error <= rounding + border || is_lowest,
                "{name}: {expected} on the CPU, {actual} on the GPU for {sigma_t} {segment:?}"
            );
            all += 1;
            if error <= rounding {
                worst = worst.max(error / rounding);
            } else {
                different += 1;
            }
        }
    }
    println!("{name}: {different} of {all} elsewhere, {worst} of the rounding");
    assert!(
        f64::from(different) <= share * f64::from(all),
        "{name}: {different} of {all}"
    );
}

const PHASES: [PhaseFunction; 8] = [
    PhaseFunction::Isotropic,
    PhaseFunction::Rayleigh,
    PhaseFunction::HenyeyGreenstein { g: 0.9 },
    PhaseFunction::HenyeyGreenstein { g: -0.9 },
    PhaseFunction::Schlick { k: 0.9 },
    PhaseFunction::CornetteShanks { g: -0.7 },
    PhaseFunction::DoubleHenyeyGreenstein {
        g: [0.85, -0.6],
        weight: 0.7,
    },
    PhaseFunction::HenyeyGreensteinDraine {
        g: 0.9,
        draine_g: 0.55,
        alpha: 21.0,
        weight: 0.48,
    },
];

#[test]
fn tables_agree_with_the_cpu_but_for_lookups_on_the_border_of_a_cell() {
    let Some(gpu) = testing::gpu() else { return };
    for phase in PHASES {
        let table = Table::new(&phase, 32).unwrap();
        let border = 2.0 * f64::from(table.error_bound());
        compare(
            &gpu,
            &format!("table {phase:?}"),
            &table,
            border,
            Allowed::GpuAirlightBorder.error(),
        );
    }
}

#[test]
fn fixed_quadratures_agree_with_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    for phase in PHASES {
        for nodes in [1, 4, 10] {
            let quadrature = Quadrature::fixed(phase, nodes).unwrap();
            compare(
                &gpu,
                &format!("{nodes} nodes {phase:?}"),
                &quadrature,
                0.0,
                0.0,
            );
        }
    }
}

#[test]
fn quadratures_with_a_tolerance_agree_with_the_cpu_but_for_pieces_between_two_rules() {
    let Some(gpu) = testing::gpu() else { return };
    for phase in PHASES {
        for tolerance in [1e-1, 1e-3, 1e-5] {
            let quadrature = Quadrature::with_tolerance(phase, tolerance).unwrap();
            let border = 2.0 * f64::from(tolerance);
            compare(
                &gpu,
                &format!("{tolerance} {phase:?}"),
                &quadrature,
                border,
                Allowed::GpuAirlightBorder.error(),
            );
        }
    }
}

/// Runs and steps of rays from the eye of the table and from elsewhere. What one side
/// looks up and the other one integrates is as far off as the table.
#[test]
fn tables_of_frames_agree_with_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    for phase in PHASES {
        for (sigma_t, distance) in [(0.0, 3.0), (0.1, 2.0), (0.5, 4.0), (2.0, 5.0)] {
            let fallback = Quadrature::with_tolerance(phase, 1e-5).unwrap();
            let table = FrameTable::new(&phase, sigma_t, distance, 128).unwrap();
            let framed = Framed::new(table, fallback);
            let mut segments = Vec::new();
            for i in 0..=60 {
                let angle = PI * f64::from(i) / 60.0;
                let (foot, h) = (distance * angle.cos() as f32, distance * angle.sin() as f32);
                let h = if i == 60 { 0.0 } else { h };
                for share in [0.0, 0.3, 0.99, 1.0, 1.4, 6.0] {
                    let x = share * distance;
                    for length in [0.01, 0.4, 2.0, f32::INFINITY] {
                        let (s, length) = (x - foot, length * distance);
                        segments.push(Segment { x, s, h, length });
                    }
                }
                let (x, s) = (0.0, -foot - 1.0);
                segments.push(Segment {
                    x,
                    s,
                    h,
                    length: 1.0,
                });
            }
            let actual = evaluated(&gpu, &framed, sigma_t, &segments);
            let mut elsewhere = 0;
            for (segment, actual) in segments.iter().zip(actual) {
                let expected = framed.airlight(sigma_t, segment);
                if !expected.is_normal() {
                    let is_alike = expected == f32::INFINITY && actual == f32::MAX;
                    assert!(
                        is_alike || actual < 1.001 * f32::MIN_POSITIVE,
                        "{segment:?}"
                    );
                    continue;
                }
                let error = (f64::from(actual) / f64::from(expected) - 1.0).abs();
                // A difference keeps 1/1024 of the digits of what is subtracted.
                let lost = 1024.0 * f64::from(f32::EPSILON);
                let allowed = lost + rounding(depth(sigma_t, segment));
                elsewhere += usize::from(error > allowed);
                assert!(
                    error <= 0.03,
                    "{phase:?} {sigma_t} {segment:?}: {expected} on the CPU, {actual} on the GPU"
                );
            }
            assert!(
                100 * elsewhere <= segments.len(),
                "{phase:?} {sigma_t}: {elsewhere}"
            );
        }
    }
}

/// Any f32 at all, ordinary ones more often than others.
fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => (-8.0_f32..8.0).prop_map(|e| 10_f32.powf(e)),
        2 => (-8.0_f32..8.0).prop_map(|e| -10_f32.powf(e)),
        2 => any::<u32>().prop_map(f32::from_bits),
        2 => prop::sample::select(vec![0.0, -0.0, 1.0, -1.0, f32::MAX, f32::INFINITY, f32::NAN, 1e-45]),
    ]
}

#[test]
fn no_segment_gives_anything_but_a_number() {
    let Some(gpu) = testing::gpu() else { return };
    let table = Table::new(&PhaseFunction::Rayleigh, 16).unwrap();
    let quadrature =
        Quadrature::with_tolerance(PhaseFunction::CornetteShanks { g: -0.999_999_94 }, 1e-4)
            .unwrap();
    let sun_table = SunTable::new();
    let framed = FrameTable::new(&PhaseFunction::Rayleigh, 1.0, 1.0, 16).unwrap();
    let fallback = Quadrature::with_tolerance(PhaseFunction::Rayleigh, 1e-4).unwrap();
    let framed = Framed::new(framed, fallback);
    let segment = [(); 4]
        .map(|()| any_number())
        .prop_map(|[x, s, h, length]| Segment { x, s, h, length });
    let input = (any_number(), prop::collection::vec(segment, 1000));
    // Drawn here and not by the runner, which would print a thousand segments
    // for the one that fails.
    let mut runner = TestRunner::deterministic();
    for _ in 0..40 {
        let (sigma_t, segments) = input.new_tree(&mut runner).unwrap().current();
        for (name, results) in [
            ("table", evaluated(&gpu, &table, sigma_t, &segments)),
            (
                "table of a frame",
                evaluated(&gpu, &framed, sigma_t, &segments),
            ),
            (
                "quadrature",
                evaluated(&gpu, &quadrature, sigma_t, &segments),
            ),
            (
                "published table",
                evaluated(&gpu, &sun_table, sigma_t, &segments),
            ),
        ] {
            for (segment, value) in segments.iter().zip(results) {
                let case = format!("{name} {sigma_t} {segment:?}");
                assert!((0.0..=f32::MAX).contains(&value), "{case}: {value}");
                let Segment { x, s, h, length } = *segment;
                let are_lengths =
                    x.is_finite() && s.is_finite() && h >= 0.0 && h.is_finite() && length > 0.0;
                if !(are_lengths && sigma_t >= 0.0 && sigma_t.is_finite()) {
                    assert_eq!(value, 0.0, "{case}");
                } else if h == 0.0 && s <= 0.0 && s + length >= f32::MIN_POSITIVE {
                    assert_eq!(value, f32::MAX, "{case}");
                }
            }
        }
    }
}

#[test]
fn empty_batches_and_wrong_lengths_are_handled_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let quadrature = Quadrature::fixed(PhaseFunction::Isotropic, 4).unwrap();
    assert!(evaluated(&gpu, &quadrature, 1.0, &[]).is_empty());
    let segments = gpu.zeros::<Segment>(3).unwrap();
    let mut short = gpu.zeros(2).unwrap();
    let error = gpu
        .evaluate_airlight(&quadrature, 1.0, &segments, &mut short)
        .unwrap_err();
    assert!(matches!(
        error,
        Error::LengthMismatch {
            expected: 3,
            actual: 2,
            ..
        }
    ));
    let segments = vec![Segment::default(); 3];
    let error = Cpu::new()
        .evaluate_airlight(&quadrature, 1.0, &segments, &mut vec![0.0; 2])
        .unwrap_err();
    assert!(matches!(
        error,
        Error::LengthMismatch {
            expected: 3,
            actual: 2,
            ..
        }
    ));
}

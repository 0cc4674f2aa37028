//! Tables against airlight in double precision.

use std::f64::consts::PI;

use proptest::prelude::*;
use reference::random::halton;

use super::batch::Batch;
use super::*;
use crate::{Exact, PhaseFunction, ScatteringAngle, Segment64};

/// γ from 0 to π, close to both ends too.
fn angles(steps: i32) -> impl Iterator<Item = f64> {
    let near = (0..steps).map(move |i| 10_f64.powf(-8.0 * f64::from(i) / f64::from(steps)));
    let inner = (0..steps).map(move |i| PI * (f64::from(i) + 0.5) / f64::from(steps));
    let away = near.clone().map(|gamma| PI - gamma);
    near.chain(away).chain(inner).chain([0.0, PI, 0.5 * PI])
}

/// The parts of a ray that a sweep looks at: where they start and how long they
/// are, over D.
const PARTS: [(f64, f64); 18] = [
    (0.0, f64::INFINITY),
    (0.0, 0.5),
    (0.0, 0.9),
    (0.0, 1.1),
    (0.0, 2.0),
    (0.0, 30.0),
    (0.0, 1e-9),
    (0.0, 1e-3),
    (0.3, 1e-4),
    (0.7, 1e-9),
    (0.7, 0.1),
    (0.9, 0.2),
    (0.99, 1e-6),
    (1.0, 1e-3),
    (1.5, 1e-7),
    (1.5, f64::INFINITY),
    (3.0, 0.3),
    (8.0, 4.0),
];

/// The relative error against the truth, if both are normal numbers.
fn error(table: &Table, exact: &Exact<impl Phase>, sigma_t: f32, segment: &Segment) -> Option<f64> {
    let truth = exact.airlight(sigma_t.into(), &Segment64::from(*segment));
    let normal = f64::from(f32::MIN_POSITIVE) * 1.0001..f64::from(f32::MAX) * 0.9999;
    let value = table.airlight(sigma_t, segment);
    assert!(!value.is_nan(), "NaN for {sigma_t} {segment:?}");
    normal
        .contains(&truth)
        .then(|| (f64::from(value) / truth - 1.0).abs())
}

/// The largest error of a sweep over directions, optical depths, distances and
/// parts, and where it is.
fn sweep(
    table: &Table,
    exact: &Exact<impl Phase>,
    steps: i32,
    distances: &[f64],
) -> (f64, f32, Segment, usize) {
    let mut worst = (0.0, 0.0, Segment::default(), 0);
    for &distance in distances {
        for tau in (-8 * 3..=2 * 3 + 1).map(|i| 10_f64.powf(f64::from(i) / 3.0)) {
            let sigma_t = (tau / distance) as f32;
            for gamma in angles(steps) {
                for (start, length) in PARTS {
                    let x = start * distance;
                    let segment = Segment {
                        x: x as f32,
                        s: (x - distance * gamma.cos()) as f32,
                        h: (distance * gamma.sin()) as f32,
                        length: (length * distance) as f32,
                    };
                    if let Some(error) = error(table, exact, sigma_t, &segment) {
                        worst.3 += 1;
                        if !(error <= worst.0) {
                            worst = (error, sigma_t, segment, worst.3);
                        }
                    }
                }
            }
        }
    }
    worst
}

#[test]
fn isotropic_airlight_is_within_one_in_ten_thousand() -> Result<(), Error> {
    let table = Table::new(&PhaseFunction::Isotropic, 64)?;
    assert!(table.bytes() <= 65_536);
    assert!(table.error_bound() <= 1e-4, "{}", table.error_bound());
    let exact = Exact::new(PhaseFunction::Isotropic)?;
    let worst = sweep(&table, &exact, 12, &[1e-6, 1e-3, 1.0, 37.0, 1e6]);
    assert!(worst.3 > 50_000, "{} results in range", worst.3);
    assert!(worst.0 <= f64::from(table.error_bound()), "{worst:?}");
    Ok(())
}

#[test]
fn the_error_bound_holds_for_every_phase_function_and_size() -> Result<(), Error> {
    let functions = [
        PhaseFunction::Isotropic,
        PhaseFunction::Rayleigh,
        PhaseFunction::HenyeyGreenstein { g: 0.6 },
        PhaseFunction::HenyeyGreenstein { g: 0.95 },
        PhaseFunction::HenyeyGreenstein { g: -0.6 },
        PhaseFunction::HenyeyGreenstein { g: -0.95 },
        PhaseFunction::Schlick { k: 0.9 },
        PhaseFunction::CornetteShanks { g: 0.8 },
        PhaseFunction::DoubleHenyeyGreenstein {
            g: [0.85, -0.6],
            weight: 0.7,
        },
        PhaseFunction::droplets(10.0)?,
    ];
    for phase in functions {
        let exact = Exact::new(phase)?;
        for kibibytes in [16, 32, 64] {
            let table = Table::new(&phase, kibibytes)?;
            assert!(table.bytes() <= kibibytes as usize * 1024);
            let worst = sweep(&table, &exact, 5, &[0.7]);
            let bound = f64::from(table.error_bound());
            assert!(
                worst.0 <= bound,
                "{phase:?}, {kibibytes} KiB, {bound:e}: {worst:?}"
            );
        }
    }
    Ok(())
}

/// Eight whole rays for each cell of a table, spread by a Halton sequence over
/// direction and optical depth.
///
/// The error of a cell is that of a parabola through three zeros in each axis: it
/// changes its sign three times and comes near its largest value in a quarter of
/// the cell. Eight points leave one cell in ten without a look into that
/// quarter; a bound that is broken is so in the many cells around the worst one.
/// Directions are even in the angle for one half of the points, and even in its
/// logarithm from either end for the other.
#[test]
fn whole_rays_through_every_cell_are_within_the_bound() -> Result<(), Error> {
    for (phase, kibibytes) in [
        (PhaseFunction::Isotropic, 64),
        (PhaseFunction::HenyeyGreenstein { g: 0.85 }, 64),
        (PhaseFunction::HenyeyGreenstein { g: -0.9 }, 32),
        (PhaseFunction::Schlick { k: 0.9 }, 64),
        (PhaseFunction::CornetteShanks { g: 0.8 }, 64),
    ] {
        let exact = Exact::new(phase)?;
        let table = Table::new(&phase, kibibytes)?;
        let mut worst = (0.0, 0.0, Segment::default());
        for index in 0..8 * table.cells.len() as u32 {
            let (u, v) = (halton(index, 2), halton(index, 3));
            let gamma = match index / 2 % 4 {
                0 | 1 => PI * u,
                2 => 10_f64.powf(-6.0 * u),
                _ => PI - 10_f64.powf(-6.0 * u),
            };
            let segment = Segment {
                x: 0.0,
                s: -gamma.cos() as f32,
                h: gamma.sin() as f32,
                length: f32::INFINITY,
            };
            let sigma_t = 10_f64.powf(7.0 * v - 5.0) as f32;
            if let Some(error) = error(&table, &exact, sigma_t, &segment)
                && !(error <= worst.0)
            {
                worst = (error, sigma_t, segment);
            }
        }
        let bound = f64::from(table.error_bound());
        assert!(
            worst.0 <= bound,
            "{phase:?}, {kibibytes} KiB, {bound:e}: {worst:?}"
        );
    }
    Ok(())
}

#[test]
fn a_function_of_the_users_own_has_a_table_with_a_bound() -> Result<(), Error> {
    // A forward lobe and a faint backward one, normalised.
    let phase = |angle: ScatteringAngle<f64>| {
        let cos = angle.cos();
        let lobe = 0.5 * (1.0 + cos);
        (0.8 * 5.0 * lobe.powi(4) + 0.2 * 1.5 * (1.0 + cos * cos) / 2.0) / (4.0 * PI)
    };
    let table = Table::new(&phase, 64)?;
    assert!(table.error_bound() < 1e-3, "{}", table.error_bound());
    let worst = sweep(&table, &Exact::new(phase)?, 5, &[2.0]);
    assert!(
        worst.0 <= f64::from(table.error_bound()),
        "{} {worst:?}",
        table.error_bound()
    );
    Ok(())
}

#[test]
fn the_light_on_the_segment_gives_infinity_and_no_length_gives_nothing() -> Result<(), Error> {
    let table = Table::new(&PhaseFunction::Isotropic, 16)?;
    let airlight = |x, s, h, length| table.airlight(0.5, &Segment { x, s, h, length });
    assert_eq!(airlight(0.0, -1.0, 0.0, 2.0), f32::INFINITY);
    assert_eq!(airlight(0.0, -1.0, 0.0, 1.0), f32::INFINITY);
    assert_eq!(airlight(0.0, 0.0, 0.0, 1.0), f32::INFINITY);
    assert_eq!(airlight(0.0, -1.0, 0.0, f32::INFINITY), f32::INFINITY);
    assert_eq!(airlight(0.0, -1.0, 0.0, 0.0), 0.0);
    assert_eq!(airlight(0.0, 0.0, 0.0, 0.0), 0.0);
    assert!(airlight(0.0, -1.0, 0.0, 0.5) > 0.0);
    assert!(airlight(0.0, 1.0, 0.0, f32::INFINITY) > 0.0);
    Ok(())
}

#[test]
fn no_medium_leaves_the_angle_that_the_segment_covers() -> Result<(), Error> {
    let table = Table::new(&PhaseFunction::Isotropic, 64)?;
    let exact = Exact::new(PhaseFunction::Isotropic)?;
    for gamma in angles(20) {
        for (x, length) in PARTS {
            let segment = Segment {
                x: x as f32,
                s: (x - gamma.cos()) as f32,
                h: gamma.sin() as f32,
                length: length as f32,
            };
            if let Some(error) = error(&table, &exact, 0.0, &segment) {
                assert!(
                    error <= table.error_bound().into(),
                    "{segment:?}: {error:e}"
                );
            }
        }
    }
    Ok(())
}

#[test]
fn parts_that_end_just_before_the_light_are_bright() -> Result<(), Error> {
    let table = Table::new(&PhaseFunction::Isotropic, 64)?;
    let exact = Exact::new(PhaseFunction::Isotropic)?;
    // The distances of the ends from the light, and their inverses, are in
    // range, but not products of three of them.
    let segment = Segment {
        x: 1.753_356_6e-5,
        s: -6.983_191_7e-13,
        h: 0.0,
        length: 6.982_921e-13,
    };
    let error = error(&table, &exact, 1e-4, &segment).unwrap();
    assert!(error <= table.error_bound().into(), "{error:e}");
    Ok(())
}

#[test]
fn unusable_parameters_are_errors() {
    for kibibytes in [0, 3, 1025, u32::MAX] {
        assert!(Table::new(&PhaseFunction::Isotropic, kibibytes).is_err());
    }
    let phase = PhaseFunction::HenyeyGreenstein { g: 1.0 };
    assert!(Table::new(&phase, 64).is_err());
}

#[test]
fn the_smallest_table_of_the_sharpest_function_still_gives_numbers() -> Result<(), Error> {
    for g in [-0.999_999, 0.999_999] {
        let table = Table::new(&PhaseFunction::HenyeyGreenstein { g }, 4)?;
        assert!(table.bytes() <= 4096);
        assert!(table.error_bound() > 0.0);
        let segment = Segment {
            x: 0.0,
            s: -1.0,
            h: 0.1,
            length: 2.0,
        };
        assert!(table.airlight(1.0, &segment).is_finite());
    }
    Ok(())
}

#[test]
fn the_steps_of_a_march_have_the_bits_of_single_segments_and_add_up() -> Result<(), Error> {
    for phase in [
        PhaseFunction::Isotropic,
        PhaseFunction::HenyeyGreenstein { g: 0.8 },
    ] {
        let table = Table::new(&phase, 64)?;
        let step = 1.0 / 64.0;
        let mut steps: Vec<Segment> = (0..320)
            .map(|i| {
                let x = i as f32 * step;
                Segment {
                    x,
                    s: x - 1.0,
                    h: 0.75,
                    length: step,
                }
            })
            .collect();
        let mut airlight = vec![f32::NAN; steps.len()];
        table.airlight_batch(0.5, &steps, &mut airlight);
        for (segment, value) in steps.iter().zip(&airlight) {
            assert_eq!(value.to_bits(), table.airlight(0.5, segment).to_bits());
        }
        let whole = table.airlight(
            0.5,
            &Segment {
                length: 5.0,
                ..steps[0]
            },
        );
        let sum: f32 = airlight.iter().sum();
        assert!(
            (sum / whole - 1.0).abs() <= 2.0 * table.error_bound(),
            "{sum} {whole}"
        );
        // One that is nothing and one with the light on it.
        steps[3].length = 0.0;
        steps[70] = Segment {
            x: 0.0,
            s: -0.01,
            h: 0.0,
            length: 0.02,
        };
        table.airlight_batch(0.5, &steps, &mut airlight);
        assert_eq!((airlight[3], airlight[70]), (0.0, f32::INFINITY));
    }
    Ok(())
}

#[test]
fn a_march_has_the_airlight_of_its_steps() -> Result<(), Error> {
    for phase in [
        PhaseFunction::Isotropic,
        PhaseFunction::HenyeyGreenstein { g: 0.8 },
        PhaseFunction::HenyeyGreenstein { g: -0.6 },
    ] {
        let (table, exact) = (Table::new(&phase, 64)?, Exact::new(phase)?);
        let mut compared = 0;
        for (foot, h) in [
            (1.0, 0.75),
            (3.0, 1e-3),
            (2.0, 1e-9),
            (-0.5, 0.1),
            (0.0, 2.0),
        ] {
            let ray = Segment {
                x: 0.0,
                s: -foot,
                h,
                length: 0.0,
            };
            // Steps of equal length, which are short beside the light and long next
            // to it, and ones that grow; in blocks that are full and that are not.
            for (count, growth) in [(1, 1.0), (64, 1.0), (100, 1.0), (1000, 1.0), (150, 1.06)] {
                let share = 8.0 / count as f32;
                let mut ends: Vec<f32> = (0..count)
                    .map(|i| match growth {
                        1.0 => share * (i + 1) as f32,
                        _ => 0.002 * f32::powi(growth, i),
                    })
                    .collect();
                if let Some(last) = ends.get_mut(count as usize - 1) {
                    *last = f32::INFINITY;
                }
                let mut airlight = vec![f32::NAN; ends.len()];
                for sigma_t in [0.0, 1e-3, 0.3, 4.0] {
                    table.march(sigma_t, &ray, &ends, &mut airlight);
                    let mut from = 0.0;
                    for (&end, &value) in ends.iter().zip(&airlight) {
                        let step = ray.part(from, end);
                        let truth = exact.airlight(sigma_t.into(), &step.into());
                        from = end;
                        if truth < f64::from(f32::MIN_POSITIVE) {
                            continue;
                        }
                        compared += 1;
                        let error = (f64::from(value) / truth - 1.0).abs();
                        let bound = f64::from(table.error_bound());
                        assert!(
                            error <= bound,
                            "{phase:?} {sigma_t} {step:?}: {error:e} of {bound:e}"
                        );
                    }
                }
            }
        }
        assert!(compared > 20_000, "{compared}");
    }
    Ok(())
}

#[test]
fn steps_of_a_march_that_are_none_have_no_airlight() -> Result<(), Error> {
    let table = Table::new(&PhaseFunction::Isotropic, 16)?;
    let ray = Segment {
        x: 0.0,
        s: -1.0,
        h: 0.0,
        length: 4.0,
    };
    let mut airlight = [f32::NAN; 6];
    let ends = [0.5, 0.5, 0.4, 1.5, f32::NAN, 2.0];
    table.march(0.5, &ray, &ends, &mut airlight);
    assert!(airlight[0] > 0.0);
    assert_eq!(airlight[1..], [0.0, 0.0, f32::INFINITY, 0.0, 0.0]);
    for sigma_t in [f32::NAN, -1.0, f32::INFINITY] {
        table.march(sigma_t, &ray, &ends, &mut airlight);
        assert_eq!(airlight, [0.0; 6]);
    }
    table.march(0.5, &ray, &[], &mut []);
    Ok(())
}

/// Any f32 at all, ordinary ones more often than others.
fn any_length() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => (-8.0_f32..8.0).prop_map(|e| 10_f32.powf(e)),
        2 => (-8.0_f32..8.0).prop_map(|e| -10_f32.powf(e)),
        1 => any::<u32>().prop_map(f32::from_bits),
        1 => prop::sample::select(vec![0.0, -0.0, 1.0, -1.0, f32::INFINITY, f32::NAN]),
    ]
}

fn any_segment() -> impl Strategy<Value = Segment> {
    [any_length(), any_length(), any_length(), any_length()].prop_map(|[x, s, h, length]| Segment {
        x,
        s,
        h,
        length,
    })
}

proptest! {
    #![proptest_config(reference::property::cases(256))]

    #[test]
    fn batches_give_the_bits_of_single_segments_with_any_instructions(
        segments in prop::collection::vec(any_segment(), 0..300),
        sigma_t in any_length(),
        isotropic: bool,
    ) {
        let phase = if isotropic {
            PhaseFunction::Isotropic
        } else {
            PhaseFunction::Rayleigh
        };
        static TABLES: std::sync::OnceLock<[Table; 2]> = std::sync::OnceLock::new();
        let tables = TABLES.get_or_init(|| {
            [PhaseFunction::Isotropic, PhaseFunction::Rayleigh].map(|phase| Table::new(&phase, 16).unwrap())
        });
        let table = &tables[usize::from(phase != PhaseFunction::Isotropic)];
        let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let one_by_one: Vec<f32> = segments.iter().map(|s| table.airlight(sigma_t, s)).collect();
        for (segment, value) in segments.iter().zip(&one_by_one) {
            prop_assert!(*value >= 0.0, "{} for {:?}", value, segment);
        }
        let mut batch = vec![f32::NAN; segments.len()];
        table.airlight_batch(sigma_t, &segments, &mut batch);
        prop_assert_eq!(bits(&batch), bits(&one_by_one));
        if let Some(lookup) = table.lookup(sigma_t) {
            for arch in simd::every_arch() {
                batch.fill(f32::NAN);
                simd::batch_on(arch, &Batch { table, lookup }, &segments, &mut batch);
                prop_assert_eq!(bits(&batch), bits(&one_by_one), "{:?}", arch);
            }
        }
    }
}

#[test]
fn what_is_no_phase_function_is_refused() {
    for value in [f64::NAN, -1.0, f64::INFINITY] {
        let error = Table::new(&move |_: ScatteringAngle<f64>| value, 16).unwrap_err();
        assert!(error.to_string().starts_with("a phase function is"));
    }
}

#[test]
fn parts_that_end_at_the_foot_point_are_within_the_bound() -> Result<(), Error> {
    for phase in [
        PhaseFunction::HenyeyGreenstein { g: 0.8 },
        PhaseFunction::HenyeyGreenstein { g: 0.9 },
        PhaseFunction::Schlick { k: 0.99 },
    ] {
        let exact = Exact::new(phase)?;
        for kibibytes in [16, 32, 64] {
            let table = Table::new(&phase, kibibytes)?;
            for step in 1..60_u16 {
                let gamma = f32::from(step) * 0.026;
                let (s, h) = (-gamma.cos(), gamma.sin());
                for share in [0.8, 0.95, 0.99, 1.0, 1.001, 1.05, 1.2] {
                    let segment = Segment {
                        x: 0.0,
                        s,
                        h,
                        length: -s * share,
                    };
                    for sigma_t in [1e-4_f32, 0.01, 1.0] {
                        let truth = exact.airlight(sigma_t.into(), &segment.into());
                        let value = Evaluator::airlight(&table, sigma_t, &segment);
                        let error = (f64::from(value) / truth - 1.0).abs();
                        let bound = f64::from(table.error_bound());
                        assert!(
                            error <= bound,
                            "{phase:?} {kibibytes} KiB {segment:?}: {error:e} of {bound:e}"
                        );
                    }
                }
            }
        }
    }
    Ok(())
}

#[test]
fn short_parts_anywhere_are_within_the_bound() -> Result<(), Error> {
    for phase in [
        PhaseFunction::Isotropic,
        PhaseFunction::Rayleigh,
        PhaseFunction::HenyeyGreenstein { g: 0.6 },
        PhaseFunction::HenyeyGreenstein { g: 0.95 },
        PhaseFunction::HenyeyGreenstein { g: -0.6 },
        PhaseFunction::HenyeyGreenstein { g: -0.95 },
        PhaseFunction::Schlick { k: 0.9 },
        PhaseFunction::CornetteShanks { g: 0.8 },
        PhaseFunction::DoubleHenyeyGreenstein {
            g: [0.85, -0.6],
            weight: 0.7,
        },
        PhaseFunction::droplets(10.0)?,
    ] {
        let exact = Exact::new(phase)?;
        for kibibytes in [8, 64, 128] {
            let table = Table::new(&phase, kibibytes)?;
            let bound = f64::from(table.error_bound());
            let mut worst = (0.0, 0.0, Segment::default());
            for half in (0..80).map(|i| 10_f64.powf(f64::from(i - 40) / 10.0)) {
                // The start at the distance 1 from the light, from close to the
                // axis in front of it to close to the axis behind it.
                let d = 1.0 + half * half;
                let (s, h) = ((half * half - 1.0) / d, 2.0 * half / d);
                for length in (0..40).map(|i| 10_f64.powf(f64::from(i - 27) / 10.0)) {
                    for (x, sigma_t) in [(0.0, 1e-3), (0.0, 0.3), (0.0, 3.0), (1.0, 30.0)] {
                        let segment = Segment {
                            x,
                            s: s as f32,
                            h: h as f32,
                            length: length as f32,
                        };
                        if let Some(error) = error(&table, &exact, sigma_t, &segment)
                            && !(error <= worst.0)
                        {
                            worst = (error, sigma_t, segment);
                        }
                    }
                }
            }
            assert!(
                worst.0 <= bound,
                "{phase:?}, {kibibytes} KiB, {bound:e}: {worst:?}"
            );
        }
    }
    Ok(())
}

/// Parts just below the longest that are integrated without a look into the
/// table, where independent sweeps once found the bound broken.
///
/// There are 150 directions per decade of tan(θ/2). The error of the stored phase
/// function changes its sign three times per row, of which there are at most some
/// 60 for each side, crowded where the function is steep: ten directions and more
/// for each. That of the rule varies with the direction on the scale of a factor of
/// 1.25, and grows with the length. A sweep of 60,000 segments through 65 tables of
/// 13 functions found no error above 0.93 of the bound.
#[test]
fn the_longest_near_parts_are_within_the_bound() -> Result<(), Error> {
    let cases = [
        (PhaseFunction::HenyeyGreenstein { g: 0.95 }, 64),
        (PhaseFunction::HenyeyGreenstein { g: 0.85 }, 128),
        (PhaseFunction::CornetteShanks { g: 0.9 }, 128),
        (PhaseFunction::Schlick { k: 0.99 }, 32),
        (PhaseFunction::HenyeyGreenstein { g: -0.99 }, 64),
        (PhaseFunction::HenyeyGreenstein { g: -0.99 }, 256),
        (PhaseFunction::HenyeyGreenstein { g: -0.997 }, 64),
    ];
    for (phase, kibibytes) in cases {
        let exact = Exact::new(phase)?;
        let table = Table::new(&phase, kibibytes)?;
        let mut worst = (0.0, 0.0, Segment::default());
        for step in 0..1200 {
            let half = 10_f64.powf(f64::from(step - 600) / 150.0);
            let d = 1.0 + half * half;
            let (s, h) = ((half * half - 1.0) / d, 2.0 * half / d);
            for length in [0.01, 0.05, 0.1, 0.115, 0.12495] {
                for sigma_t in [0.0, 1e-3, 0.1, 0.3, 1.0, 1.38] {
                    let segment = Segment {
                        x: 0.0,
                        s: s as f32,
                        h: h as f32,
                        length,
                    };
                    if let Some(error) = error(&table, &exact, sigma_t, &segment)
                        && !(error <= worst.0)
                    {
                        worst = (error, sigma_t, segment);
                    }
                }
            }
        }
        let bound = f64::from(table.error_bound());
        assert!(
            worst.0 <= bound,
            "{phase:?}, {kibibytes} KiB, {bound:e}: {worst:?}"
        );
    }
    Ok(())
}

#[test]
fn rays_that_pass_the_light_within_the_root_of_the_smallest_number_keep_the_bound()
-> Result<(), Error> {
    for phase in [
        PhaseFunction::Isotropic,
        PhaseFunction::HenyeyGreenstein { g: 0.8 },
        PhaseFunction::HenyeyGreenstein { g: -0.8 },
    ] {
        let (exact, table) = (Exact::new(phase)?, Table::new(&phase, 32)?);
        let mut compared = 0;
        let (mut segments, mut values) = (Vec::new(), Vec::new());
        // Distances from the light at which a segment starts or ends: from those
        // whose squares lose digits to those whose inverse is out of range.
        let close = (0..60).map(|i| 10_f32.powf(-16.0 - 0.37 * i as f32));
        for h in close.clone().chain([0.0]) {
            for near in [0.0, h, 0.3 * h, 1e-19, 3e-17] {
                for segment in [
                    [-1.0, 1.0],
                    [-1.0, 1.0 - near],
                    [-1.0, 2.0],
                    [near, 1.0],
                    [-near, 1.0],
                    [near, 3.0 * (near + h)],
                    [-near, 3.0 * (near + h)],
                    [-near, 0.2 * (near + h)],
                    [-near, f32::INFINITY],
                ]
                .map(|[s, length]| Segment {
                    x: 0.0,
                    s,
                    h,
                    length,
                }) {
                    segments.push(segment);
                    values.push(table.airlight(0.5, &segment));
                    if let Some(error) = error(&table, &exact, 0.5, &segment) {
                        compared += 1;
                        let bound = f64::from(table.error_bound());
                        assert!(error <= bound, "{phase:?} {segment:?}: {error:e}");
                    }
                }
            }
        }
        assert!(compared > 1500, "{compared}");
        let mut batch = vec![f32::NAN; segments.len()];
        table.airlight_batch(0.5, &segments, &mut batch);
        assert_eq!(batch, values);
    }
    Ok(())
}

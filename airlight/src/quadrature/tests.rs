//! What must hold of [`Quadrature`].

use super::*;
use crate::Exact;
use crate::stiff;

/// Functions without a peak, and with sharp ones.
const PHASES: [PhaseFunction; 17] = [
    PhaseFunction::Isotropic,
    PhaseFunction::Rayleigh,
    PhaseFunction::HenyeyGreenstein { g: 0.6 },
    PhaseFunction::HenyeyGreenstein { g: 0.8 },
    PhaseFunction::HenyeyGreenstein { g: 0.99 },
    PhaseFunction::HenyeyGreenstein { g: -0.99 },
    PhaseFunction::HenyeyGreenstein { g: -0.9 },
    PhaseFunction::Schlick { k: 0.95 },
    PhaseFunction::Schlick { k: 0.99 },
    PhaseFunction::Schlick { k: -0.99 },
    PhaseFunction::CornetteShanks { g: 0.9 },
    PhaseFunction::CornetteShanks { g: 0.99 },
    PhaseFunction::CornetteShanks { g: -0.8 },
    PhaseFunction::CornetteShanks { g: -0.99 },
    PhaseFunction::DoubleHenyeyGreenstein {
        g: [0.85, -0.6],
        weight: 0.7,
    },
    PhaseFunction::HenyeyGreensteinDraine {
        g: 0.988,
        draine_g: 0.55,
        alpha: 21.0,
        weight: 0.48,
    },
    PhaseFunction::HenyeyGreensteinDraine {
        g: -0.3,
        draine_g: -0.9,
        alpha: 250.0,
        weight: 0.9,
    },
];

/// The sharpest peaks for which tolerances are promised.
const SHARPEST: [PhaseFunction; 9] = [
    PhaseFunction::HenyeyGreenstein { g: 0.9999 },
    PhaseFunction::HenyeyGreenstein { g: -0.9999 },
    PhaseFunction::Schlick { k: 0.9999 },
    PhaseFunction::Schlick { k: -0.9999 },
    PhaseFunction::Schlick { k: -0.999 },
    PhaseFunction::CornetteShanks { g: 0.9999 },
    PhaseFunction::CornetteShanks { g: -0.9999 },
    PhaseFunction::DoubleHenyeyGreenstein {
        g: [0.9999, -0.9999],
        weight: 0.5,
    },
    PhaseFunction::HenyeyGreensteinDraine {
        g: 0.9979,
        draine_g: 0.625,
        alpha: 32.3,
        weight: 0.5,
    },
];

/// The largest relative error over the stiff cases, and where.
fn worst(quadrature: &Quadrature, truths: &[(f32, Segment, f64)]) -> (f64, usize) {
    let mut worst = (0.0, 0);
    for (index, (sigma_t, segment, truth)) in truths.iter().enumerate() {
        let mut values = [quadrature.airlight(*sigma_t, segment); 2];
        quadrature.airlight_batch(*sigma_t, &[*segment], &mut values[1..]);
        for value in values {
            let error = (f64::from(value) / truth - 1.0).abs();
            if !(error <= worst.0) {
                worst = (error, index);
            }
        }
    }
    worst
}

fn truths(phase: PhaseFunction, number: usize) -> Vec<(f32, Segment, f64)> {
    let exact = Exact::new(phase).unwrap();
    stiff::cases(number)
        .into_iter()
        .chain(stiff::spread(number as u32))
        .map(|(sigma_t, segment)| {
            let truth = exact.airlight(sigma_t.into(), &segment.into());
            (sigma_t, segment, truth)
        })
        .filter(|(.., truth)| *truth > f64::from(f32::MIN_POSITIVE) && *truth < 1e38)
        .collect()
}

/// Half of the cases are stiff ones; the others are spread evenly over what the
/// error of a rule depends on: the logarithms of tan(θ/2), of the length and of the
/// optical depth. As the integrand does, it varies on a scale of about a factor of
/// e in each, of which there are 18, 14 and 9, and is largest for endless rays, of
/// which there are 16 per cell of the remaining two. Of a cell that wide the worst
/// of 16 points is within a tenth of the maximum, and the margin is 0.85; six times
/// as many cases gave no more than that.
#[test]
fn every_tolerance_is_kept_wherever_the_result_is_normal() {
    for phase in PHASES.into_iter().chain(SHARPEST) {
        let truths = truths(phase, 4000);
        for tolerance in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
            let quadrature = Quadrature::with_tolerance(phase, tolerance).unwrap();
            let (error, index) = worst(&quadrature, &truths);
            assert!(
                error <= f64::from(tolerance),
                "{phase:?} {tolerance}: {error} at {:?}",
                truths[index]
            );
        }
    }
}

#[test]
fn batches_keep_the_tolerance_and_have_the_same_bits_with_any_instructions() {
    for phase in PHASES {
        let exact = Exact::new(phase).unwrap();
        for tolerance in [1e-2, 1e-4, 1e-5] {
            let quadrature = Quadrature::with_tolerance(phase, tolerance).unwrap();
            // All of them in the same fog, so that segments of every kind share groups.
            let segments: Vec<Segment> = (stiff::cases(1500).into_iter())
                .map(|(_, segment)| segment)
                .collect();
            let sigma_t = 0.3;
            let mut values = vec![f32::NAN; segments.len()];
            quadrature.airlight_batch(sigma_t, &segments, &mut values);
            for (segment, value) in segments.iter().zip(&values) {
                let truth = exact.airlight(f64::from(sigma_t), &(*segment).into());
                if truth > f64::from(f32::MIN_POSITIVE) && truth < 1e38 {
                    let error = (f64::from(*value) / truth - 1.0).abs();
                    assert!(
                        error <= f64::from(tolerance),
                        "{phase:?} {tolerance} {segment:?}: {error:e}"
                    );
                }
            }
            let batch = Batch {
                quadrature: &quadrature,
                sigma_t: sigma_t.into(),
            };
            for arch in simd::every_arch() {
                let mut again = vec![f32::NAN; segments.len()];
                simd::batch_on(arch, &batch, &segments, &mut again);
                let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&values), bits(&again), "{arch:?}");
            }
        }
    }
}

#[test]
fn endless_rays_beside_a_sharp_peak_keep_their_tolerance() {
    // Where Schlick's function missed 1e-6 by 2.45 times once, and 1e-4 by 1.58.
    let phase = PhaseFunction::Schlick { k: 0.99 };
    let exact = Exact::new(phase).unwrap();
    for tolerance in [1e-2, 1e-4, 1e-5, 1e-6] {
        let quadrature = Quadrature::with_tolerance(phase, tolerance).unwrap();
        for step in 0..400_u16 {
            let segment = Segment {
                x: 0.0,
                s: 0.01 * (f32::from(step) - 200.0),
                h: 1.5,
                length: f32::INFINITY,
            };
            for sigma_t in [0.3, 0.6, 1.2] {
                let truth = exact.airlight(f64::from(sigma_t), &segment.into());
                let value = quadrature.airlight(sigma_t, &segment);
                let error = (f64::from(value) / truth - 1.0).abs();
                assert!(
                    error <= f64::from(tolerance),
                    "{tolerance} {sigma_t} {segment:?}: {error}"
                );
            }
        }
    }
}

#[test]
fn fixed_numbers_of_nodes_have_their_documented_errors() {
    let table = [
        (2, 8e-2, 4e-1),
        (3, 8e-3, 7e-2),
        (4, 8e-4, 2e-2),
        (5, 7e-5, 3e-3),
        (6, 6e-6, 9e-4),
        (7, 1e-6, 1.2e-4),
        (8, 1e-6, 4e-5),
        (10, 1e-6, 4e-6),
    ];
    for phase in PHASES {
        let truths = truths(phase, 4000);
        for (nodes, smooth, sharp) in table {
            let quadrature = Quadrature::fixed(phase, nodes).unwrap();
            let (error, index) = worst(&quadrature, &truths);
            let allowed = if phase.peaks() == [1.0, 1.0] {
                smooth
            } else {
                sharp
            };
            assert!(
                error <= allowed,
                "{phase:?} {nodes}: {error} at {:?}",
                truths[index]
            );
        }
    }
}

#[test]
fn few_nodes_are_enough() {
    let quadrature = Quadrature::with_tolerance(PhaseFunction::Isotropic, 1e-4).unwrap();
    let mut total = 0;
    let cases = stiff::cases(10_000);
    for (sigma_t, segment) in &cases {
        let count = quadrature.nodes(*sigma_t, segment, 0).count();
        assert!((1..=60).contains(&count), "{count} {sigma_t} {segment:?}");
        total += count;
    }
    assert!(total < 12 * cases.len(), "{total}");
    // A step of a march.
    let step = Segment {
        x: 3.0,
        s: -2.0,
        h: 1.0,
        length: 0.01,
    };
    assert_eq!(quadrature.nodes(0.1, &step, 0).count(), 1);
    assert_eq!(quadrature.nodes(0.1, &step, 2).count(), 3);
    // As many as there are.
    let most = quadrature.nodes(0.1, &step, usize::MAX).count();
    assert!(most > 3 && most == quadrature.nodes(0.1, &step, 100).count());
}

#[test]
fn nodes_lie_on_the_segment_and_know_the_inverse_square() {
    let quadrature = Quadrature::fixed(PhaseFunction::Isotropic, 10).unwrap();
    let exact = Exact::new(PhaseFunction::Isotropic).unwrap();
    for (sigma_t, segment) in stiff::cases(3000) {
        for sigma_t in [0.0, sigma_t] {
            let mut airlight = 0.0;
            for node in quadrature.nodes(sigma_t, &segment, 0) {
                let distance = node.distance;
                assert!(
                    (0.0..=segment.length).contains(&distance),
                    "{segment:?}: {node:?}"
                );
                // The integrand from the distance alone, in f64.
                let [x, s, h] = [segment.x, segment.s, segment.h].map(f64::from);
                let s = s + f64::from(distance);
                let way = x + f64::from(distance) + s.hypot(h);
                airlight += f64::from(node.weight) * (-f64::from(sigma_t) * way).exp();
            }
            airlight *= 0.25 / std::f64::consts::PI;
            let truth = exact.airlight(sigma_t.into(), &segment.into());
            // The rounding of the distance counts by the exponent.
            let reach = f64::from(segment.x + segment.s.abs() + segment.h);
            let error = 1e-6
                + 2e-7
                    * f64::from(sigma_t)
                    * (reach + 20.0 / f64::from(sigma_t).max(1e-30)).min(1e30);
            if truth > 1e-37 && truth < 1e38 {
                assert!(
                    (airlight / truth - 1.0).abs() < error,
                    "{sigma_t} {segment:?}: {airlight} {truth}"
                );
            }
        }
    }
}

#[test]
fn parts_add_up_to_the_whole() {
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.8 };
    let quadrature = Quadrature::with_tolerance(phase, 1e-5).unwrap();
    for (sigma_t, segment) in stiff::cases(3000) {
        let length = if segment.length.is_finite() {
            0.3 * segment.length
        } else {
            segment.s.abs() + segment.h
        };
        let end = segment.s + length;
        let first = Segment {
            length: end - segment.s,
            ..segment
        };
        let second = Segment {
            x: segment.x + first.length,
            s: end,
            length: segment.length - first.length,
            ..segment
        };
        // Where the ends can be had without rounding.
        let same_end = end + second.length == segment.s + segment.length;
        let exact = f64::from(second.x) == f64::from(segment.x) + f64::from(first.length);
        if end - first.length == segment.s && same_end && exact {
            let [a, b, whole] =
                [first, second, segment].map(|part| quadrature.airlight(sigma_t, &part));
            if whole > 1e-36 {
                assert!(
                    ((a + b) / whole - 1.0).abs() < 3e-5,
                    "{sigma_t} {segment:?}: {a} {b} {whole}"
                );
            }
        }
    }
}

#[test]
fn degenerate_segments_have_their_documented_values() {
    let good = Segment {
        x: 1.0,
        s: -1.0,
        h: 0.5,
        length: 2.0,
    };
    let quadrature = Quadrature::with_tolerance(PhaseFunction::Rayleigh, 1e-4).unwrap();
    assert!(quadrature.airlight(0.3, &good) > 0.0);
    let through = Segment { h: 0.0, ..good };
    assert_eq!(quadrature.airlight(0.3, &through), f32::INFINITY);
    assert_eq!(quadrature.nodes(0.3, &through, 0).count(), 0);
    for bad in [
        Segment {
            length: 0.0,
            ..good
        },
        Segment {
            length: f32::NAN,
            ..good
        },
        Segment {
            s: f32::NAN,
            ..good
        },
        Segment {
            x: f32::INFINITY,
            ..good
        },
        Segment { h: -1.0, ..good },
    ] {
        assert_eq!(quadrature.airlight(0.3, &bad), 0.0, "{bad:?}");
        let mut batch = [f32::NAN; 2];
        quadrature.airlight_batch(0.3, &[bad, through], &mut batch);
        assert_eq!(batch, [0.0, f32::INFINITY], "{bad:?}");
        assert_eq!(quadrature.nodes(0.3, &bad, 0).count(), 0, "{bad:?}");
    }
    assert_eq!(quadrature.airlight(f32::NAN, &good), 0.0);
    assert_eq!(quadrature.airlight(1e6, &good), 0.0);
}

#[test]
fn a_distance_of_minus_zero_is_none() {
    let sigma_t = 0.07032267;
    let parts = [
        (1.054255e-6, -22.265518, 0.0012372424),
        (1.3103482e-6, f32::MIN_POSITIVE, 0.0021272667),
        (0.0, 3.0, f32::INFINITY),
        (0.0, -3.0, 2.0),
    ];
    let part = |h: f32| parts.map(|(x, s, length)| Segment { x, s, h, length });
    let quadrature = Quadrature::with_tolerance(PhaseFunction::Isotropic, 1e-5).unwrap();
    let table = crate::Table::new(&PhaseFunction::Isotropic, 4).unwrap();
    let exact = Exact::new(PhaseFunction::Isotropic).unwrap();
    for evaluator in [&quadrature as &dyn Evaluator, &table, &exact] {
        let values = [0.0, -0.0].map(|h| {
            let mut batch = [f32::NAN; 4];
            evaluator.airlight_batch(sigma_t, &part(h), &mut batch);
            let singles = part(h).map(|segment| evaluator.airlight(sigma_t, &segment));
            [batch, singles]
        });
        assert!(values[0].iter().flatten().all(|value| *value > 0.0));
        assert_eq!(values[0], values[1]);
    }
}

#[test]
fn rays_that_all_but_meet_the_light_keep_the_tolerance() {
    let phases = [
        PhaseFunction::Isotropic,
        PhaseFunction::HenyeyGreenstein { g: 0.7 },
        PhaseFunction::HenyeyGreenstein { g: -0.99 },
    ];
    // The first was found by fuzzing.
    let parts = [
        (0.0, -24.570_635, f32::INFINITY),
        (0.0, -24.570_635, 24.570_635),
        (3.0, -24.570_635, 30.0),
        (3.0, -24.570_635, 24.0),
        (0.0, -24.570_635, 24.570_633),
    ];
    // A spot whose rims are as near to the light as the ray, in front of the foot point and
    // behind it, and one that the ray begins in.
    let spot = |along: f64, outer: f64| {
        let across = (1.0 - along * along).sqrt();
        Emission::spot(along, across, outer + 0.3, outer).unwrap()
    };
    let lights = [
        Emission::isotropic(),
        spot(0.1, 0.6),
        spot(-0.7, 0.2),
        spot(-0.998, -1.0).fading_within(30.0).unwrap(),
    ];
    for phase in phases {
        let exact = Exact::new(phase).unwrap();
        let fine = Quadrature::with_tolerance(phase, 1e-5).unwrap();
        let coarse = Quadrature::with_tolerance(phase, 1e-2).unwrap();
        for h in [5.453e-39, 1e-36, 1e-25, 2.4e-15, 2.6e-15, 1e-10] {
            for (sigma_t, (x, s, length)) in [0.0, 8e-42, 0.1]
                .into_iter()
                .flat_map(|sigma_t| parts.map(|part| (sigma_t, part)))
            {
                let segment = Segment { x, s, h, length };
                let check = |name: &str, value: f32, truth: f64, bound: f64| {
                    let error = (f64::from(value) - truth).abs();
                    let is_close = error <= bound || truth > f64::from(f32::MAX);
                    assert!(
                        is_close,
                        "{name}, {phase:?}, {sigma_t}, {segment:?}: {value:e} for {truth:e}"
                    );
                };
                let wide = Segment64::from(segment);
                let truth = exact.estimate(f64::from(sigma_t), &wide).value;
                check(
                    "alone",
                    fine.airlight(sigma_t, &segment),
                    truth,
                    1e-5 * truth,
                );
                let mut batch = [f32::NAN; 3];
                coarse.airlight_batch(sigma_t, &[segment; 3], &mut batch);
                check("in a batch", batch[1], truth, 1e-2 * truth);
                for light in &lights {
                    let lit = exact.estimate_of(f64::from(sigma_t), &wide, light).value;
                    let value = fine.airlight_of(sigma_t, &segment, light);
                    check("of a light", value, lit, 1e-5 * lit + 4e-6 * truth);
                }
            }
        }
    }
    // Without absorption airlight near the light grows as 1 / h, whatever the light's pattern.
    let exact = Exact::new(phases[1]).unwrap();
    let ahead = |h: f64| Segment64 {
        x: 0.0,
        s: -24.570_635,
        h,
        length: f64::INFINITY,
    };
    for light in &lights[..3] {
        let of = |h: f64| h * exact.estimate_of(0.0, &ahead(h), light).value;
        for h in [1e-140, 1e-100, 5.453e-39, 1e-20, 1e-15, 1e-12] {
            let error = (of(h) / of(1e-9) - 1.0).abs();
            assert!(error < 1e-8, "{h:e}, {light:?}: {error:e}");
        }
    }
    // Found by fuzzing.
    let light = Emission::spot(-0.998_294_8, -0.058_374_2, 0.969_2, -1.0).unwrap();
    let light = light.fading_within(7.604_616_257_594_898e-5).unwrap();
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.7 };
    let segment = Segment {
        x: 8.008_912e-4,
        s: -1.641_750_9e-18,
        h: f32::MIN_POSITIVE,
        length: 9.536_743e-7,
    };
    let coarse = Quadrature::with_tolerance(phase, 1e-2).unwrap();
    let exact = Exact::new(phase).unwrap();
    let truth = exact.estimate_of(6551.0103, &segment.into(), &light).value;
    let value = f64::from(coarse.airlight_of(6551.0103, &segment, &light));
    assert!(
        (value / truth - 1.0).abs() <= 1e-2,
        "{value:e} for {truth:e}"
    );
}

/// Found by fuzzing: over the distance from the light their lengths are no normal numbers.
#[test]
fn lengths_of_any_magnitude_keep_the_tolerance() {
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.7 };
    let exact = Exact::new(phase).unwrap();
    let fine = Quadrature::with_tolerance(phase, 1e-5).unwrap();
    let light = Emission::cosine(0.3, -0.8).unwrap();
    let lengths = [
        1e-45, 2e-44, 1e-40, 1e-38, 1e-34, 1e-31, 2e-30, 5e-30, 1e-25, 1e-12,
    ];
    for (s, h) in [(8.097_933_5e-6, 2.154_554_7e-5), (-3e-5, 2e-6)] {
        for length in lengths {
            let (sigma_t, x) = (0.002_309_228_5, 0.004_951_590_7);
            let segment = Segment { x, s, h, length };
            let wide = Segment64::from(segment);
            let truth = exact.airlight(sigma_t.into(), &wide);
            let lit = exact.estimate_of(sigma_t.into(), &wide, &light).value;
            let mut batch = [f32::NAN; 3];
            fine.airlight_batch(sigma_t, &[segment; 3], &mut batch);
            let values = [
                (fine.airlight(sigma_t, &segment), truth),
                (batch[1], truth),
                (fine.airlight_of(sigma_t, &segment, &light), lit),
            ];
            for (value, truth) in values {
                let error = (f64::from(value) - truth).abs();
                // Of a sum that is not a normal number itself.
                let rounding = f64::from(f32::MIN_POSITIVE * f32::EPSILON);
                let is_close = error <= 1e-5 * truth + rounding;
                assert!(is_close, "{segment:?}: {value:e} for {truth:e}");
            }
        }
    }
}

#[test]
fn extreme_magnitudes_are_never_nan() {
    let sizes = [0.0, 1e-45, 1e-38, 1e-20, 1.0, 1e20, f32::MAX];
    for phase in [
        PhaseFunction::Isotropic,
        PhaseFunction::HenyeyGreenstein { g: -0.999_999_94 },
    ] {
        let quadrature = Quadrature::with_tolerance(phase, 1e-6).unwrap();
        let coarse = Quadrature::with_tolerance(phase, 1e-2).unwrap();
        for sigma_t in sizes {
            for s in sizes.into_iter().flat_map(|s| [s, -s]) {
                for h in sizes {
                    for length in sizes.into_iter().chain([f32::INFINITY]) {
                        let segment = Segment {
                            x: 1.0,
                            s,
                            h,
                            length,
                        };
                        let mut values = [quadrature.airlight(sigma_t, &segment); 2];
                        coarse.airlight_batch(sigma_t, &[segment], &mut values[1..]);
                        for value in values {
                            assert!(value >= 0.0, "{sigma_t} {segment:?}: {value}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn settings_out_of_range_are_refused() {
    let phase = PhaseFunction::Isotropic;
    assert!(Quadrature::fixed(phase, 0).is_err() && Quadrature::fixed(phase, 5000).is_err());
    for tolerance in [0.0, 1e-9, 0.5, f32::NAN] {
        assert!(Quadrature::with_tolerance(phase, tolerance).is_err());
    }
    let bad = PhaseFunction::HenyeyGreenstein { g: 1.0 };
    assert!(Quadrature::fixed(bad, 8).is_err());
}

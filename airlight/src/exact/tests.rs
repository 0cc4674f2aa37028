//! What must hold of [`Exact`].

use std::f64::consts::PI;

use proptest::prelude::*;

use super::references::REFERENCES;
use super::*;

/// The value of an isotropic phase function.
const ISOTROPIC: f64 = 0.25 / PI;

/// The stated error of [`Exact`].
const ERROR: f64 = 1e-12;

/// Below this the spacing of f64 grows larger than the stated error.
const SMALL: f64 = 1e-290;

fn isotropic() -> Exact {
    Exact::new(PhaseFunction::Isotropic).unwrap()
}

#[test]
fn every_value_agrees_with_forty_digits() {
    for &(phase, [sigma_t, x, s, h, length], expected) in REFERENCES {
        let segment = Segment { x, s, h, length };
        let exact = Exact::new(phase).unwrap();
        let estimate = exact.estimate(sigma_t.into(), &segment.into());
        let error = (estimate.value - expected).abs();
        assert!(
            error <= ERROR * expected && error <= estimate.bound,
            "{phase:?} {sigma_t} {segment:?}: {estimate:?} {expected}"
        );
        let rounded = Evaluator::airlight(&exact, sigma_t, &segment);
        let error = (f64::from(rounded) - expected).abs();
        let half_a_unit = 0.5 * f64::from(f32::EPSILON) * expected + f64::from(f32::MIN_POSITIVE);
        assert!(error <= 1.000_01 * half_a_unit || rounded == f32::INFINITY);
    }
}

/// Extinction and a part of a ray that start where the optical depth is below
/// 700 and does not meet the light: rays at all angles, most of them extreme,
/// parts of all lengths, most of them short or long.
fn stiff() -> impl Strategy<Value = (f64, Segment64)> {
    let angle = prop_oneof![
        1 => Just(0.0),
        1 => Just(PI),
        3 => (-20.0_f64..0.4).prop_map(f64::exp),
        3 => (-20.0_f64..0.4).prop_map(|log| PI - log.exp()),
        2 => 0.0..PI,
    ];
    let start = prop_oneof![
        Just(0.0),
        0.0_f64..3.0,
        (-20.0_f64..0.0).prop_map(|log| 1.0 - log.exp())
    ];
    let length = prop_oneof![
        2 => Just(f64::INFINITY),
        4 => (-21.0_f64..5.0).prop_map(f64::exp),
        // Ends just before, at and behind the foot point.
        2 => (-20.0_f64..0.0).prop_map(|log| -log.exp()),
        1 => Just(0.0),
    ];
    let depth = (-28.0_f64..6.55).prop_map(f64::exp);
    let distance = (-13.8_f64..13.8).prop_map(f64::exp);
    (angle, start, length, depth, distance).prop_filter_map(
        "on the light",
        |(angle, start, length, depth, distance)| {
            let foot = distance * angle.cos();
            let h = if angle == 0.0 || angle == PI {
                0.0
            } else {
                distance * angle.sin()
            };
            let x = start * distance;
            let s = x - foot;
            let length = if length > 0.0 {
                length * distance
            } else {
                -s * (1.0 + length)
            };
            let segment = Segment64 { x, s, h, length };
            let sigma_t = depth / distance;
            let usable = length > 0.0
                && sigma_t * (x + s.hypot(h)) < 700.0
                && !(h == 0.0 && s <= 0.0 && s + length >= 0.0);
            usable.then_some((sigma_t, segment))
        },
    )
}

fn cases(number: u32) -> ProptestConfig {
    ProptestConfig {
        max_global_rejects: 10 * number,
        ..reference::property::cases(number)
    }
}

proptest! {
    #![proptest_config(cases(20_000))]

    #[test]
    fn the_closed_form_is_the_integral((sigma_t, segment) in stiff()) {
        // A closure is not known to be constant and goes the other way.
        let by_quadrature = Exact::new(|_: ScatteringAngle<f64>| ISOTROPIC).unwrap();
        let closed = isotropic().estimate(sigma_t, &segment);
        let numeric = by_quadrature.estimate(sigma_t, &segment);
        let error = (closed.value / numeric.value - 1.0).abs();
        prop_assume!(closed.value > SMALL);
        prop_assert!(error < ERROR, "{:e} {:?} {:?}", error, closed, numeric);
        prop_assert!(numeric.bound < ERROR * numeric.value);
        prop_assert!(closed.bound < ERROR * closed.value);
    }
}

fn any_phase() -> impl Strategy<Value = PhaseFunction> {
    let parameter = || {
        (any::<bool>(), -7.0_f32..0.0).prop_map(|(back, log)| {
            if back {
                log.exp() - 1.0
            } else {
                1.0 - log.exp()
            }
        })
    };
    prop_oneof![
        Just(PhaseFunction::Isotropic),
        Just(PhaseFunction::Rayleigh),
        parameter().prop_map(|g| PhaseFunction::HenyeyGreenstein { g }),
        parameter().prop_map(|k| PhaseFunction::Schlick { k }),
        parameter().prop_map(|g| PhaseFunction::CornetteShanks { g }),
        (parameter(), parameter(), 0.0_f32..=1.0)
            .prop_map(|(a, b, weight)| PhaseFunction::DoubleHenyeyGreenstein { g: [a, b], weight }),
        (5.0_f32..=50.0).prop_map(|diameter| PhaseFunction::droplets(diameter).unwrap()),
    ]
}

proptest! {
    #![proptest_config(cases(3_000))]

    #[test]
    fn parts_add_up_to_the_whole(
        phase in any_phase(),
        (sigma_t, segment) in stiff(),
        fraction in prop_oneof![0.0..1.0_f64, (-20.0..0.0_f64).prop_map(f64::exp)],
    ) {
        let exact = Exact::new(phase).unwrap();
        let whole = exact.estimate(sigma_t, &segment);
        let first_length = fraction * if segment.length.is_finite() {
            segment.length
        } else {
            segment.s.abs() + segment.h
        };
        // The second part starts where the first one ends, to the last bit.
        let end = segment.s + first_length;
        let first = Segment64 { length: end - segment.s, ..segment };
        let second = Segment64 {
            x: segment.x + first.length,
            s: end,
            length: segment.length - first.length,
            ..segment
        };
        prop_assume!(end - first.length == segment.s && end + second.length == segment.s + segment.length);
        let (a, b) = (exact.estimate(sigma_t, &first), exact.estimate(sigma_t, &second));
        let error = (a.value + b.value - whole.value).abs();
        // Which is not the same as starting exactly there: what the rounding
        // of the second x does to the exponent.
        let rounding = f64::EPSILON * sigma_t * second.x * b.value;
        prop_assert!(error <= whole.bound + a.bound + b.bound + rounding, "{:e}", error / whole.value);
        prop_assert!(whole.bound < ERROR * whole.value || whole.value < SMALL, "{:?}", whole);
        prop_assert!(a.value >= 0.0 && a.value <= whole.value + whole.bound);
    }

    #[test]
    fn only_optical_depths_count(phase in any_phase(), (sigma_t, segment) in stiff(), k in -20..20_i32) {
        // With a power of two nothing is rounded: the same to the last bit.
        let k = 2_f64.powi(k);
        let exact = Exact::new(phase).unwrap();
        let Segment64 { x, s, h, length } = segment;
        let scaled = Segment64 { x: x * k, s: s * k, h: h * k, length: length * k };
        let value = exact.airlight(sigma_t, &segment);
        prop_assume!(value > SMALL);
        prop_assert_eq!(value, k * exact.airlight(sigma_t / k, &scaled));
    }

    #[test]
    fn thin_air_is_the_limit_of_no_absorption(phase in any_phase(), (_, segment) in stiff()) {
        let exact = Exact::new(phase).unwrap();
        let vacuum = exact.airlight(0.0, &segment);
        // As far as the end of the ray, or a depth at which nothing is left of 1/d².
        let reach = segment.x + segment.s.hypot(segment.h);
        for depth in [1e-19, 1e-21] {
            let thin = exact.airlight(depth / reach, &segment);
            prop_assert!((thin / vacuum - 1.0).abs() < 1e-13, "{} {}", thin, vacuum);
        }
    }
}

#[test]
fn degenerate_segments_have_their_documented_values() {
    let good = Segment64 {
        x: 1.0,
        s: -1.0,
        h: 0.5,
        length: 2.0,
    };
    for exact in [
        isotropic(),
        Exact::new(PhaseFunction::HenyeyGreenstein { g: 0.9 }).unwrap(),
    ] {
        assert!(exact.airlight(0.3, &good) > 0.0);
        let through = [
            Segment64 { h: 0.0, ..good },
            Segment64 {
                h: 0.0,
                length: 1.0,
                ..good
            },
            Segment64 {
                h: 0.0,
                s: 0.0,
                ..good
            },
            Segment64 {
                h: 0.0,
                length: f64::INFINITY,
                ..good
            },
        ];
        for segment in through {
            assert_eq!(exact.airlight(0.3, &segment), f64::INFINITY, "{segment:?}");
            assert_eq!(exact.airlight(1e30, &segment), f64::INFINITY, "{segment:?}");
        }
        let nothing = [
            Segment64 {
                length: 0.0,
                ..good
            },
            Segment64 {
                length: 0.0,
                h: 0.0,
                s: 0.0,
                ..good
            },
            Segment64 {
                length: -1.0,
                ..good
            },
            Segment64 {
                length: f64::NAN,
                ..good
            },
            Segment64 {
                x: f64::NAN,
                ..good
            },
            Segment64 {
                s: f64::NAN,
                ..good
            },
            Segment64 {
                h: f64::NAN,
                ..good
            },
            Segment64 { h: -1.0, ..good },
            Segment64 {
                s: f64::NEG_INFINITY,
                ..good
            },
            Segment64 {
                x: f64::INFINITY,
                ..good
            },
            Segment64::default(),
        ];
        for segment in nothing {
            assert_eq!(exact.airlight(0.3, &segment), 0.0, "{segment:?}");
        }
        for sigma_t in [f64::NAN, -1.0, f64::INFINITY, 1e6] {
            assert_eq!(exact.airlight(sigma_t, &good), 0.0, "{sigma_t}");
        }
    }
}

#[test]
fn extreme_magnitudes_are_never_nan() {
    let sizes = [
        0.0,
        5e-324,
        1e-300,
        1e-160,
        1e-45,
        1e-10,
        1.0,
        1e10,
        1e38,
        1e160,
        1e300,
        f64::MAX,
    ];
    let phases = [
        PhaseFunction::Isotropic,
        PhaseFunction::HenyeyGreenstein { g: 0.999_999_94 },
        PhaseFunction::Schlick { k: -0.999_999_94 },
    ];
    for phase in phases {
        let exact = Exact::new(phase).unwrap();
        for sigma_t in sizes {
            for x in [0.0, 1.0, 1e300] {
                for s in sizes {
                    for h in sizes {
                        for length in sizes.into_iter().chain([f64::INFINITY]) {
                            for s in [s, -s] {
                                let segment = Segment64 { x, s, h, length };
                                let Estimate { value, bound } = exact.estimate(sigma_t, &segment);
                                assert!(
                                    value >= 0.0 && bound >= 0.0,
                                    "{sigma_t} {segment:?}: {value} {bound}"
                                );
                            }
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_function_that_is_not_finite_has_an_infinite_bound() {
    let segment = Segment64 {
        x: 0.0,
        s: -1.0,
        h: 0.5,
        length: 2.0,
    };
    for bad in [f64::NAN, f64::INFINITY] {
        let exact = Exact::new(
            move |angle: ScatteringAngle<f64>| {
                if angle.cos() > 0.0 { bad } else { 1.0 }
            },
        )
        .unwrap();
        let estimate = exact.estimate(0.3, &segment);
        assert!(estimate.value.is_finite() && estimate.bound == f64::INFINITY);
    }
}

#[test]
fn a_function_with_a_step_is_integrated_to_within_its_bound() {
    // Half of the sphere: the foot point is where cos θ = 0, and a step off
    // it, at cos θ = 0.6, must be found. In a vacuum the integral is an angle.
    let step = |angle: ScatteringAngle<f64>| f64::from(u8::from(angle.cos() > 0.6));
    let segment = Segment64 {
        x: 0.0,
        s: -3.0,
        h: 2.0,
        length: 9.0,
    };
    let estimate = Exact::new(step).unwrap().estimate(0.0, &segment);
    let truth = (0.8_f64.asin() - (2.0_f64).atan2(3.0)) / 2.0;
    assert!(
        (estimate.value - truth).abs() <= estimate.bound,
        "{estimate:?} {truth}"
    );
    assert!(estimate.bound < 1e-9, "{estimate:?}");
}

#[test]
fn the_scaled_exponential_integral_has_its_known_values() {
    // e E₁(1) and e E₁'(1): at u = 0 it is −(e^y E₁(y))' = 1/y − e^y E₁(y).
    let e1 = 0.219_383_934_395_520_27;
    assert!((tail(1.0, 0.0) / (1.0 - 1_f64.exp() * e1) - 1.0).abs() < 1e-14);
    // Far away it is ∫ e^{−v} dv / |z|², next to 0 it is an angle over u.
    assert!((tail(1e9, 1e9) / 0.5e-18 - 1.0).abs() < 1e-8);
    assert!((tail(0.0, 1e-9) * 1e-9 / (0.5 * PI) - 1.0).abs() < 1e-7);
    assert_eq!(tail(0.0, 0.0), f64::INFINITY);
    assert_eq!(tail(1e300, 1e300), 0.0);
}

#[test]
fn series_and_fraction_agree_where_they_meet() {
    for i in 0..200 {
        // |z| + y = 4
        let y = 2.0 * f64::from(i) / 199.0;
        let u = (((4.0 - y) * (4.0 - y)) - y * y).max(0.0).sqrt();
        let (below, above) = (
            tail(y * (1.0 - 1e-15), u * (1.0 - 1e-15)),
            tail(y * (1.0 + 1e-15), u * (1.0 + 1e-15)),
        );
        assert!(
            (below / above - 1.0).abs() < 3e-14,
            "{y} {u}: {below} {above}"
        );
    }
}

#[test]
fn scattered_energy_is_conserved() {
    // Of the light of an isotropic lamp, I = 1, 4π e^{−σ r} passes the sphere
    // of radius r around it without having been scattered: 4π/σ is the length
    // of all its ways until then. With σ_s = 1 that is also what is scattered,
    // which again goes 1/σ on average. The same from what eyes see: fluence
    // times volume is the length of all ways.
    let exact = isotropic();
    let rule = Rule::new(120).unwrap();
    let sigma = 0.7;
    let mut total = 0.0;
    for (t, weight) in rule.iter() {
        // D = v² / σ with v up to 7.
        let v = 7.0 * t;
        let distance = v * v / sigma;
        let measure = 7.0 * weight * 2.0 * v / sigma;
        let fluence: f64 = rule
            .iter()
            .map(|(t, weight)| {
                let angle = PI * t;
                let segment = Segment64 {
                    x: 0.0,
                    s: -distance * angle.cos(),
                    h: distance * angle.sin(),
                    length: f64::INFINITY,
                };
                let solid = 2.0 * PI * angle.sin() * PI * weight;
                solid * exact.airlight(sigma, &segment)
            })
            .sum();
        total += 4.0 * PI * distance * distance * measure * fluence;
    }
    let expected = 4.0 * PI / (sigma * sigma);
    assert!(
        (total / expected - 1.0).abs() < 1e-6,
        "{}",
        total / expected
    );
}

#[test]
fn a_light_far_away_is_a_sun() {
    // Of intensity D² e^{σ D}, so that its irradiance here is 1.
    let (sigma, distance, length) = (1e-3, 1e5, 800.0);
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.7 };
    let exact = Exact::new(phase).unwrap();
    for angle in [0.3_f64, 1.5, 3.0] {
        let segment = Segment64 {
            x: 0.0,
            s: -distance * angle.cos(),
            h: distance * angle.sin(),
            length,
        };
        let intensity = distance * distance * (sigma * distance).exp();
        let lamp = intensity * exact.airlight(sigma, &segment);
        // The path of its light shortens along the ray by x cos γ.
        let last = sigma * length * (1.0 - angle.cos());
        let scattered = phase.value(ScatteringAngle::from_cos(angle.cos()));
        let sun = scattered * crate::directional::between(0.0, last, length);
        // The rays are parallel to within the length over the distance.
        assert!(
            (lamp / sun - 1.0).abs() < 4.0 * length / distance,
            "{lamp} {sun}"
        );
    }
}

#[test]
fn a_longer_part_is_not_darker() {
    let exact = Exact::new(PhaseFunction::Schlick { k: 0.9 }).unwrap();
    for (sigma_t, segment) in crate::stiff::cases(300) {
        let segment = Segment64::from(segment);
        let mut last = 0.0;
        for k in -30..30 {
            let length = (segment.s.abs() + segment.h) * 2_f64.powi(k);
            let Estimate { value, bound } =
                exact.estimate(sigma_t.into(), &Segment64 { length, ..segment });
            assert!(value >= last - bound, "{segment:?}: {value} after {last}");
            last = value;
        }
    }
}

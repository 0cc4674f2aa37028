use std::f64::consts::PI;

use super::*;
use crate::{Exact, PhaseFunction, Quadrature, Table};

const PHASES: [PhaseFunction; 6] = [
    PhaseFunction::Isotropic,
    PhaseFunction::Rayleigh,
    PhaseFunction::HenyeyGreenstein { g: 0.7 },
    PhaseFunction::HenyeyGreenstein { g: 0.9 },
    PhaseFunction::Schlick { k: -0.6 },
    PhaseFunction::CornetteShanks { g: 0.6 },
];

fn segment(distance: f64, gamma: f64, x: f64, length: f64) -> Segment {
    let h = if gamma == PI { 0.0 } else { gamma.sin() };
    Segment {
        x: x as f32,
        s: (x - distance * gamma.cos()) as f32,
        h: (distance * h) as f32,
        length: length as f32,
    }
}

/// Angles in all directions and next to the light.
fn angles() -> Vec<f64> {
    let around = (0..40).map(|i| (0.97 - 1.97 * f64::from(i) / 39.0).acos());
    let near = (0..24).map(|i| 1e-5 * 10_f64.powf(f64::from(i) / 6.0));
    around.chain(near).chain([0.0, PI]).collect()
}

/// Largest error and the share that is refused.
fn measured(table: &FrameTable, exact: &Exact, parts: &[Segment]) -> (f64, f64) {
    let (mut worst, mut refused) = (0.0_f64, 0);
    for part in parts {
        let Some(found) = table.look_up(part) else {
            refused += 1;
            continue;
        };
        let truth = exact.airlight(table.sigma_t().into(), &(*part).into());
        let error = (f64::from(found) / truth - 1.0).abs();
        worst = worst.max(error);
    }
    (worst, f64::from(refused) / parts.len() as f64)
}

/// Errors are those that the documentation of [`FrameTable`] lists, and for steps close to
/// where the table begins to refuse twice as large.
#[test]
fn runs_and_steps_are_near_the_truth() {
    for (phase, runs, steps) in [
        (PhaseFunction::Isotropic, 1e-3, 5e-3),
        (PhaseFunction::Rayleigh, 1e-3, 5e-3),
        (PhaseFunction::HenyeyGreenstein { g: 0.7 }, 1.4e-3, 5e-3),
        (PhaseFunction::HenyeyGreenstein { g: 0.9 }, 2.5e-3, 7e-3),
    ] {
        let exact = Exact::new(phase).unwrap();
        for depth in [0.0, 0.1, 0.5, 2.0] {
            let distance = 4.0;
            let table =
                FrameTable::new(&phase, depth / distance as f32, distance as f32, 128).unwrap();
            let (mut whole, mut parts) = (Vec::new(), Vec::new());
            for gamma in angles() {
                // Not through the light.
                let reach = if gamma == 0.0 { 0.3 } else { 1.0 };
                for share in [0.3, 0.9, 1.3, 3.0] {
                    let length = share * reach * distance;
                    whole.push(segment(distance, gamma, 0.0, length));
                    let step = 0.01 * length;
                    let at = (0..100).step_by(7).map(|i| step * f64::from(i));
                    parts.extend(at.map(|x| segment(distance, gamma, x, step)));
                }
                whole.push(segment(distance, gamma, 0.0, 0.5 * distance));
            }
            for (list, allowed) in [(&whole, runs), (&parts, steps)] {
                let (error, refused) = measured(&table, &exact, list);
                println!("{phase:?} {depth}: {error:.1e}, {refused:.2} refused");
                assert!(error <= allowed, "{phase:?} {depth}: {error}");
                // Through much fog, and steps of sharp peaks.
                assert!(refused <= 0.35, "{phase:?} {depth}: {refused}");
            }
        }
    }
}

/// Each column of the table in the documentation of [`FrameTable`], of rays spread over the
/// sphere.
#[test]
fn errors_are_those_of_the_documentation() {
    let henyey = |g| PhaseFunction::HenyeyGreenstein { g };
    let iso = PhaseFunction::Isotropic;
    for (phase, columns) in [
        (iso, COLUMNS[0]),
        (henyey(0.7), COLUMNS[1]),
        (henyey(0.9), COLUMNS[2]),
        (henyey(-0.9), COLUMNS[3]),
    ] {
        let exact = Exact::new(phase).unwrap();
        for (rows, allowed) in [64, 128, 256].into_iter().zip(columns) {
            let mut found = [(0.0_f64, 0.0_f64); 2];
            for depth in [0.1_f32, 0.5, 2.0] {
                let table = FrameTable::new(&phase, 0.25 * depth, 4.0, rows).unwrap();
                for (found, list) in found.iter_mut().zip(all_around()) {
                    let (error, refused) = measured(&table, &exact, &list);
                    println!("{phase:?} {rows} {depth}: {error:.2e}, {refused:.3} refused");
                    *found = (found.0.max(error), found.1.max(refused));
                }
            }
            println!("{phase:?} {rows}: {found:?}");
            for ((error, _), allowed) in found.into_iter().zip(allowed) {
                assert!(error <= allowed, "{phase:?} {rows}: {error}");
            }
        }
    }
}

/// For each phase function and 64, 128 and 256 rows: runs and steps.
const COLUMNS: [[[f64; 2]; 3]; 4] = [
    [[4.3e-3, 3.3e-3], [1.6e-3, 3.8e-3], [2.1e-3, 2.0e-3]],
    [[4.3e-3, 4.0e-3], [1.8e-3, 3.6e-3], [2.1e-3, 2.0e-3]],
    [[4.3e-3, 5.2e-3], [1.8e-3, 3.6e-3], [2.1e-3, 2.0e-3]],
    [[5.0e-3, 5.6e-3], [4.5e-3, 4.9e-3], [3.6e-3, 3.8e-3]],
];

/// Runs and steps of rays in directions spread over the sphere.
fn all_around() -> [Vec<Segment>; 2] {
    let (mut runs, mut steps) = (Vec::new(), Vec::new());
    for i in 0..150 {
        let gamma = (1.0 - (2.0 * f64::from(i) + 1.0) / 150.0).acos();
        for share in [0.3, 0.9, 1.3, 3.0] {
            let length = 4.0 * share;
            runs.push(segment(4.0, gamma, 0.0, length));
            runs.push(segment(4.0, gamma, length, f64::INFINITY));
            let at = (0..100).step_by(7).map(|i| 0.01 * length * f64::from(i));
            steps.extend(at.map(|x| segment(4.0, gamma, x, 0.01 * length)));
        }
    }
    [runs, steps]
}

/// Sharp peaks are refused, not blurred: what is known is within 1 % of the truth, next to
/// the light and away from it.
#[test]
fn peaks_that_rows_cannot_follow_are_refused() {
    let henyey =
        [-0.99, -0.97, -0.9, 0.97, 0.99, 0.999].map(|g| PhaseFunction::HenyeyGreenstein { g });
    let mixed = [
        PhaseFunction::droplets(10.0).unwrap(),
        PhaseFunction::DoubleHenyeyGreenstein {
            g: [0.97, -0.9],
            weight: 0.6,
        },
    ];
    for phase in henyey.into_iter().chain(mixed) {
        let exact = Exact::new(phase).unwrap();
        for (depth, rows) in [
            (0.1_f32, 128),
            (0.5, 64),
            (0.5, 128),
            (0.5, 256),
            (2.0, 128),
        ] {
            let table = FrameTable::new(&phase, 0.25 * depth, 4.0, rows).unwrap();
            let (mut runs, mut steps) = (Vec::new(), Vec::new());
            let behind = (0..60).map(|i| PI - 0.1 * f64::from(i + 1) / 60.0);
            let ahead = (0..60).map(|i| 0.1 * f64::from(i + 1) / 60.0);
            let around = angles().into_iter().filter(|gamma| *gamma > 0.0);
            for gamma in behind.chain(ahead).chain(around) {
                for share in [0.3, 0.9, 1.3, 3.0, f64::INFINITY] {
                    runs.push(segment(4.0, gamma, 0.0, 4.0 * share));
                    if share.is_finite() {
                        let step = 0.04 * share;
                        let at = (0..100).step_by(9).map(|i| step * f64::from(i));
                        steps.extend(at.map(|x| segment(4.0, gamma, x, step)));
                    }
                }
            }
            for (name, list, allowed) in [("runs", &runs, 1e-2), ("steps", &steps, 1e-2)] {
                let (error, refused) = measured(&table, &exact, list);
                println!("{phase:?} {depth} {rows} {name}: {error:.1e}, {refused:.2} refused");
                assert!(error <= allowed, "{phase:?} {depth} {rows} {name}: {error}");
                assert!(refused < 1.0, "{phase:?} {depth} {rows} {name}");
            }
        }
    }
}

/// With twice the rows errors are a quarter.
#[test]
fn errors_fall_with_the_square_of_the_rows() {
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.7 };
    let exact = Exact::new(phase).unwrap();
    let runs: Vec<_> = (angles().into_iter().filter(|gamma| *gamma > 1e-3))
        .flat_map(|gamma| [0.3, 0.9, 2.0].map(|length| segment(2.0, gamma, 0.0, 2.0 * length)))
        .collect();
    let error = |rows| {
        let table = FrameTable::new(&phase, 0.2, 2.0, rows).unwrap();
        measured(&table, &exact, &runs).0
    };
    let errors = [64, 128, 256].map(error);
    for pair in errors.windows(2) {
        assert!((3.0..6.0).contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}

/// Steps of a march add up to the run, whatever their number.
#[test]
fn parts_add_up() {
    for phase in PHASES {
        let table = FrameTable::new(&phase, 0.3, 2.0, 64).unwrap();
        let mut compared = 0;
        for gamma in angles().into_iter().filter(|gamma| *gamma > 1e-4) {
            let (foot, h) = ((2.0 * gamma.cos()) as f32, (2.0 * gamma.sin()) as f32);
            let ray = table.ray(foot, h).unwrap();
            let points: Option<Vec<_>> = (0..=30).map(|i| ray.at(0.1 * i as f32)).collect();
            let Some(points) = points else { continue };
            let steps: Option<Vec<_>> = points
                .windows(2)
                .map(|pair| ray.between(&pair[0], &pair[1]))
                .collect();
            let (Some(steps), Some(whole)) = (steps, ray.between(&points[0], &points[30])) else {
                continue;
            };
            let sum: f64 = steps.into_iter().map(f64::from).sum();
            let error = (sum / f64::from(whole) - 1.0).abs();
            assert!(error < 1e-5, "{phase:?} {gamma}: {error}");
            compared += 1;
        }
        println!("{phase:?}: {compared} compared");
        assert!(compared >= 20, "{phase:?}: {compared}");
    }
}

/// What is asked of other eyes, in other fog, on the light and of no part at all is
/// refused; what is looked up through a [`Framed`] is right all the same.
#[test]
fn what_a_table_cannot_know_it_refuses() {
    let phase = PhaseFunction::Isotropic;
    let table = FrameTable::new(&phase, 0.1, 4.0, 128).unwrap();
    let ray = segment(4.0, 1.0, 0.0, 3.0);
    assert!(table.look_up(&ray).is_some());
    for refused in [
        segment(4.001, 1.0, 0.0, 3.0),
        segment(3.999, 1.0, 0.0, 3.0),
        segment(4.0, 0.0, 0.0, 8.0),
        segment(4.0, 0.0, 0.0, 4.0),
        segment(4.0, 0.0, 4.0, 4.0),
        segment(4.0, 1.0, 3.0, 1e-4),
        Segment { length: 0.0, ..ray },
        Segment {
            length: -1.0,
            ..ray
        },
        Segment { h: -1.0, ..ray },
        Segment { x: f32::NAN, ..ray },
        Segment {
            s: f32::INFINITY,
            ..ray
        },
        Segment { h: f32::NAN, ..ray },
        Segment {
            length: f32::NAN,
            ..ray
        },
        Segment {
            x: -1.0,
            s: ray.s - 1.0,
            ..ray
        },
    ] {
        assert_eq!(table.look_up(&refused), None, "{refused:?}");
    }
    // Nor what is between points in the wrong order.
    let ray = table.ray(2.0, 12.0_f32.sqrt()).unwrap();
    let points = [0.0, 1.0, 3.0, 6.0, f32::INFINITY].map(|x| ray.at(x).unwrap());
    for (i, start) in points.iter().enumerate() {
        for (j, end) in points.iter().enumerate() {
            assert_eq!(ray.between(start, end).is_some(), i < j, "{i} {j}");
        }
    }
    let fallback = Quadrature::with_tolerance(phase, 1e-5).unwrap();
    let framed = Framed::new(table, fallback);
    let exact = Exact::new(phase).unwrap();
    for (sigma_t, part) in crate::stiff::cases(3000) {
        let truth = exact.airlight(sigma_t.into(), &part.into());
        if truth > f64::from(f32::MIN_POSITIVE) && truth < 1e38 {
            let error = (f64::from(framed.airlight(sigma_t, &part)) / truth - 1.0).abs();
            assert!(error <= 2e-5, "{sigma_t} {part:?}: {error}");
        }
    }
    // Short steps, far ones, other extinctions.
    for gamma in angles().into_iter().filter(|gamma| *gamma > 0.0) {
        for x in [0.0, 1.0, 3.9, 4.0, 5.0, 40.0, 400.0] {
            for length in [1e-5, 1e-2, 1.0, f64::INFINITY] {
                for sigma_t in [0.1_f32, 0.2] {
                    let part = segment(4.0, gamma, x, length);
                    let truth = exact.airlight(sigma_t.into(), &part.into());
                    if truth > f64::from(f32::MIN_POSITIVE) && truth < 1e38 {
                        let found = f64::from(framed.airlight(sigma_t, &part));
                        let error = (found / truth - 1.0).abs();
                        assert!(error <= 4e-3, "{sigma_t} {part:?}: {error}");
                    }
                }
            }
        }
    }
}

/// Down to what images take for a ray through the light, and nearer.
#[test]
fn rays_next_to_the_light_are_resolved() {
    let phase = PhaseFunction::Isotropic;
    let table = FrameTable::new(&phase, 0.1, 4.0, 128).unwrap();
    let all = Table::new(&phase, 64).unwrap();
    for i in 0..50 {
        let gamma = 1e-5 * 10_f64.powf(f64::from(i) / 12.0);
        let part = segment(4.0, gamma, 0.0, 9.0);
        let (found, known) = (table.look_up(&part).unwrap(), all.airlight(0.1, &part));
        let error = (found / known - 1.0).abs();
        assert!(error < 4e-4, "{gamma}: {found} {known}");
    }
}

#[test]
fn bad_sizes_and_lengths_are_errors() {
    let iso = PhaseFunction::Isotropic;
    let made = |sigma, distance, rows| FrameTable::new(&iso, sigma, distance, rows).is_ok();
    assert!(made(0.1, 1.0, 16) && made(0.0, 1e9, 1024) && made(16.0, 1.0, 64));
    for sigma in [-1.0, f32::NAN, f32::INFINITY, 16.1] {
        assert!(!made(sigma, 1.0, 64), "{sigma}");
    }
    for distance in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e10] {
        assert!(!made(0.0, distance, 64), "{distance}");
    }
    for rows in [0, 8, 20, 1032] {
        assert!(!made(0.1, 1.0, rows), "{rows}");
    }
    let sharp = PhaseFunction::HenyeyGreenstein { g: 1.0 };
    assert!(FrameTable::new(&sharp, 0.1, 1.0, 64).is_err());
}

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
fn judged(table: &FrameTable, exact: &Exact, parts: &[Segment]) -> (f64, f64) {
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
                let (error, refused) = judged(&table, &exact, list);
                println!("{phase:?} {depth}: {error:.1e}, {refused:.2} refused");
                assert!(error <= allowed, "{phase:?} {depth}: {error}");
                // Through much fog, and steps of sharp peaks.
                assert!(refused <= 0.35, "{phase:?} {depth}: {refused}");
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
        judged(&table, &exact, &runs).0
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
        }
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
        let found = table.look_up(&refused);
        // On the axis the light itself may be told from a refusal.
        assert!(
            found.is_none_or(|l| l == f32::INFINITY),
            "{refused:?}: {found:?}"
        );
    }
    let rest = Quadrature::with_tolerance(phase, 1e-5).unwrap();
    let framed = Framed::new(table, rest);
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

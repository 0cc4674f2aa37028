//! The evaluators of `airlight` against the truth, over stiff segments.

use airlight::{Evaluator, Exact, PhaseFunction, Quadrature, Segment, Segment64, SunTable, Table};
use reference::segments::{Case, easy, stiff};
use reference::tolerances::Allowed;

const PHASES: [PhaseFunction; 6] = [
    PhaseFunction::Isotropic,
    PhaseFunction::Rayleigh,
    PhaseFunction::HenyeyGreenstein { g: 0.9 },
    PhaseFunction::HenyeyGreenstein { g: -0.6 },
    PhaseFunction::Schlick { k: 0.8 },
    PhaseFunction::CornetteShanks { g: 0.7 },
];

/// Relative errors of results that are normal f32; others must be small too.
fn errors(cases: &[Case], value: impl Fn(&Case) -> f64) -> Vec<f64> {
    let smallest = f64::from(f32::MIN_POSITIVE);
    let mut errors: Vec<f64> = cases
        .iter()
        .map(|case| {
            let value = value(case);
            assert!(value.is_finite() && value >= 0.0, "{case:?}: {value}");
            if case.truth >= smallest {
                (value - case.truth).abs() / case.truth
            } else {
                assert!(value < 2.0 * smallest, "{case:?}: {value}");
                0.0
            }
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    errors
}

fn worst(cases: &[Case], evaluator: &impl Evaluator) -> f64 {
    let value = |case: &Case| f64::from(evaluator.airlight(case.sigma_t, &case.part.into()));
    errors(cases, value).last().copied().unwrap()
}

#[test]
fn the_exact_evaluator_is_the_truth() {
    for phase in PHASES {
        let exact = Exact::new(phase).unwrap();
        let errors = errors(&stiff(phase), |case| {
            exact.airlight(
                case.sigma_t.into(),
                &Segment64::from(Segment::from(case.part)),
            )
        });
        let worst = errors.last().unwrap();
        assert!(
            *worst <= Allowed::ExactAirlight.error(),
            "{phase:?}: {worst:e}"
        );
    }
}

#[test]
fn tables_keep_the_bound_that_they_state() {
    for phase in PHASES {
        let table = Table::new(&phase, 64).unwrap();
        let (bound, worst) = (f64::from(table.error_bound()), worst(&stiff(phase), &table));
        assert!(worst <= bound, "{phase:?}: {worst:e} of {bound:e}");
    }
    // What is asked of them: 1e-4 in 64 KiB.
    let table = Table::new(&PhaseFunction::Isotropic, 64).unwrap();
    assert!(table.error_bound() <= 1e-4 && table.bytes() <= 64 << 10);
}

#[test]
fn quadratures_keep_their_tolerance() {
    for phase in PHASES {
        let cases = stiff(phase);
        for tolerance in [1e-2_f32, 1e-4] {
            let rule = Quadrature::with_tolerance(phase, tolerance).unwrap();
            let worst = worst(&cases, &rule);
            assert!(
                worst <= f64::from(tolerance),
                "{phase:?} {tolerance}: {worst:e}"
            );
        }
    }
}

#[test]
fn the_published_table_is_as_good_as_published_on_ordinary_rays() {
    let table = SunTable::new();
    let errors = errors(&easy(PhaseFunction::Isotropic, 6000), |case| {
        f64::from(table.airlight(case.sigma_t, &case.part.into()))
    });
    let median = errors[errors.len() / 2];
    assert!(median <= 1e-5, "{median:e}");
}

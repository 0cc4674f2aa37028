//! What must hold for the methods that adaptive curves are compared with.

mod support;

use proptest::prelude::*;
use support::{errors, probes, streams, truth};
use transmittance::baseline::{
    Captured, Deep, FourierCurve, MomentCurve, Moments, OpacityCurve, Range, Uncompressed,
};
use transmittance::{Accumulate, BlockerSegment, Error, Evaluate};

const CASES: u32 = if cfg!(debug_assertions) { 1_000 } else { 8_000 };

fn curve<A: Accumulate>(mut accumulator: A, segments: &[BlockerSegment]) -> A::Curve {
    for segment in segments {
        accumulator.insert(segment);
    }
    accumulator.finish()
}

/// A range that all of the segments lie in.
fn range(segments: &[BlockerSegment]) -> Range {
    let ends = || segments.iter().flat_map(|s| [s.entry(), s.exit()]);
    let near = ends().fold(f32::MAX, f32::min);
    let far = ends().fold(f32::MIN, f32::max);
    if near < far {
        Range::new(near, far).expect("an ordered range")
    } else if near.abs() < 1e37 {
        // A single depth, or none.
        let at = if near == far { near } else { 0.0 };
        let around = 1.0 + 0.5 * at.abs();
        Range::new(at - around, at + around).expect("an ordered range")
    } else {
        Range::new(f32::MIN, f32::MAX).expect("an ordered range")
    }
}

proptest! {
    #![proptest_config(reference::property::cases(CASES))]

    #[test]
    fn uncompressed_curves_are_exact(s in streams::hard(60)) {
        let curve = curve(Captured::new(), &s);
        let mut before = 1.0;
        for depth in probes(&s) {
            let (value, exact) = (curve.transmittance(depth), truth(&s, depth, 0));
            prop_assert!(value <= before);
            before = value;
            // Half an ULP of the optical depth, twice: τ exp(−τ) ≤ 0.37.
            let error = (f64::from(value) - exact).abs();
            prop_assert!(error <= 2e-7, "{error:e} at {depth:e}");
        }
    }

    #[test]
    fn deep_curves_are_within_epsilon(s in streams::hard(60), power in -4.0_f32..-0.3) {
        let epsilon = 10.0_f32.powf(power);
        let plain = curve(Deep::new(epsilon).unwrap(), &s);
        let monotone = curve(Deep::monotone(epsilon).unwrap(), &s);
        let mut before = 1.0;
        for depth in probes(&s) {
            let exact = truth(&s, depth, 0);
            let error = (f64::from(plain.transmittance(depth)) - exact).abs();
            prop_assert!(error <= f64::from(epsilon), "{error} of {epsilon} at {depth:e}");
            let value = monotone.transmittance(depth);
            let error = (f64::from(value) - exact).abs();
            prop_assert!(error <= f64::from(epsilon), "{error} of {epsilon} at {depth:e}");
            prop_assert!((0.0..=before).contains(&value), "{value} after {before} at {depth:e}");
            before = value;
        }
    }

    #[test]
    fn moments_know_an_interval_that_holds(
        s in streams::hard(30),
        count in prop_oneof![Just(4_usize), Just(6), Just(8)],
    ) {
        // Blockers as moments have them.
        let s: Vec<BlockerSegment> = s
            .iter()
            .map(|s| {
                let tau = s.optical_depth()[0].min(8.0);
                BlockerSegment::from_optical_depth(s.entry(), s.exit(), tau).unwrap()
            })
            .collect();
        let range = range(&s);
        let curve = curve(Moments::new(count, range).unwrap(), &s);
        let total: f64 = s.iter().map(|s| f64::from(s.optical_depth()[0])).sum();
        for depth in probes(&s) {
            let [least, most] = curve.interval(depth);
            prop_assert!(0.0 <= least && least <= most, "{least} {most}");
            if depth < range.near() || depth > range.far() {
                continue;
            }
            let exact = -truth(&s, depth, 0).max(1e-300).ln();
            // What f32 leaves of a position in the range, as optical depth,
            // is nowhere near the allowance; sums of f64 are exact by comparison.
            let slack = 1e-6 * total + 1e-9;
            prop_assert!(
                least - slack <= exact && exact <= most + slack,
                "{exact} outside of {least}..{most} of {total} at {depth:e}"
            );
            let value = curve.transmittance(depth);
            prop_assert!((0.0..=1.0).contains(&value));
        }
    }

    #[test]
    fn nothing_leaves_its_range_or_is_not_a_number(
        s in streams::hard(40),
        near in -100.0_f32..100.0,
        length in prop_oneof![1e-3_f32..200.0, Just(1e37)],
    ) {
        let range = Range::new(near, near + length).unwrap();
        let opacity = curve(OpacityCurve::<32>::new(range), &s);
        let fourier = curve(FourierCurve::<16>::new(range), &s);
        let moments = curve(Moments::new(8, range).unwrap(), &s);
        let mut before = 1.0;
        for depth in probes(&s).into_iter().chain([f32::INFINITY, f32::NAN]) {
            for value in [opacity.evaluate(depth), fourier.evaluate(depth), moments.evaluate(depth)] {
                prop_assert!((0.0..=1.0).contains(&value[0]), "{value:?} at {depth:e}");
            }
            if !depth.is_nan() {
                let value = opacity.transmittance(depth);
                // Interpolation in f32: an ULP.
                prop_assert!(value <= before * (1.0 + 3e-7));
                before = value;
            }
        }
    }

    #[test]
    fn opacity_maps_are_exact_at_their_slices(s in streams::hard(30)) {
        let s: Vec<BlockerSegment> = s
            .iter()
            .map(|s| {
                let tau = s.optical_depth()[0].min(8.0);
                BlockerSegment::from_optical_depth(s.entry(), s.exit(), tau).unwrap()
            })
            .collect();
        // Slices at whole numbers; what is outside of the range would be moved.
        // Positions are shares of the range, to 1e-14 of it.
        let fine = |x: f32| x == x.round() || (x - x.round()).abs() > 1e-6;
        let inside = |s: &BlockerSegment| {
            let length = s.exit() - s.entry();
            s.entry() >= -32.0
                && s.exit() <= 32.0
                && fine(s.entry())
                && fine(s.exit())
                && (length == 0.0 || length > 1e-6)
        };
        let s: Vec<BlockerSegment> = s.into_iter().filter(inside).collect();
        let curve = curve(OpacityCurve::<65>::new(Range::new(-32.0, 32.0).unwrap()), &s);
        for slice in -31..32 {
            let (value, exact) = (curve.transmittance(slice as f32), truth(&s, slice as f32, 0));
            // One rounding per segment, of τ exp(−τ).
            prop_assert!((f64::from(value) - exact).abs() <= 1e-6 * s.len() as f64);
        }
    }
}

#[test]
fn every_method_reaches_its_published_quality_on_smoke() {
    let (mut fourier, mut opacity) = (0.0, 0.0);
    let mut moments = [0.0; 3];
    for seed in 0..8 {
        let smoke = streams::columns_of_smoke(seed);
        let range = range(&smoke);
        let mean = |evaluate: &dyn Evaluate| errors(&smoke, |z| evaluate.evaluate(z)[0]).0 / 8.0;
        fourier += mean(&curve(FourierCurve::<16>::new(range), &smoke));
        opacity += mean(&curve(OpacityCurve::<32>::new(range), &smoke));
        for (sum, count) in moments.iter_mut().zip([4, 6, 8]) {
            *sum += mean(&curve(Moments::new(count, range).unwrap(), &smoke));
        }
    }
    // On 15 % long features 32 slices and 16 frequencies are right to a percent,
    // and more moments are better.
    assert!(opacity < 0.01, "{opacity}");
    assert!(fourier < 0.01, "{fourier}");
    assert!(
        moments[0] > moments[1] && moments[1] > moments[2],
        "{moments:?}"
    );
}

#[test]
fn loose_ranges_cost_fixed_bases_their_accuracy() {
    let smoke = streams::columns_of_smoke(1);
    let tight = range(&smoke);
    let length = tight.far() - tight.near();
    let error = |times: f32| {
        let range = Range::new(tight.near(), tight.near() + times * length).unwrap();
        let mean = |evaluate: &dyn Evaluate| errors(&smoke, |z| evaluate.evaluate(z)[0]).0;
        [
            mean(&curve(OpacityCurve::<32>::new(range), &smoke)),
            mean(&curve(FourierCurve::<16>::new(range), &smoke)),
        ]
    };
    let (tight, loose) = (error(1.0), error(10.0));
    for (tight, loose) in tight.into_iter().zip(loose) {
        assert!(loose > 3.0 * tight, "{loose} {tight}");
    }
}

#[test]
fn one_blocker_fits_into_any_moments() {
    let range = Range::new(0.0, 10.0).unwrap();
    for count in [4, 6, 8] {
        let wall = [BlockerSegment::surface(4.0, 0.3).unwrap()];
        let curve = curve(Moments::new(count, range).unwrap(), &wall);
        // The matrix has rank one but for what is mixed in, whose share of the
        // optical depth bounds the error.
        assert!((curve.transmittance(2.0) - 1.0).abs() < 0.01);
        assert!((curve.transmittance(6.0) - 0.3).abs() < 0.01);
        assert_eq!(
            curve.transmittance(11.0),
            curve.transmittance(f32::INFINITY)
        );
    }
}

#[test]
fn clear_rays_are_clear_in_every_method() {
    let range = Range::new(0.0, 1.0).unwrap();
    let clear = [BlockerSegment::from_density(0.0, 1.0, 0.0).unwrap()];
    let curves: [Box<dyn Evaluate>; 5] = [
        Box::new(curve(Captured::new(), &clear)),
        Box::new(curve(Deep::new(0.01).unwrap(), &clear)),
        Box::new(curve(OpacityCurve::<4>::new(range), &clear)),
        Box::new(curve(FourierCurve::<4>::new(range), &clear)),
        Box::new(curve(Moments::new(4, range).unwrap(), &clear)),
    ];
    for curve in curves {
        for depth in [-1.0, 0.0, 0.5, 1.0, 2.0, f32::NAN] {
            assert_eq!(curve.evaluate(depth), [1.0]);
        }
    }
}

#[test]
fn settings_out_of_range_are_named() {
    let message = |error: Error| error.to_string();
    assert!(message(Range::new(2.0, 1.0).unwrap_err()).contains("is 1"));
    assert!(message(Range::new(f32::NAN, 1.0).unwrap_err()).contains("NaN"));
    assert!(message(Range::new(0.0, f32::INFINITY).unwrap_err()).contains("inf"));
    assert!(message(Deep::new(0.0).unwrap_err()).contains("is 0"));
    assert!(message(Deep::monotone(f32::NAN).unwrap_err()).contains("NaN"));
    let range = Range::new(0.0, 1.0).unwrap();
    assert!(message(Moments::new(5, range).unwrap_err()).contains("4, 6 or 8"));
}

#[test]
fn memory_is_what_the_documentation_says() {
    // Beside the curve itself, its range or its count.
    assert_eq!(size_of::<OpacityCurve<32>>(), 4 * 32 + size_of::<Range>());
    assert_eq!(size_of::<FourierCurve<16>>(), 8 * 16 + size_of::<Range>());
    assert!(size_of::<MomentCurve>() <= 36 + size_of::<Range>() + 4);
    assert_eq!(curve(Captured::new(), &streams::hair(1)).len(), 116);
    assert!(Uncompressed::is_empty(&curve(Captured::new(), &[])));
}

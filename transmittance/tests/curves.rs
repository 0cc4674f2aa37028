//! What must hold for every curve.

mod support;

use proptest::prelude::*;
use support::{probes, streams, truth};
use transmittance::{
    Accumulate, Area, BlockerSegment, Curve, Exponential, Linear, Lookup, Maximum, Metric, Sorted,
    Stream,
};

/// In release builds the eight streams of the properties about what a curve
/// promises are more than 1e5.
const CASES: u32 = if cfg!(debug_assertions) {
    1_500
} else {
    13_000
};

fn config() -> ProptestConfig {
    reference::property::cases(CASES)
}

fn by_papers_rule<const N: usize, L: Lookup>(segments: &[BlockerSegment]) -> Curve<N, L> {
    let mut curve = Curve::new();
    for segment in segments {
        curve.insert(segment);
    }
    curve
}

fn streamed<const N: usize, M: Metric, L: Lookup, const W: usize>(
    segments: &[BlockerSegment],
) -> Curve<N, L> {
    let mut stream = Stream::<N, M, L, 1, W>::new();
    for segment in segments {
        stream.insert(segment);
    }
    stream.finish()
}

/// Everything that a curve promises, whatever was removed.
fn keeps_its_promises<const N: usize, L: Lookup>(curve: &Curve<N, L>, segments: &[BlockerSegment]) {
    let ends: Vec<f32> = segments
        .iter()
        .filter(|segment| !segment.is_clear())
        .flat_map(|segment| [segment.entry(), segment.exit()])
        .collect();
    assert!(curve.points().len() <= N);
    for (depth, _) in curve.points() {
        assert!(ends.contains(&depth), "a node at {depth}, where nothing is");
    }
    let first = ends.iter().copied().fold(f32::INFINITY, f32::min);
    assert_eq!(curve.transmittance(first), 1.0, "in front of everything");
    let largest = curve.max_error_bound();
    assert!((0.0..=1.0).contains(&largest));
    let mut before = 1.0;
    for depth in probes(segments) {
        let (value, bound) = (curve.transmittance(depth), curve.error_bound(depth));
        assert!((0.0..=1.0).contains(&value), "{value} at {depth}");
        assert!(value <= before, "rises from {before} to {value} at {depth}");
        before = value;
        let error = (f64::from(value) - truth(segments, depth, 0)).abs();
        assert!(
            error <= f64::from(bound),
            "off by {error:e} at {depth:e}, bound {bound:e}, nodes {:?}",
            curve.points().collect::<Vec<_>>()
        );
        assert!(bound <= largest);
    }
    // Behind everything only rounding is left: of each factor and each product.
    let last = truth(segments, f32::INFINITY, 0);
    let roundings = 4.0 * (segments.len() as f64 + 1.0) * 6e-8;
    let error = (f64::from(curve.transmittance(f32::INFINITY)) - last).abs();
    assert!(
        error <= roundings * last.max(-last * last.ln()) + 1.2e-38,
        "{error:e}"
    );
}

/// Both halves of a segment if it has a middle, else the segment.
fn halves(segment: &BlockerSegment) -> Vec<BlockerSegment> {
    let (a, b) = (segment.entry(), segment.exit());
    let middle = a + 0.5 * (b - a);
    let half = 0.5 * segment.optical_depth()[0];
    if a < middle && middle < b && middle - a == b - middle {
        [(a, middle), (middle, b)]
            .map(|(a, b)| BlockerSegment::from_optical_depth(a, b, half).expect("a sound half"))
            .into()
    } else {
        vec![*segment]
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn papers_rule_with_linear_lookup_keeps_its_promises(s in streams::hard(40)) {
        keeps_its_promises(&by_papers_rule::<8, Linear>(&s), &s);
    }

    #[test]
    fn papers_rule_with_exponential_lookup_keeps_its_promises(s in streams::hard(40)) {
        keeps_its_promises(&by_papers_rule::<8, Exponential>(&s), &s);
    }

    #[test]
    fn streams_of_least_area_keep_their_promises(s in streams::hard(60)) {
        keeps_its_promises(&streamed::<4, Area, Exponential, 4>(&s), &s);
        keeps_its_promises(&streamed::<8, Area, Exponential, 4>(&s), &s);
    }

    #[test]
    fn streams_of_least_maximum_keep_their_promises(s in streams::hard(60)) {
        keeps_its_promises(&streamed::<4, Maximum, Exponential, 4>(&s), &s);
        keeps_its_promises(&streamed::<8, Maximum, Exponential, 4>(&s), &s);
    }

    #[test]
    fn linear_streams_keep_their_promises(s in streams::hard(40)) {
        keeps_its_promises(&streamed::<5, Area, Linear, 3>(&s), &s);
        keeps_its_promises(&streamed::<8, Maximum, Linear, 2>(&s), &s);
    }

    #[test]
    fn the_least_of_curves_keep_their_promises(s in streams::hard(12)) {
        keeps_its_promises(&by_papers_rule::<2, Linear>(&s), &s);
        keeps_its_promises(&by_papers_rule::<2, Exponential>(&s), &s);
        keeps_its_promises(&streamed::<2, Area, Exponential, 2>(&s), &s);
        keeps_its_promises(&streamed::<3, Maximum, Linear, 2>(&s), &s);
    }

    #[test]
    fn streams_with_many_walls_keep_their_promises(s in streams::dark(40)) {
        keeps_its_promises(&by_papers_rule::<4, Exponential>(&s), &s);
        keeps_its_promises(&by_papers_rule::<8, Exponential>(&s), &s);
        keeps_its_promises(&streamed::<8, Area, Exponential, 4>(&s), &s);
        keeps_its_promises(&streamed::<4, Maximum, Exponential, 4>(&s), &s);
        let (front, back) = s.split_at(s.len() / 2);
        let merged = by_papers_rule::<8, Exponential>(front).merged(&by_papers_rule(back));
        keeps_its_promises(&merged, &s);
    }

    #[test]
    fn merged_curves_keep_their_promises(a in streams::hard(20), b in streams::hard(20)) {
        let both: Vec<BlockerSegment> = a.iter().chain(&b).copied().collect();
        let merged = by_papers_rule::<8, Linear>(&a).merged(&by_papers_rule(&b));
        keeps_its_promises(&merged, &both);
        let merged = by_papers_rule::<8, Exponential>(&a).merged(&by_papers_rule(&b));
        keeps_its_promises(&merged, &both);
    }

    #[test]
    fn nothing_is_lost_while_there_is_room(s in streams::hard(16), seed in 0_u64..1000) {
        let curve = by_papers_rule::<64, Exponential>(&s);
        let mut other = s.clone();
        streams::Random::new(seed).shuffle(&mut other);
        let halves: Vec<BlockerSegment> = other
            .iter()
            .flat_map(halves)
            .take(31)
            .collect();
        let (shuffled, split) = (
            by_papers_rule::<64, Exponential>(&other),
            by_papers_rule::<64, Exponential>(&halves),
        );
        for depth in probes(&s) {
            // A share 2 n 2⁻²⁴ of the optical depth and the exponential's own.
            let exact = truth(&s, depth, 0);
            let tau = -exact.max(f64::MIN_POSITIVE).ln();
            let tolerance = (128.0 * 6e-8 * tau + 2.4e-7) * exact + 1.2e-38;
            let error = (f64::from(curve.transmittance(depth)) - exact).abs();
            prop_assert!(error <= tolerance, "{error:e}");
            let difference = (curve.transmittance(depth) - shuffled.transmittance(depth)).abs();
            prop_assert!(f64::from(difference) <= 2.0 * tolerance, "{difference:e}");
            if halves.len() < 31 {
                let difference = (curve.transmittance(depth) - split.transmittance(depth)).abs();
                prop_assert!(f64::from(difference) <= 2.0 * tolerance, "{difference:e}");
            }
        }
    }

    #[test]
    fn splitting_segments_changes_linear_curves_within_their_bounds(s in streams::hard(16)) {
        let halves: Vec<BlockerSegment> = s.iter().flat_map(halves).collect();
        let (whole, split) = (
            by_papers_rule::<16, Linear>(&s),
            by_papers_rule::<16, Linear>(&halves),
        );
        for depth in probes(&s) {
            let difference = (whole.transmittance(depth) - split.transmittance(depth)).abs();
            let bound = whole.error_bound(depth) + split.error_bound(depth);
            prop_assert!(difference <= bound, "{difference:e} of {bound:e} at {depth:e}");
        }
    }

    #[test]
    fn clear_segments_change_nothing(s in streams::hard(20), at in -10.0_f32..10.0) {
        let clear = BlockerSegment::from_density(at, at + 3.0, 0.0).unwrap();
        let with: Vec<BlockerSegment> = s.iter().flat_map(|segment| [*segment, clear]).collect();
        prop_assert_eq!(by_papers_rule::<8, Linear>(&s), by_papers_rule(&with));
        prop_assert_eq!(
            streamed::<8, Area, Exponential, 4>(&s),
            streamed::<8, Area, Exponential, 4>(&with)
        );
    }

    #[test]
    fn depth_can_be_scaled_and_shifted(seed in 0_u64..1_000_000, power in -20_i32..20) {
        // Powers of two and small whole numbers are exact, so that every
        // decision is the same.
        let scale = 2.0_f32.powi(power);
        let mut random = streams::Random::new(seed);
        let plain: Vec<(f32, f32, f32)> = (0..40)
            .map(|_| ((random.unit() * 200.0).floor(), (random.unit() * 8.0).floor(), random.unit()))
            .collect();
        let stream = |scale: f32, shift: f32| -> Vec<BlockerSegment> {
            let place = |x: f32| scale * (x + shift);
            let segment = |&(a, length, tau): &(f32, f32, f32)| {
                BlockerSegment::from_optical_depth(place(a), place(a + length), tau).unwrap()
            };
            plain.iter().map(segment).collect()
        };
        let (a, b) = (stream(1.0, 0.0), stream(scale, 64.0));
        let (a, b) = (streamed::<8, Area, Exponential, 4>(&a), streamed::<8, Area, Exponential, 4>(&b));
        for depth in 0..220 {
            let depth = depth as f32;
            prop_assert_eq!(a.transmittance(depth), b.transmittance(scale * (depth + 64.0)));
        }
    }

    #[test]
    fn depth_at_is_the_last_float_that_is_not_below(s in streams::hard(30), t in share()) {
        is_the_last_float(&by_papers_rule::<8, Exponential>(&s), t);
        is_the_last_float(&by_papers_rule::<8, Linear>(&s), t);
        is_the_last_float(&streamed::<4, Area, Exponential, 4>(&s), t);
    }

    #[test]
    fn sorted_streams_do_not_depend_on_the_order(s in streams::hard(60), seed in 0_u64..1000) {
        let mut other = s.clone();
        streams::Random::new(seed).shuffle(&mut other);
        let curve = |segments: &[BlockerSegment]| {
            let mut sorted = Sorted::new(Stream::<8>::new());
            segments.iter().for_each(|segment| sorted.insert(segment));
            sorted.finish()
        };
        prop_assert_eq!(curve(&s), curve(&other));
    }
}

/// Transmittances of all orders of magnitude, the ends included.
fn share() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => 0.0_f32..1.0,
        2 => (-87.0_f32..0.0).prop_map(f32::exp),
        1 => Just(1.0),
        1 => Just(1.0_f32.next_down()),
    ]
}

/// At the answer the curve is not below `t`, at the next float it is.
fn is_the_last_float<const N: usize, L: Lookup>(curve: &Curve<N, L>, t: f32) {
    let depth = curve.depth_at(t);
    if depth == f32::INFINITY {
        assert!(curve.transmittance(f32::INFINITY) >= t);
        return;
    }
    assert!(curve.transmittance(depth) >= t, "{depth:e} is too far");
    assert!(
        curve.transmittance(depth.next_up()) < t,
        "{depth:e} is too near"
    );
}

#[test]
fn depth_at_does_not_step_over_a_blocker_of_one_float() {
    let (entry, exit) = (1.0_f32, 1.0_f32.next_up());
    let curve =
        by_papers_rule::<4, Exponential>(&[
            BlockerSegment::from_optical_depth(entry, exit, 5.0).unwrap()
        ]);
    assert_eq!(curve.transmittance(exit), (-5.0_f32).exp());
    assert_eq!(curve.depth_at(0.02), entry);
    assert_eq!(curve.depth_at(0.006), f32::INFINITY);
}

/// Two orders of each of 200 streams by four rules. A certificate is compared with the
/// curve at every entry and exit of the stream and between them, where the difference
/// of two curves that are monotonic there has its largest values: no depth is left out.
#[test]
fn smoke_hair_and_voxels_keep_their_promises_in_any_order() {
    for kind in [
        streams::columns_of_smoke,
        streams::voxels,
        streams::hair,
        streams::hair_in_smoke,
        streams::smoke_around_walls,
    ] {
        for seed in 0..40 {
            let mut stream = kind(seed);
            for _ in 0..2 {
                keeps_its_promises(&by_papers_rule::<8, Linear>(&stream), &stream);
                keeps_its_promises(&by_papers_rule::<8, Exponential>(&stream), &stream);
                keeps_its_promises(&streamed::<8, Area, Exponential, 4>(&stream), &stream);
                keeps_its_promises(&streamed::<8, Maximum, Exponential, 4>(&stream), &stream);
                streams::Random::new(seed).shuffle(&mut stream);
            }
        }
    }
}

#[test]
fn thousands_of_coincident_faces_take_two_nodes() {
    let face = BlockerSegment::surface(3.0, 0.999).unwrap();
    let faces = vec![face; 5000];
    for curve in [
        streamed::<8, Area, Exponential, 4>(&faces),
        by_papers_rule::<8, Exponential>(&faces),
    ] {
        assert_eq!(curve.points().len(), 2);
        keeps_its_promises(&curve, &faces);
    }
    keeps_its_promises(&by_papers_rule::<8, Linear>(&faces), &faces);
    let walls = vec![BlockerSegment::opaque(3.0).unwrap(); 5000];
    keeps_its_promises(&by_papers_rule::<8, Linear>(&walls), &walls);
    keeps_its_promises(&streamed::<8, Maximum, Exponential, 4>(&walls), &walls);
}

/// 1e5 segments through 1000, of lengths from 1e-3 to 1e3.
fn a_hundred_thousand(seed: u64) -> Vec<BlockerSegment> {
    let mut random = streams::Random::new(seed);
    (0..100_000)
        .map(|_| {
            let entry = 1e3 * random.unit();
            let length = 1e-3 * 1e6_f32.powf(random.unit());
            let tau = 6e-5 * random.unit();
            BlockerSegment::from_optical_depth(entry, entry + length, tau).expect("sound numbers")
        })
        .collect()
}

#[test]
fn a_hundred_thousand_segments_keep_their_bound() {
    let segments = a_hundred_thousand(5);
    let curve = streamed::<16, Area, Exponential, 4>(&segments);
    let linear = by_papers_rule::<16, Linear>(&segments);
    for step in 0..60 {
        let depth = 20.0 * step as f32;
        let exact = truth(&segments, depth, 0);
        for (value, bound) in [
            (curve.transmittance(depth), curve.error_bound(depth)),
            (linear.transmittance(depth), linear.error_bound(depth)),
        ] {
            assert!((f64::from(value) - exact).abs() <= f64::from(bound));
        }
    }
}

#[test]
fn bounds_of_a_hundred_thousand_segments_are_of_use() {
    let bound = |seed| {
        let curve = streamed::<16, Area, Exponential, 4>(&a_hundred_thousand(seed));
        curve.max_error_bound()
    };
    // Roundings alone are 2e5 times 2⁻²⁴ of τ exp(−τ), so half a percent.
    let mean = (5..13).map(bound).sum::<f32>() / 8.0;
    assert!(mean < 0.05, "{mean}");
}

#[test]
fn depths_at_the_limits_of_f32_are_like_any_other() {
    let segments = [
        BlockerSegment::from_optical_depth(-f32::MAX, f32::MAX, 1.0).unwrap(),
        BlockerSegment::from_optical_depth(-1e-45, 1e-45, 1.0).unwrap(),
        BlockerSegment::surface(f32::MAX, 0.5).unwrap(),
        BlockerSegment::surface(-f32::MAX, 0.5).unwrap(),
        BlockerSegment::from_optical_depth(f32::MAX.next_down(), f32::MAX, 0.25).unwrap(),
    ];
    keeps_its_promises(&by_papers_rule::<4, Exponential>(&segments), &segments);
    keeps_its_promises(&by_papers_rule::<4, Linear>(&segments), &segments);
    keeps_its_promises(
        &streamed::<4, Maximum, Exponential, 4>(&segments),
        &segments,
    );
    keeps_its_promises(&streamed::<3, Area, Linear, 3>(&segments), &segments);
}

#[test]
fn questions_without_an_answer_have_documented_ones() {
    let curve = by_papers_rule::<4, Exponential>(&[BlockerSegment::surface(1.0, 0.5).unwrap()]);
    assert_eq!(curve.transmittance(f32::NAN), 1.0);
    assert_eq!(curve.depth_at(f32::NAN), f32::INFINITY);
    assert_eq!(curve.depth_at(0.5), f32::INFINITY);
    assert_eq!(curve.depth_at(0.75), 1.0);
    assert_eq!(curve.depth_at(1.0), 1.0);
    assert_eq!(curve.depth_at(1.5), f32::NEG_INFINITY);
    let clear = Curve::<4>::new();
    assert_eq!(clear.transmittance(0.0), 1.0);
    assert_eq!(clear.depth_at(1.0), f32::INFINITY);
    assert_eq!(clear.max_error_bound(), 0.0);
    assert_eq!(clear.merged(&curve), curve.merged(&clear));
    assert_eq!(Stream::<4>::new().finish(), clear);
}

#[test]
fn colours_share_their_nodes_and_keep_their_bounds() {
    let mut random = streams::Random::new(9);
    for _ in 0..200 {
        let segments: Vec<BlockerSegment<3>> = (0..80)
            .map(|_| {
                let entry = 50.0 * random.unit();
                let exit = entry + 10.0 * random.unit() * random.unit();
                let tau = [0.1, 0.02, 0.3].map(|most| most * random.unit());
                BlockerSegment::with_optical_depths(entry, exit, tau).unwrap()
            })
            .collect();
        let (mut stream, mut curve) = (
            Stream::<8, Area, Exponential, 3>::new(),
            Curve::<8, Linear, 3>::new(),
        );
        for segment in &segments {
            stream.insert(segment);
            curve.insert(segment);
        }
        let stream = stream.finish();
        for depth in probes(&segments) {
            for channel in 0..3 {
                let exact = truth(&segments, depth, channel);
                for (value, bound) in [
                    (stream.transmittances(depth), stream.error_bounds(depth)),
                    (curve.transmittances(depth), curve.error_bounds(depth)),
                ] {
                    let error = (f64::from(value[channel]) - exact).abs();
                    assert!(error <= f64::from(bound[channel]));
                }
            }
        }
    }
}

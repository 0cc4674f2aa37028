//! Maps made and asked on a GPU, against the CPU and against the truth.

#![cfg(feature = "wgpu")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

mod support;

use gpu_backend::gpu::{Argument, Context, Gpu, GpuMemory, INDEX_WGSL, Kernel, Queued, Workgroups};
use gpu_backend::{Backend, Buffer, Cpu, Download, Host, testing};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use support::{errors, probes, streams, truth};
use transmittance::gpu::{LOOKUP_ERROR, WgslRule, WgslSegments, WgslStored, lookup_parts};
use transmittance::{
    Accumulate, Area, BlockerSegment, BuildMap, CaptureSegments, Curve, Evaluate, Exponential,
    Filter, Linear, Lists, Lookup, Maximum, Order, Packed, PackedHalf, QueryMap, Receiver,
    SegmentLists, Stored, Stream, TransmittanceMap,
};

type Streams<const C: usize = 1> = Vec<Vec<BlockerSegment<C>>>;

/// One texel per stream, in a row.
fn listed<const C: usize>(gpu: &Gpu<Queued>, streams: &Streams<C>) -> SegmentLists<GpuMemory, C> {
    let mut offsets = vec![0];
    for stream in streams {
        offsets.push(offsets[offsets.len() - 1] + stream.len() as u32);
    }
    let segments = streams.concat();
    let lists = Lists::new([streams.len(), 1], &offsets, &segments).unwrap();
    lists.upload(gpu).unwrap()
}

/// The curves of streams as the GPU makes them.
fn made<A, P, const C: usize>(
    gpu: &Gpu<Queued>,
    clear: &A,
    streams: &Streams<C>,
) -> TransmittanceMap<Host, P, C>
where
    A: WgslRule<C>,
    A::Curve: Into<P>,
    P: WgslStored<C>,
{
    let mut map = TransmittanceMap::<GpuMemory, P, C>::new(gpu, [streams.len(), 1]).unwrap();
    gpu.build_map(clear, &listed(gpu, streams), &mut map)
        .unwrap();
    map.download(gpu).unwrap()
}

fn accumulated<A: Accumulate<C> + Clone, const C: usize>(
    clear: &A,
    stream: &[BlockerSegment<C>],
) -> A::Curve {
    let mut accumulator = clear.clone();
    stream
        .iter()
        .for_each(|segment| accumulator.insert(segment));
    accumulator.finish()
}

/// Whether a shader sees the depths as they are.
fn is_normal(stream: &[BlockerSegment]) -> bool {
    let ends = stream.iter().flat_map(|s| [s.entry(), s.exit()]);
    ends.into_iter()
        .all(|depth| depth == 0.0 || depth.is_normal())
}

/// Streams of every kind: hard ones, those like smoke and hair, and in any order.
fn all_kinds(most: usize) -> Streams {
    let mut runner = TestRunner::deterministic();
    let number = if cfg!(debug_assertions) { 800 } else { 8000 };
    let drawn = prop::collection::vec(streams::hard(most), number)
        .new_tree(&mut runner)
        .unwrap()
        .current();
    let mut all: Streams = drawn.into_iter().filter(|s| is_normal(s)).collect();
    for seed in 0..16 {
        for kind in [
            streams::columns_of_smoke,
            streams::voxels,
            streams::hair,
            streams::hair_in_smoke,
            streams::smoke_around_walls,
        ] {
            let mut stream = kind(seed);
            all.push(stream.clone());
            streams::Random::new(seed).shuffle(&mut stream);
            all.push(stream);
        }
    }
    all
}

/// Everything that a curve promises, and that both are within their bounds of
/// each other.
fn agree<const N: usize, L: Lookup>(
    here: &Curve<N, L>,
    there: &Curve<N, L>,
    stream: &[BlockerSegment],
) {
    let ends: Vec<f32> = stream.iter().flat_map(|s| [s.entry(), s.exit()]).collect();
    assert!(there.points().len() <= N);
    for (depth, _) in there.points() {
        assert!(ends.contains(&depth), "a node at {depth}, where nothing is");
    }
    let mut before = 1.0;
    for depth in probes(stream) {
        let (value, bound) = (there.transmittance(depth), there.error_bound(depth));
        assert!((0.0..=before).contains(&value), "{value} behind {before}");
        before = value;
        let error = (f64::from(value) - truth(stream, depth, 0)).abs();
        assert!(
            error <= f64::from(bound),
            "off by {error:e} at {depth:e}, bound {bound:e}, {there:?} of {stream:?}"
        );
        let difference = (value - here.transmittance(depth)).abs();
        assert!(difference <= (bound + here.error_bound(depth)).next_up());
    }
}

fn rule_agrees<A, const N: usize, L: Lookup>(gpu: &Gpu<Queued>, clear: &A, streams: &Streams)
where
    A: WgslRule<Curve = Curve<N, L>> + Clone,
{
    let map = made::<A, Curve<N, L>, 1>(gpu, clear, streams);
    let mut sums = [0.0; 2];
    for (texel, stream) in streams.iter().enumerate() {
        let (here, there) = (accumulated(clear, stream), map.texel(texel, 0));
        agree(&here, &there, stream);
        sums[0] += f64::from(here.max_error_bound());
        sums[1] += f64::from(there.max_error_bound());
    }
    let [here, there] = sums.map(|sum| sum / streams.len() as f64);
    let rule = std::any::type_name::<A>();
    println!("{rule}: mean of the largest bounds {here:.4} here, {there:.4} there");
}

#[test]
fn curves_of_the_papers_rule_agree_within_their_bounds() {
    let Some(gpu) = testing::gpu() else { return };
    let streams = all_kinds(40);
    rule_agrees(&gpu, &Curve::<8, Linear>::new(), &streams);
    rule_agrees(&gpu, &Curve::<8>::new(), &streams);
    rule_agrees(&gpu, &Curve::<4>::new(), &streams);
    rule_agrees(&gpu, &Curve::<2, Linear>::new(), &streams);
}

#[test]
fn curves_with_more_room_agree_within_their_bounds() {
    let Some(gpu) = testing::gpu() else { return };
    let streams = all_kinds(60);
    rule_agrees(&gpu, &Stream::<8>::new(), &streams);
    rule_agrees(&gpu, &Stream::<4, Maximum>::new(), &streams);
    rule_agrees(&gpu, &Stream::<5, Maximum, Linear, 1, 2>::new(), &streams);
    rule_agrees(&gpu, &Stream::<16, Area, Linear, 1, 2>::new(), &streams);
}

#[test]
fn curves_are_as_near_to_the_truth_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    fn compare<A, const N: usize>(gpu: &Gpu<Queued>, clear: &A, streams: &Streams)
    where
        A: WgslRule<Curve = Curve<N>> + Clone,
    {
        let map = made::<A, Curve<N>, 1>(gpu, clear, streams);
        let mut sums = [0.0; 2];
        for (texel, stream) in streams.iter().enumerate() {
            let curves = [accumulated(clear, stream), map.texel(texel, 0)];
            for (sum, curve) in sums.iter_mut().zip(curves) {
                *sum += errors(stream, |depth| curve.transmittance(depth)).0;
            }
        }
        let [here, there] = sums.map(|sum| sum / streams.len() as f64);
        let rule = std::any::type_name::<A>();
        println!("{rule}: mean error {here:.5} on the CPU, {there:.5} on the GPU");
        assert!(there <= 1.1 * here);
    }
    for kind in [
        streams::columns_of_smoke,
        streams::voxels,
        streams::hair,
        streams::hair_in_smoke,
    ] {
        let streams: Streams = (0..32)
            .map(|seed| {
                let mut stream = kind(seed);
                streams::Random::new(seed).shuffle(&mut stream);
                stream
            })
            .collect();
        compare(&gpu, &Curve::<8>::new(), &streams);
        compare(&gpu, &Stream::<8>::new(), &streams);
    }
}

#[test]
fn colours_agree_within_their_bounds() {
    let Some(gpu) = testing::gpu() else { return };
    let mut random = streams::Random::new(11);
    let streams: Streams<3> = (0..100)
        .map(|_| {
            let segment = |_| {
                let entry = 50.0 * random.unit();
                let exit = entry + 10.0 * random.unit() * random.unit();
                let tau = [0.1, 0.02, 0.3].map(|most| most * random.unit());
                BlockerSegment::with_optical_depths(entry, exit, tau).unwrap()
            };
            (0..80).map(segment).collect()
        })
        .collect();
    fn check<A, L: Lookup>(gpu: &Gpu<Queued>, clear: &A, streams: &Streams<3>)
    where
        A: WgslRule<3, Curve = Curve<8, L, 3>> + Clone,
    {
        let map = made::<A, Curve<8, L, 3>, 3>(gpu, clear, streams);
        for (texel, stream) in streams.iter().enumerate() {
            let there = map.texel(texel, 0);
            for depth in probes(stream) {
                let (values, bounds) = (there.transmittances(depth), there.error_bounds(depth));
                for channel in 0..3 {
                    let error = f64::from(values[channel]) - truth(stream, depth, channel);
                    assert!(error.abs() <= f64::from(bounds[channel]));
                }
            }
        }
    }
    check(&gpu, &Curve::<8, Linear, 3>::new(), &streams);
    check(&gpu, &Stream::<8, Area, Exponential, 3, 2>::new(), &streams);
}

#[test]
fn long_lists_are_taken_in_parts_and_short_promises_cost_the_bound() {
    let Some(gpu) = testing::gpu() else { return };
    let mut random = streams::Random::new(5);
    let mut stream = |number| -> Vec<BlockerSegment> {
        let most = 6.0 / number as f32;
        let segment = |_| {
            let entry = 1e3 * random.unit();
            let length = 1e-3 * 1e6_f32.powf(random.unit());
            BlockerSegment::from_optical_depth(entry, entry + length, most * random.unit()).unwrap()
        };
        (0..number).map(segment).collect()
    };
    let streams: Streams = [1, 3000, 0, 100_000, 2999].map(&mut stream).into();
    let map = made::<_, Curve<8>, 1>(&gpu, &Curve::<8>::new(), &streams);
    let linear = made::<_, Curve<8, Linear>, 1>(&gpu, &Curve::<8, Linear>::new(), &streams);
    for (texel, stream) in streams.iter().enumerate() {
        let (curve, linear) = (map.texel(texel, 0), linear.texel(texel, 0));
        for step in 0..60 {
            let depth = 20.0 * step as f32;
            let exact = truth(stream, depth, 0);
            for (value, bound) in [
                (curve.transmittance(depth), curve.error_bound(depth)),
                (linear.transmittance(depth), linear.error_bound(depth)),
            ] {
                assert!((f64::from(value) - exact).abs() <= f64::from(bound));
            }
        }
        let here = accumulated(&Curve::<8>::new(), stream).max_error_bound();
        let there = curve.max_error_bound();
        // Near-ties, and 24 u τ exp(−τ) for each segment's roundings.
        let rounding = 24.0 * 6e-8 * 0.37 * stream.len() as f32;
        assert!(
            there <= 1.25 * here + 0.01 + rounding,
            "{there} instead of {here}"
        );
    }
    // Longer lists than were promised.
    let lists = listed(&gpu, &streams);
    let offsets = gpu.upload(&gpu.download(lists.offsets()).unwrap()).unwrap();
    let numbers = gpu.upload(&gpu.download(lists.numbers()).unwrap()).unwrap();
    let lists = SegmentLists::<_, 1>::from_buffers(lists.extent(), 1000, offsets, numbers).unwrap();
    let mut short = TransmittanceMap::<_, Curve<8>>::new(&gpu, [5, 1]).unwrap();
    gpu.build_map(&Curve::<8>::new(), &lists, &mut short)
        .unwrap();
    let short = short.download(&gpu).unwrap();
    for (texel, stream) in streams.iter().enumerate() {
        let complete = stream.len() <= 1000;
        assert_eq!(short.texel(texel, 0) == map.texel(texel, 0), complete);
        assert_eq!(short.texel(texel, 0).max_error_bound() == 1.0, !complete);
    }
}

#[test]
fn maps_of_more_texels_than_wait_at_once_are_made_in_bands() {
    let Some(gpu) = testing::gpu() else { return };
    let some: Streams = (0..72).map(streams::hair_in_smoke).collect();
    // Few of them have segments, the last among these.
    let mut many = vec![Vec::new(); 70_001];
    for (stream, texel) in some.iter().zip(many.iter_mut().rev().step_by(1000)) {
        texel.clone_from(stream);
    }
    let few = made::<_, Packed<4>, 1>(&gpu, &Stream::<4>::new(), &some);
    let map = made::<_, Packed<4>, 1>(&gpu, &Stream::<4>::new(), &many);
    for texel in 0..many.len() {
        let (number, is_clear) = ((70_000 - texel) / 1000, texel % 1000 != 0);
        if is_clear {
            assert_eq!(map.texel(texel, 0), Packed::clear());
        } else {
            assert_eq!(map.texel(texel, 0), few.texel(number, 0));
        }
    }
}

/// A map with something different in each texel.
fn clouds<P: Stored + From<Curve<8>>>() -> TransmittanceMap<Host, P> {
    let cpu = Cpu::new();
    let source = |tile: &transmittance::Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment)| {
        for y in tile.y.clone() {
            for x in tile.x.clone() {
                let seed = (y * 1000 + x) as u64;
                let stream = if (x + y) % 3 == 0 {
                    streams::hair_in_smoke(seed)
                } else {
                    streams::columns_of_smoke(seed)
                };
                // Some are clear.
                for segment in stream.iter().skip((x % 4) / 3 * 1000) {
                    put([x, y], *segment);
                }
            }
        }
    };
    let mut map = TransmittanceMap::new(&cpu, [23, 11]).unwrap();
    cpu.build_map(&Stream::<8>::new(), &source, &mut map)
        .unwrap();
    map
}

fn receivers() -> Vec<Receiver> {
    let mut random = streams::Random::new(3);
    let mut receivers: Vec<Receiver> = (0..20_000)
        .map(|_| Receiver {
            position: [random.unit() * 29.0 - 3.0, random.unit() * 17.0 - 3.0],
            depth: random.unit() * 330.0 - 20.0,
        })
        .collect();
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        0.5,
        1.0,
        1e-45,
    ];
    for x in odd {
        for depth in odd {
            receivers.push(Receiver {
                position: [x, 3.5],
                depth,
            });
            receivers.push(Receiver {
                position: [4.25, x],
                depth,
            });
        }
    }
    receivers
}

/// What each receiver gets on the GPU from a map that was made on the CPU.
fn asked<P: WgslStored>(
    gpu: &Gpu<Queued>,
    map: &TransmittanceMap<Host, P>,
    receivers: &[Receiver],
    filter: Filter,
) -> Vec<f32> {
    let there = map.upload(gpu).unwrap();
    let receivers = gpu.upload(receivers).unwrap();
    let mut results = gpu.zeros(receivers.len()).unwrap();
    gpu.query_map(&there, &receivers, filter, &mut results)
        .unwrap();
    gpu.download(&results).unwrap()
}

#[test]
fn lookups_agree_within_the_stated_error() {
    let Some(gpu) = testing::gpu() else { return };
    fn check<P: WgslStored + From<Curve<8>>>(gpu: &Gpu<Queued>) {
        let map = clouds::<P>();
        let receivers = receivers();
        for filter in [Filter::Nearest, Filter::Bilinear] {
            let found = asked(gpu, &map, &receivers, filter);
            let mut worst = 0.0_f32;
            for (receiver, found) in receivers.iter().zip(found) {
                let [expected] = map.transmittance(*receiver, filter);
                worst = worst.max((found - expected).abs());
                assert!(
                    (found - expected).abs() <= LOOKUP_ERROR,
                    "{found} for {expected} at {receiver:?}"
                );
            }
            println!("{filter:?}: {worst:e} of {LOOKUP_ERROR:e}");
        }
    }
    check::<Packed<8>>(&gpu);
    check::<Curve<8>>(&gpu);
}

#[test]
fn lookups_of_16_bits_agree_but_for_the_rounding_of_the_depth() {
    let Some(gpu) = testing::gpu() else { return };
    let map = clouds::<PackedHalf<8>>();
    let receivers = receivers();
    let found = asked(&gpu, &map, &receivers, Filter::Nearest);
    for (receiver, found) in receivers.iter().zip(found) {
        // 2⁻²⁰ of a range of 300.
        let at = |step: f32| {
            let depth = receiver.depth + step * 300.0 / 1_048_576.0;
            map.transmittance(Receiver { depth, ..*receiver }, Filter::Nearest)[0]
        };
        let (least, most) = if receiver.depth.is_finite() {
            (at(1.0), at(-1.0))
        } else {
            (at(0.0), at(0.0))
        };
        assert!(
            (least - LOOKUP_ERROR..=most + LOOKUP_ERROR).contains(&found),
            "{found} outside of {least}..{most} at {receiver:?}"
        );
    }
}

#[test]
fn what_the_gpu_stores_is_the_curve_that_it_made() {
    let Some(gpu) = testing::gpu() else { return };
    let streams = all_kinds(30);
    fn check<const N: usize, L: Lookup>(gpu: &Gpu<Queued>, streams: &Streams) {
        let clear = Curve::<N, L>::new();
        let curves = made::<_, Curve<N, L>, 1>(gpu, &clear, streams);
        let packed = made::<_, Packed<N, L>, 1>(gpu, &clear, streams);
        let half = made::<_, PackedHalf<N, L>, 1>(gpu, &clear, streams);
        for (texel, stream) in streams.iter().enumerate() {
            let curve = curves.texel(texel, 0);
            let ends: Vec<f64> = curve.points().map(|point| f64::from(point.0)).collect();
            let length = ends.last().unwrap_or(&0.0) - ends.first().unwrap_or(&0.0);
            for depth in probes(stream) {
                let value = curve.transmittance(depth);
                assert_eq!(packed.texel(texel, 0).evaluate(depth), [value]);
                // As on the CPU, with a unit of f16 instead of half of one.
                let [value] = half.texel(texel, 0).evaluate(depth);
                let delta = length / 4096.0 + f64::from(depth.abs().min(f32::MAX) * 1.2e-7);
                let (front, back) = (f64::from(depth) - delta, f64::from(depth) + delta);
                let least = curve.transmittance((back as f32).next_up());
                let most = curve.transmittance((front as f32).next_down());
                assert!(
                    (least - 5e-4..=most + 5e-4).contains(&value),
                    "{value} outside of {least}..{most} at {depth:e}"
                );
            }
        }
    }
    check::<8, Exponential>(&gpu, &streams);
    check::<5, Linear>(&gpu, &streams);
}

/// Error bound, and depth at a transmittance, of a texel.
const QUESTIONS: &str = "
    struct Question { texel: u32, depth: f32, transmittance: f32 }
    @group(0) @binding(0) var<storage> words: array<u32>;
    @group(0) @binding(1) var<storage> questions: array<Question>;
    @group(0) @binding(2) var<storage, read_write> answers: array<vec2<f32>>;

    fn avsm_word(index: u32) -> u32 { return words[index]; }

    @compute @workgroup_size(64)
    fn answer(
        @builtin(workgroup_id) workgroup: vec3<u32>,
        @builtin(num_workgroups) workgroups: vec3<u32>,
        @builtin(local_invocation_index) local: u32,
    ) {
        let i = gpu_index(workgroup, workgroups, local, 64u);
        if i >= arrayLength(&questions) { return; }
        let q = questions[i];
        answers[i] = vec2(bound(q), avsm_depth_at(q.texel, q.transmittance, 0u));
    }
";

/// The bound, of stored forms that have one.
const BOUND: &str = "
    fn bound(q: Question) -> f32 { return avsm_error_bounds(q.texel, q.depth)[0]; }";

/// What a shader answers to questions: texel, bits of depth and of transmittance.
fn answered<P: WgslStored>(
    gpu: &Gpu<Queued>,
    map: &TransmittanceMap<Host, P>,
    bound: &'static str,
    questions: &[[u32; 3]],
) -> Vec<[f32; 2]> {
    let there = map.upload(gpu).unwrap();
    let buffer = gpu.upload(questions).unwrap();
    let mut answers = gpu.zeros::<[f32; 2]>(questions.len()).unwrap();
    let lookup = lookup_parts::<P, 1>();
    gpu.dispatch(
        &Kernel {
            label: "questions",
            parts: &[&[INDEX_WGSL], &lookup[..], &[QUESTIONS, bound]].concat(),
            entry: "answer",
            constants: &[],
        },
        &[&[
            Argument::read(there.words()),
            Argument::read(&buffer),
            Argument::write(&mut answers),
        ]],
        Workgroups::covering(questions.len(), 64),
    )
    .unwrap();
    gpu.download(&answers).unwrap()
}

fn bounds_and_inverses<const N: usize, L: Lookup>(gpu: &Gpu<Queued>, streams: &Streams) {
    let map = made::<_, Curve<N, L>, 1>(gpu, &Curve::<N, L>::new(), streams);
    let mut questions = Vec::new();
    for (texel, stream) in streams.iter().enumerate() {
        let asked = probes(stream);
        for (i, depth) in asked.iter().enumerate() {
            let transmittance = i as f32 / asked.len() as f32;
            questions.push([texel as u32, depth.to_bits(), transmittance.to_bits()]);
        }
    }
    let answers = answered(gpu, &map, BOUND, &questions);
    let mut excess = 0.0_f32;
    for (question, [bound, at]) in questions.iter().zip(answers) {
        let (depth, transmittance) = (f32::from_bits(question[1]), f32::from_bits(question[2]));
        let stream = &streams[question[0] as usize];
        let curve = map.texel(question[0] as usize, 0);
        let error = f64::from(curve.transmittance(depth)) - truth(stream, depth, 0);
        // With the error of a lookup, which the bound covers.
        assert!(
            error.abs() <= f64::from(bound),
            "off by {error:e}, bound {bound:e} at {depth:e} of {stream:?}"
        );
        let here = curve.error_bound(depth);
        excess = excess.max(bound - here);
        // 2e-6, and what `avsm_lost` is above 1 - exp(-x).
        assert!(bound <= 1.02 * here + 4e-6, "{bound:e} instead of {here:e}");

        let expected = curve.depth_at(transmittance);
        if expected.is_infinite() {
            assert_eq!(at, expected.signum() * f32::MAX);
            continue;
        }
        // The logarithm of shaders is within 2⁻²¹, 4.8e-7.
        let (before, behind) = (at.next_down().next_down(), at.next_up().next_up());
        let slack = 2e-6 + 1e-5 * transmittance;
        let width = 4e-7 * (curve.points().last().unwrap().0 - curve.points().next().unwrap().0);
        assert!(curve.transmittance(before - width) >= transmittance - slack);
        assert!(curve.transmittance(behind + width) <= transmittance + slack);
    }
    println!("bounds are at most {excess:e} above those of the CPU");
}

#[test]
fn error_bounds_and_inverses_in_shaders_are_those_of_the_curve() {
    let Some(gpu) = testing::gpu() else { return };
    let streams = all_kinds(30);
    bounds_and_inverses::<8, Exponential>(&gpu, &streams);
    bounds_and_inverses::<5, Linear>(&gpu, &streams);
}

#[test]
fn inverses_of_packed_curves_are_depths() {
    let Some(gpu) = testing::gpu() else { return };
    fn check<P: WgslStored + From<Curve<8>>>(gpu: &Gpu<Queued>) {
        // Stored forms without bounds.
        const NO_BOUND: &str = "fn bound(q: Question) -> f32 { return 0.0; }";
        let mut streams = vec![Vec::new()];
        streams.extend((0..20).map(streams::columns_of_smoke));
        streams.extend((0..20).map(streams::hair_in_smoke));
        // One that begins in front of the eye, and one far from it.
        for entry in [-3.0, 1e4] {
            streams.push(vec![
                BlockerSegment::from_optical_depth(entry, entry + 7.0, 2.0).unwrap(),
                BlockerSegment::surface(entry + 5.0, 0.25).unwrap(),
            ]);
        }
        // A surface alone: all nodes at one depth.
        streams.push(vec![BlockerSegment::surface(2.5, 0.5).unwrap()]);
        let map = made::<_, P, 1>(gpu, &Curve::<8>::new(), &streams);
        let curves = made::<_, Curve<8>, 1>(gpu, &Curve::<8>::new(), &streams);
        let questions: Vec<[u32; 3]> = (0..streams.len() as u32)
            .flat_map(|texel| (0..=33).map(move |i| [texel, 0, (i as f32 / 32.0).to_bits()]))
            .collect();
        let answers = answered(gpu, &map, NO_BOUND, &questions);
        for (&[texel, _, bits], [_, at]) in questions.iter().zip(answers) {
            let wanted = f32::from_bits(bits);
            let stored = map.texel(texel as usize, 0);
            let value = |depth: f32| stored.evaluate(depth)[0];
            if wanted > 1.0 {
                assert_eq!(at, -f32::MAX);
                continue;
            }
            if value(f32::INFINITY) >= wanted {
                assert_eq!(at, f32::MAX);
                continue;
            }
            let curve = curves.texel(texel as usize, 0);
            let depths: Vec<f32> = curve.points().map(|point| point.0).collect();
            let (first, last) = (depths[0], depths[depths.len() - 1]);
            assert!((first..=last).contains(&at), "{at} of {first}..{last}");
            // Depths of 16 bits may be shifted by 2⁻²⁰ of the range.
            let width = (last - first) / 1_048_576.0;
            let (before, behind) = (at.next_down().next_down(), at.next_up().next_up());
            let slack = 2e-6 + 1e-5 * wanted;
            assert!(value(before - width) >= wanted - slack, "{wanted} at {at}");
            assert!(value(behind + width) <= wanted + slack, "{wanted} at {at}");
        }
    }
    check::<PackedHalf<8>>(&gpu);
    check::<Packed<8>>(&gpu);
}

#[test]
fn curves_that_lack_segments_have_a_bound_of_1_at_all_depths() {
    let Some(gpu) = testing::gpu() else { return };
    fn check<A, L: Lookup>(gpu: &Gpu<Queued>, clear: &A)
    where
        A: WgslRule<Curve = Curve<8, L>>,
    {
        // What is lacking is in front of the first node, or there is no node.
        let surface = |depth| BlockerSegment::surface(depth, 0.1).unwrap();
        let nothing = BlockerSegment::from_optical_depth(5.0, 6.0, 0.0).unwrap();
        let streams: Streams = vec![
            vec![surface(5.0), surface(1.0)],
            vec![nothing, surface(1.0)],
            vec![surface(5.0)],
        ];
        let complete = listed(gpu, &streams);
        let lists = SegmentLists::<_, 1>::from_buffers(
            complete.extent(),
            1,
            gpu.upload(&gpu.download(complete.offsets()).unwrap())
                .unwrap(),
            gpu.upload(&gpu.download(complete.numbers()).unwrap())
                .unwrap(),
        )
        .unwrap();
        let mut map = TransmittanceMap::<_, Curve<8, L>>::new(gpu, [3, 1]).unwrap();
        gpu.build_map(clear, &lists, &mut map).unwrap();
        let map = map.download(gpu).unwrap();
        assert_eq!(
            [0, 1, 2].map(|x| map.texel(x, 0).transmittance(3.0)),
            [1.0; 3]
        );
        let depths = [f32::NEG_INFINITY, 0.0, 3.0, 5.0, 5.5, f32::INFINITY];
        for texel in 0..2 {
            let curve = map.texel(texel, 0);
            assert_eq!(curve.max_error_bound(), 1.0);
            assert_eq!(depths.map(|depth| curve.error_bound(depth)), [1.0; 6]);
            let questions = depths.map(|depth| [texel as u32, depth.to_bits(), 0]);
            for [bound, _] in answered(gpu, &map, BOUND, &questions) {
                assert_eq!(bound, 1.0);
            }
        }
        assert!(map.texel(2, 0).max_error_bound() < 1e-4);
    }
    check(&gpu, &Curve::<8>::new());
    check(&gpu, &Curve::<8, Linear>::new());
    check(&gpu, &Stream::<8>::new());
}

#[test]
fn a_boundless_promise_takes_no_more_dispatches_than_there_are_segments() {
    let Some(gpu) = testing::gpu() else { return };
    let streams: Streams<2> = [0.0, 2.0, 4.0]
        .map(|entry| {
            vec![BlockerSegment::with_optical_depths(entry, entry + 1.0, [0.5, 1.0]).unwrap()]
        })
        .into();
    for streams in [streams, vec![Vec::new()]] {
        let extent = [streams.len(), 1];
        let lists = listed(&gpu, &streams);
        let offsets = gpu.upload(&gpu.download(lists.offsets()).unwrap()).unwrap();
        let numbers = gpu.upload(&gpu.download(lists.numbers()).unwrap()).unwrap();
        let boundless =
            SegmentLists::<_, 2>::from_buffers(extent, u32::MAX, offsets, numbers).unwrap();
        let most = WgslSegments::longest(&boundless);
        assert_eq!(most as usize, streams.concat().len());
        type Colours = Curve<4, Exponential, 2>;
        let mut map = TransmittanceMap::<_, Colours, 2>::new(&gpu, extent).unwrap();
        gpu.build_map(&Colours::new(), &boundless, &mut map)
            .unwrap();
        let map = map.download(&gpu).unwrap();
        let expected = made::<_, Colours, 2>(&gpu, &Colours::new(), &streams);
        for x in 0..streams.len() {
            assert_eq!(map.texel(x, 0), expected.texel(x, 0));
        }
    }
}

/// Segments from a shader: slabs that depend on the texel.
struct Slabs;

const SLABS: &str = "
    override slabs: u32;
    fn avsm_segment_count(texel: vec2<u32>) -> u32 { return texel.x % (slabs + 1u); }
    fn avsm_segment(texel: vec2<u32>, index: u32) -> avsm_Segment {
        var segment: avsm_Segment;
        segment.entry = f32(2u * index + texel.y);
        segment.exit = segment.entry + 1.0;
        segment.optical_depth[0] = 0.125;
        return segment;
    }";

impl WgslSegments for Slabs {
    fn parts() -> &'static [&'static str] {
        &[SLABS]
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        vec![("slabs", 9.0)]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }

    fn longest(&self) -> u32 {
        9
    }
}

#[test]
fn segments_may_come_from_a_shader_and_commands_go_into_an_encoder() {
    let Some(gpu) = testing::gpu() else { return };
    let mut map = TransmittanceMap::<_, Packed<4>>::new(&gpu, [13, 3]).unwrap();
    let context: &Context = gpu.context();
    let device = context.device();
    let mut encoder = device.create_command_encoder(&Default::default());
    Gpu::record(context, &mut encoder)
        .build_map(&Curve::<4>::new(), &Slabs, &mut map)
        .unwrap();
    context.queue().submit([encoder.finish()]);
    let map = map.download(&gpu).unwrap();
    for x in 0..13 {
        for y in 0..3 {
            let [found] = map.texel(x, y).evaluate(100.0);
            let expected = (-0.125 * (x % 10) as f32).exp();
            assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
            assert_eq!(map.texel(x, y).evaluate(y as f32), [1.0]);
        }
    }
}

#[test]
fn hostile_numbers_give_numbers() {
    let Some(gpu) = testing::gpu() else { return };
    let mut random = streams::Random::new(77);
    let odd = [
        f32::NAN,
        f32::INFINITY,
        -1.0,
        0.0,
        -0.0,
        f32::MAX,
        -f32::MAX,
        1e-45,
        1e30,
        3e38,
    ];
    let numbers: Vec<[f32; 3]> = (0..64 * 30)
        .map(|_| {
            [(); 3].map(|()| {
                let choice = (random.unit() * 16.0) as usize;
                odd.get(choice).copied().unwrap_or(10.0 * random.unit())
            })
        })
        .collect();
    let offsets: Vec<u32> = (0..=64)
        .map(|i| if i == 40 { u32::MAX } else { 30 * i })
        .collect();
    let lists = SegmentLists::<GpuMemory>::from_buffers(
        [64, 1],
        30,
        gpu.upload(&offsets).unwrap(),
        gpu.upload(numbers.as_flattened()).unwrap(),
    )
    .unwrap();
    fn check<A, L: Lookup>(
        gpu: &Gpu<Queued>,
        clear: &A,
        lists: &SegmentLists<GpuMemory>,
        numbers: &[[f32; 3]],
    ) where
        A: WgslRule<Curve = Curve<8, L>>,
    {
        let mut map = TransmittanceMap::<_, Curve<8, L>>::new(gpu, [64, 1]).unwrap();
        gpu.build_map(clear, lists, &mut map).unwrap();
        let map = map.download(gpu).unwrap();
        for texel in 0..64 {
            let curve = map.texel(texel, 0);
            // Depths of less than 2⁻¹²⁶ count as 0 there.
            let normal = |x: f32| if x.is_subnormal() { 0.0 } else { x };
            let stream: Vec<BlockerSegment> = numbers[30 * texel..30 * texel + 30]
                .iter()
                .filter_map(|[a, b, tau]| {
                    BlockerSegment::from_optical_depth(normal(*a), normal(*b), *tau).ok()
                })
                .filter(|_| texel != 39 && texel != 40)
                .collect();
            for depth in probes(&stream)
                .into_iter()
                .filter(|depth| !depth.is_subnormal())
            {
                let (value, bound) = (curve.transmittance(depth), curve.error_bound(depth));
                let error = (f64::from(value) - truth(&stream, depth, 0)).abs();
                assert!(
                    error <= f64::from(bound),
                    "{error:e} of {bound:e} at {depth:e}, {curve:?} of {stream:?}"
                );
            }
        }
    }
    check(&gpu, &Curve::<8, Linear>::new(), &lists, &numbers);
    check(&gpu, &Stream::<8>::new(), &lists, &numbers);
}

#[test]
fn maps_without_texels_are_clear_and_wrong_lengths_are_errors() {
    let Some(gpu) = testing::gpu() else { return };
    let none: Streams = Vec::new();
    let map = made::<_, Packed<8>, 1>(&gpu, &Curve::<8>::new(), &none);
    let receivers = [Receiver::default(); 3];
    for filter in [Filter::Nearest, Filter::Bilinear] {
        assert_eq!(asked(&gpu, &map, &receivers, filter), [1.0; 3]);
    }
    let there = map.upload(&gpu).unwrap();
    let receivers = gpu.upload(&receivers).unwrap();
    let mut short = gpu.zeros(2).unwrap();
    let error = gpu.query_map(&there, &receivers, Filter::Nearest, &mut short);
    assert!(error.is_err());
}

/// Captured segments of `texels`, every ninth of none, some of them the same.
fn captured<const C: usize>(texels: usize, segments: usize) -> (Vec<u32>, Vec<f32>) {
    let mut random = streams::Random::new(21);
    let mut numbers = Vec::new();
    let places = (0..segments)
        .map(|i| {
            let entry = (random.unit() * 64.0).floor() - 32.0;
            numbers.extend([entry, entry + (random.unit() * 4.0).floor()]);
            numbers.extend((0..C).map(|_| (random.unit() * 4.0).floor() * 0.125));
            let texel = (random.unit() * texels as f32) as u32;
            if i % 9 == 0 { u32::MAX - texel } else { texel }
        })
        .collect();
    (places, numbers)
}

fn captured_alike<const C: usize>(gpu: &Gpu<Queued>, extent: [usize; 2], segments: usize) {
    let cpu = Cpu::new();
    let (texels, numbers) = captured::<C>(extent[0] * extent[1], segments);
    let there = (gpu.upload(&texels).unwrap(), gpu.upload(&numbers).unwrap());
    for order in [Order::Captured, Order::FrontToBack] {
        let expected: SegmentLists<Host, C> = cpu
            .capture_segments(extent, &texels, &numbers, 9, order)
            .unwrap();
        let found: SegmentLists<GpuMemory, C> = gpu
            .capture_segments(extent, &there.0, &there.1, 9, order)
            .unwrap();
        assert_eq!(&gpu.download(found.offsets()).unwrap(), expected.offsets());
        let numbers = gpu.download(found.numbers()).unwrap();
        assert_eq!(numbers[..expected.numbers().len()], expected.numbers()[..]);
    }
}

#[test]
fn captured_segments_are_sorted_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    captured_alike::<1>(&gpu, [1, 1], 0);
    captured_alike::<1>(&gpu, [5, 0], 20);
    captured_alike::<1>(&gpu, [1, 1], 300);
    captured_alike::<1>(&gpu, [16, 16], 10_000);
    captured_alike::<3>(&gpu, [37, 19], 5000);
    // Two levels of sums, and texels of more than 16 bits.
    captured_alike::<1>(&gpu, [300, 290], 70_000);
    let few = gpu.zeros(3).unwrap();
    let numbers = gpu.zeros(10).unwrap();
    let error: Result<SegmentLists<_, 1>, _> =
        gpu.capture_segments([2, 2], &few, &numbers, 3, Order::Captured);
    assert!(error.is_err());
}

//! Rules of insertion and removal against the CPU and the truth.

use crate::made::{Streams, accumulated, all_kinds, listed, made};
use crate::support::{errors, probes, streams, truth};
use gpu_backend::gpu::{Gpu, Queued};
use gpu_backend::{Backend, Download, testing};
use transmittance::gpu::WgslRule;
use transmittance::{
    Area, BlockerSegment, BuildMap, Curve, Exponential, Linear, Lookup, Maximum, Packed,
    SegmentLists, Stored, Stream, TransmittanceMap,
};

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

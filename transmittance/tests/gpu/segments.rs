//! Segments of every origin: promised, from a shader, hostile, none.

use crate::lookups::asked;
use crate::made::{Streams, listed, made};
use crate::questions::{BOUND, answered};
use crate::support::{probes, streams, truth};
use gpu_backend::gpu::{Argument, Context, Gpu, GpuMemory, InShader, Queued};
use gpu_backend::shader::Part;
use gpu_backend::{Backend, Download, testing};
use transmittance::gpu::{SegmentsSlot, ShaderSegments, WgslRule};
use transmittance::{
    BlockerSegment, BuildMap, Curve, Evaluate, Exponential, Filter, Linear, Lookup, Packed,
    QueryMap, Receiver, SegmentLists, Stream, TransmittanceMap,
};

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
        let most = ShaderSegments::longest(&boundless);
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
    fn test_slabs_segment_count(texel: vec2<u32>) -> u32 { return texel.x % (slabs + 1u); }
    fn test_slabs_segment(texel: vec2<u32>, index: u32) -> avsm_Segment {
        var segment: avsm_Segment;
        segment.entry = f32(2u * index + texel.y);
        segment.exit = segment.entry + 1.0;
        segment.optical_depth[0] = 0.125;
        return segment;
    }";

impl InShader<SegmentsSlot> for Slabs {
    fn part() -> Part {
        Part::new("test_slabs").source(SLABS)
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        vec![("slabs", 9.0)]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

impl ShaderSegments for Slabs {
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
    for filter in [Filter::Nearest, Filter::Bilinear, Filter::Square(3)] {
        assert_eq!(asked(&gpu, &map, &receivers, filter), [1.0; 3]);
    }
    let there = map.upload(&gpu).unwrap();
    let receivers = gpu.upload(&receivers).unwrap();
    let mut short = gpu.zeros(2).unwrap();
    let error = gpu.query_map(&there, &receivers, Filter::Nearest, &mut short);
    assert!(error.is_err());
}

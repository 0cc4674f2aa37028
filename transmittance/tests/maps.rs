//! What must hold for maps and for curves as maps store them.

mod support;

use gpu_backend::{Backend, Cpu};
use proptest::prelude::*;
use support::{probes, streams};
use transmittance::baseline::{Captured, Deep, DeepCurve, Uncompressed};
use transmittance::{
    Accumulate, BlockerSegment, BuildMap, CaptureSegments, Curve, CurveMap, Error, Evaluate,
    Exponential, Filter, Linear, Lists, Lookup, Order, Packed, PackedHalf, QueryMap, Receiver,
    SegmentLists, Sorted, Stored, Stream, Tile, TransmittanceMap,
};

fn papers<L: Lookup>(segments: &[BlockerSegment]) -> Curve<8, L> {
    let mut curve = Curve::new();
    for segment in segments {
        curve.insert(segment);
    }
    curve
}

fn packs_well<L: Lookup>(curve: Curve<8, L>, segments: &[BlockerSegment]) {
    let (packed, half) = (Packed::from(curve), PackedHalf::from(curve));
    let ends: Vec<f64> = curve.points().map(|point| f64::from(point.0)).collect();
    let length = ends.last().unwrap_or(&0.0) - ends.first().unwrap_or(&0.0);
    let mut before = 1.0;
    for depth in probes(segments) {
        assert_eq!(packed.evaluate(depth), [curve.transmittance(depth)]);
        let [value] = half.evaluate(depth);
        assert!(
            value <= before,
            "rises from {before} to {value} at {depth:e}"
        );
        before = value;
        // What the documentation says: 2⁻¹² of the range, an ULP, 2.5e-4.
        let delta = length / 4096.0 + f64::from(depth.abs().min(f32::MAX) * 1.2e-7);
        let (front, back) = (f64::from(depth) - delta, f64::from(depth) + delta);
        let least = curve.transmittance((back as f32).next_up());
        let most = curve.transmittance((front as f32).next_down());
        assert!(
            (least - 2.5e-4..=most + 2.5e-4).contains(&value),
            "{value} outside of {least}..{most} at {depth:e}"
        );
    }
}

proptest! {
    #![proptest_config(reference::property::cases(if cfg!(debug_assertions) { 1_000 } else { 8_000 }))]

    #[test]
    fn packed_curves_are_the_same_or_within_their_error(s in streams::hard(20)) {
        packs_well(papers::<Exponential>(&s), &s);
        packs_well(papers::<Linear>(&s), &s);
    }
}

/// A map of something different in each texel.
fn clouds(tile: &Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment)) {
    for y in tile.y.clone() {
        for x in tile.x.clone() {
            let texel = (y * 1000 + x) as u64;
            for segment in streams::hair(texel) {
                put([x, y], segment);
            }
            // A neighbour's, which the tile does not have to have.
            let leaf = BlockerSegment::surface(50.0, 0.75).expect("a sound surface");
            put([x + 1, y], leaf);
        }
    }
}

/// Of each kind.
const FILTERS: [Filter; 4] = [
    Filter::Nearest,
    Filter::Bilinear,
    Filter::Square(2),
    Filter::Square(7),
];

#[test]
fn maps_do_not_depend_on_threads() -> Result<(), Error> {
    let build =
        |cpu: &Cpu| CurveMap::<Packed<8>>::build(cpu, [37, 53], &Stream::<8>::new(), &clouds);
    let one = build(&Cpu::single_threaded())?;
    assert_eq!(build(&Cpu::new())?, one);
    let receivers: Vec<Receiver> = (0..5000)
        .map(|i| Receiver {
            position: [(i % 91) as f32 * 0.5 - 3.0, (i % 113) as f32 * 0.5 - 1.0],
            depth: (i % 101) as f32,
        })
        .collect();
    for filter in FILTERS {
        let mut many = vec![[0.0]; receivers.len()];
        one.transmittances(&Cpu::new(), &receivers, filter, &mut many)?;
        for (receiver, many) in receivers.iter().zip(many) {
            assert_eq!(one.transmittance(*receiver, filter), many);
        }
    }
    Ok(())
}

#[test]
fn every_texel_has_its_own_curve_in_its_own_place() -> Result<(), Error> {
    // Sizes below, at and above a tile's.
    for extent in [[1, 1], [16, 16], [17, 15], [33, 40], [1, 100]] {
        let [width, height] = extent;
        let walls = |tile: &Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment)| {
            // Not only what the tile needs.
            for y in 0..height {
                for x in 0..width.max(tile.x.end) {
                    let wall = BlockerSegment::opaque((y * width + x) as f32);
                    put([x, y], wall.unwrap());
                }
            }
        };
        let map = CurveMap::<Curve<4>>::build(&Cpu::new(), extent, &Curve::<4>::new(), &walls)?;
        assert_eq!((map.width(), map.height()), (width, height));
        assert_eq!(map.texels().len(), width * height);
        for (index, texel) in map.texels().iter().enumerate() {
            assert_eq!(texel.depth_at(0.5), index as f32);
        }
    }
    Ok(())
}

#[test]
fn lists_are_another_way_to_say_the_same() -> Result<(), Error> {
    let extent = [20, 18];
    let (mut offsets, mut segments) = (vec![0], Vec::new());
    for y in 0..18 {
        for x in 0..20 {
            let tile = Tile {
                x: x..x + 1,
                y: y..y + 1,
            };
            let mut put = |texel: [usize; 2], segment| {
                if texel == [x, y] {
                    segments.push(segment);
                }
            };
            // The neighbour's surface comes before its own hair.
            if x > 0 {
                clouds(
                    &Tile {
                        x: x - 1..x,
                        y: y..y + 1,
                    },
                    &mut put,
                );
            }
            clouds(&tile, &mut put);
            offsets.push(segments.len() as u32);
        }
    }
    let lists = Lists::new(extent, &offsets, &segments)?;
    let all = |tile: &Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment)| {
        let wide = Tile {
            x: tile.x.start.saturating_sub(1)..tile.x.end,
            y: tile.y.clone(),
        };
        clouds(&wide, put);
    };
    let cpu = Cpu::new();
    let from_lists = CurveMap::<DeepCurve>::build(&cpu, extent, &Deep::new(0.01)?, &lists)?;
    let from_closure = CurveMap::<DeepCurve>::build(&cpu, extent, &Deep::new(0.01)?, &all)?;
    assert_eq!(from_lists, from_closure);
    // A map larger than its lists is clear elsewhere.
    let larger = CurveMap::<Uncompressed>::build(&cpu, [40, 40], &Captured::new(), &lists)?;
    assert!(larger.texels()[0].len() > 2);
    assert!(larger.texels()[39 * 40 + 39].is_empty() && larger.texels()[30].is_empty());

    let wrong = Lists::new([20, 19], &offsets, &segments).unwrap_err();
    assert!(matches!(
        wrong,
        Error::LengthMismatch {
            expected: 381,
            actual: 361,
            ..
        }
    ));
    offsets[7] = u32::MAX;
    let wrong = Lists::new(extent, &offsets, &segments).unwrap_err();
    assert!(wrong.to_string().contains("texel 6"), "{wrong}");
    Ok(())
}

#[test]
fn bilinear_filtering_weighs_the_four_around() -> Result<(), Error> {
    // Transmittance x / 4 + y / 8 behind depth 1, which is linear.
    let plane = |tile: &Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment)| {
        for y in tile.y.clone() {
            for x in tile.x.clone() {
                let share = 0.25 * x as f32 + 0.125 * y as f32;
                put([x, y], BlockerSegment::surface(1.0, share).unwrap());
            }
        }
    };
    let map = CurveMap::<Packed<4, Linear>>::build(
        &Cpu::new(),
        [3, 3],
        &Curve::<4, Linear>::new(),
        &plane,
    )?;
    let at = |x: f32, y: f32, filter| {
        let receiver = Receiver {
            position: [x, y],
            depth: 2.0,
        };
        map.transmittance(receiver, filter)[0]
    };
    for (x, y) in [(0.5, 0.5), (1.25, 0.75), (2.5, 2.5), (1.0, 2.0), (2.0, 1.9)] {
        let exact = 0.25 * (x - 0.5) + 0.125 * (y - 0.5);
        // The transmittances go through an optical depth: 4 roundings of 1e-7.
        assert!((at(x, y, Filter::Bilinear) - exact).abs() < 1e-6);
    }
    let corners = [
        (-5.0, -5.0, 0.0, 0.0),
        (9.0, 9.0, 3.0, 3.0),
        (f32::NAN, 1.5, 0.0, 1.5),
    ];
    for (x, y, like_x, like_y) in corners {
        for filter in FILTERS {
            assert_eq!(at(x, y, filter), at(like_x, like_y, filter), "{x} {y}");
        }
    }
    assert_eq!(at(1.9, 0.1, Filter::Nearest), at(1.5, 0.5, Filter::Nearest));
    assert_eq!(
        at(f32::INFINITY, f32::NEG_INFINITY, Filter::Bilinear),
        at(2.5, 0.5, Filter::Nearest)
    );
    Ok(())
}

#[test]
fn a_square_is_the_mean_of_the_bilinear_lookups_in_it() -> Result<(), Error> {
    let extent = [23, 9];
    let map = CurveMap::<Packed<8>>::build(&Cpu::new(), extent, &Stream::<8>::new(), &clouds)?;
    for i in 0..500 {
        // Beside the map, too, and on the borders of texels.
        let position = [(i % 61) as f32 * 0.5 - 3.0, (i % 47) as f32 * 0.31 - 1.0];
        let depth = (i % 101) as f32;
        let at = |position, filter| map.transmittance(Receiver { position, depth }, filter)[0];
        let same = [
            (Filter::Square(0), Filter::Nearest),
            (Filter::Square(1), Filter::Bilinear),
        ];
        for (a, b) in same {
            assert_eq!(at(position, a), at(position, b));
        }
        for side in [2, 3, 8, 40_u8] {
            // The centre counts as in the map, which is what the others are around.
            let [x, y] = [0, 1].map(|axis| position[axis].clamp(0.0, extent[axis] as f32));
            let offset = |i: u8| f32::from(i) - 0.5 * f32::from(side - 1);
            let of_row = |j| (0..side).map(move |i| [x + offset(i), y + offset(j)]);
            let all = (0..side).flat_map(of_row);
            let sum: f64 = all.map(|at_| f64::from(at(at_, Filter::Bilinear))).sum();
            let mean = sum / f64::from(side).powi(2);
            // As many roundings as are documented.
            let error = f64::from(2 * u32::from(side) + 6) * f64::from(f32::EPSILON);
            let found = f64::from(at(position, Filter::Square(side)));
            assert!((found - mean).abs() <= error, "{found} for {mean}, {side}");
        }
    }
    Ok(())
}

#[test]
fn sizes_that_cannot_be_are_errors_and_empty_maps_are_clear() -> Result<(), Error> {
    let nothing = |_: &Tile, _: &mut dyn FnMut([usize; 2], BlockerSegment)| {};
    for extent in [[usize::MAX, 2], [1 << 40, 1 << 20]] {
        let error = CurveMap::<Packed<8>>::build(&Cpu::new(), extent, &Curve::<8>::new(), &nothing);
        assert!(matches!(error.unwrap_err(), Error::TooLarge { .. }));
    }
    let empty = CurveMap::<Packed<8>>::build(&Cpu::new(), [0, 5], &Curve::<8>::new(), &nothing)?;
    for filter in FILTERS {
        assert_eq!(empty.transmittance(Receiver::default(), filter), [1.0]);
    }
    let mismatch = empty.transmittances(&Cpu::new(), &[], Filter::Nearest, &mut [[0.0]]);
    assert!(matches!(
        mismatch,
        Err(Error::LengthMismatch {
            expected: 0,
            actual: 1,
            ..
        })
    ));
    Ok(())
}

#[test]
fn packed_forms_take_the_memory_that_they_say() {
    assert_eq!(size_of::<Packed<8>>(), 64);
    assert_eq!(size_of::<Packed<8, Linear, 3>>(), 128);
    assert_eq!(size_of::<PackedHalf<8>>(), 40);
}

fn in_buffers<P>() -> Result<(), Error>
where
    P: Stored + From<Curve<8>> + PartialEq + std::fmt::Debug,
{
    let cpu = Cpu::new();
    let extent = [37, 53];
    let map = CurveMap::<P>::build(&cpu, extent, &Stream::<8>::new(), &clouds)?;
    let mut words = TransmittanceMap::<_, P>::new(&cpu, extent)?;
    let receivers: Vec<Receiver> = (0..3000)
        .map(|i| Receiver {
            position: [(i % 91) as f32 * 0.5 - 3.0, (i % 113) as f32 * 0.5 - 1.0],
            depth: (i % 101) as f32,
        })
        .collect();
    let mut answers = vec![0.0; receivers.len()];
    cpu.query_map(&words, &receivers, Filter::Bilinear, &mut answers)?;
    assert!(
        answers.iter().all(|answer| *answer == 1.0),
        "a new map is clear"
    );
    cpu.build_map(&Stream::<8>::new(), &clouds, &mut words)?;
    for (index, texel) in map.texels().iter().enumerate() {
        assert_eq!(*texel, words.texel(index % 37, index / 37));
    }
    for filter in FILTERS {
        cpu.query_map(&words, &receivers, filter, &mut answers)?;
        for (receiver, answer) in receivers.iter().zip(&answers) {
            assert_eq!(map.transmittance(*receiver, filter), [*answer]);
        }
    }
    assert!(
        cpu.query_map(&words, &receivers, Filter::Nearest, &mut vec![0.0])
            .is_err()
    );
    Ok(())
}

#[test]
fn maps_in_buffers_are_the_same_maps() -> Result<(), Error> {
    in_buffers::<Curve<8>>()?;
    in_buffers::<Packed<8>>()?;
    in_buffers::<PackedHalf<8>>()
}

#[test]
fn lists_in_buffers_leave_out_what_is_no_segment() -> Result<(), Error> {
    let cpu = Cpu::new();
    let numbers = [
        [1.0, 2.0, 0.5],
        [2.0, 1.0, 0.5],
        [f32::NAN, 1.0, 0.5],
        [1.0, f32::INFINITY, 0.5],
        [1.0, 2.0, -0.5],
        [3.0, 3.0, 0.25],
    ];
    let buffer = cpu.upload(numbers.as_flattened())?;
    // The second list runs backwards, the third beyond the end.
    let lists = SegmentLists::from_buffers([3, 1], 6, vec![0, 6, 5, 9], buffer)?;
    let mut map = TransmittanceMap::<_, Curve<4>>::new(&cpu, [3, 1])?;
    cpu.build_map(&Curve::<4>::new(), &lists, &mut map)?;
    let expected = papers_of_4(&[
        BlockerSegment::from_optical_depth(1.0, 2.0, 0.5)?,
        BlockerSegment::from_optical_depth(3.0, 3.0, 0.25)?,
    ]);
    assert_eq!(map.texel(0, 0), expected);
    assert_eq!(map.texel(1, 0), Curve::new());
    assert_eq!(map.texel(2, 0), Curve::new());

    let short = SegmentLists::<gpu_backend::Host>::from_buffers([3, 1], 6, vec![0; 3], vec![]);
    assert!(short.unwrap_err().to_string().contains("offsets"));
    let broken =
        SegmentLists::<gpu_backend::Host>::from_buffers([1, 1], 6, vec![0; 2], vec![0.0; 4]);
    assert!(broken.unwrap_err().to_string().contains("segments"));
    let huge = TransmittanceMap::<_, Packed<8>>::new(&cpu, [usize::MAX, 2]).unwrap_err();
    assert!(matches!(huge, Error::TooLarge { .. }));
    Ok(())
}

fn papers_of_4(segments: &[BlockerSegment]) -> Curve<4> {
    let mut curve = Curve::new();
    segments.iter().for_each(|segment| curve.insert(segment));
    curve
}

#[test]
fn captured_segments_make_the_curves_of_their_texels() -> Result<(), Error> {
    let cpu = Cpu::new();
    let (width, height) = (7, 5);
    let streams: Vec<Vec<BlockerSegment>> = (0..35).map(streams::hair_in_smoke).collect();
    // One of each texel in turn, and some of no texel.
    let (mut texels, mut numbers) = (Vec::new(), Vec::new());
    for i in 0..streams[0].len() + 1 {
        for (texel, stream) in streams.iter().enumerate() {
            if let Some(segment) = stream.get(i) {
                texels.push(texel as u32);
                numbers.extend([segment.entry(), segment.exit()]);
                numbers.extend(segment.optical_depth());
            }
        }
        texels.push(35 + i as u32);
        numbers.extend([1.0, 2.0, 3.0]);
    }
    let mut map = TransmittanceMap::<_, Curve<8>>::new(&cpu, [width, height])?;
    for order in [Order::Captured, Order::FrontToBack] {
        let lists: SegmentLists<_> =
            cpu.capture_segments([width, height], &texels, &numbers, 200, order)?;
        cpu.build_map(&Stream::<8>::new(), &lists, &mut map)?;
        for (texel, stream) in streams.iter().enumerate() {
            let expected = match order {
                Order::Captured => made(Stream::<8>::new(), stream),
                Order::FrontToBack => made(Sorted::new(Stream::<8>::new()), stream),
            };
            assert_eq!(map.texel(texel % width, texel / width), expected);
        }
    }
    let wrong: Result<SegmentLists<_>, _> =
        cpu.capture_segments([1, 1], &texels, &vec![0.0], 200, Order::Captured);
    assert!(matches!(
        wrong.unwrap_err(),
        Error::LengthMismatch { actual: 1, .. }
    ));
    let large: Result<SegmentLists<_>, _> =
        cpu.capture_segments([1 << 20, 1 << 20], &texels, &numbers, 200, Order::Captured);
    assert!(matches!(large.unwrap_err(), Error::TooLarge { .. }));
    Ok(())
}

fn made<A: Accumulate>(mut accumulator: A, segments: &[BlockerSegment]) -> A::Curve {
    segments
        .iter()
        .for_each(|segment| accumulator.insert(segment));
    accumulator.finish()
}

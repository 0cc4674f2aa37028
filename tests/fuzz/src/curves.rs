//! Blockers in any order, into curves of every kind.

use reference::curves::{Blocker, probes, transmittances};
use transmittance::{
    Accumulate, Area, BlockerSegment, Curve, Evaluate, Exponential, Linear, Lookup, Maximum,
    Metric, Packed, PackedHalf, Sorted, Stream,
};

use super::Bytes;

/// What is asked of a curve besides its values and their bounds.
#[derive(Debug, Clone, Copy)]
enum Question {
    /// Nothing.
    Values,
    /// What is left of it in fewer bits.
    Packed,
    /// Where it reaches a value.
    Inverse,
}

fn stream<const C: usize>(bytes: &mut Bytes<'_>) -> Vec<BlockerSegment<C>> {
    // Each is asked about at its ends and between them: long streams take the most time.
    let most = bytes.one_of(&[8, 12, 16, 48]);
    let (shift, scale) = bytes.one_of(&[
        (0.0, 1.0),
        (0.0, 1.0),
        (0.0, 1.0),
        (1000.0, 1.0),
        (-1e6, 1.0),
        (0.0, 1e-30),
        (0.0, f32::MAX / 256.0),
        (0.0, f32::from_bits(1)),
    ]);
    let mut segments = Vec::new();
    while !bytes.is_empty() && segments.len() < most {
        let kind = bytes.byte();
        let entry = match kind & 3 {
            0 => f32::from(bytes.byte()) - 128.0,
            _ => bytes.between(-128.0, 128.0),
        };
        let length = match kind >> 2 & 3 {
            0 => 0.0,
            1 => f32::from(bytes.byte() & 31),
            2 => bytes.between(0.0, 32.0),
            _ => bytes.magnitude(-20.0, 6.0),
        };
        let tau = match kind >> 4 {
            0 => f32::INFINITY,
            1 => 1e29,
            2..5 => bytes.magnitude(-40.0, 12.0),
            5 => bytes.any(),
            _ => bytes.unit(),
        };
        // Other channels take a share of it, or more.
        let optical_depths = std::array::from_fn(|channel| match channel {
            0 => tau,
            _ => tau * bytes.one_of(&[0.0, 1e-3, 0.5, 1.0, 1e3]),
        });
        let place = |x: f32| x * scale + shift;
        let (entry, exit) = (place(entry), place(entry + length));
        // Numbers that are none are turned away, as they should be.
        let exit = exit.max(entry);
        segments.extend(BlockerSegment::with_optical_depths(
            entry,
            exit,
            optical_depths,
        ));
    }
    segments
}

fn blockers<const C: usize>(segments: &[BlockerSegment<C>], channel: usize) -> Vec<Blocker> {
    let blocker = |segment: &BlockerSegment<C>| Blocker {
        entry: segment.entry(),
        exit: segment.exit(),
        optical_depth: segment.optical_depth()[channel],
    };
    segments.iter().map(blocker).collect()
}

fn by_papers_rule<const N: usize, L: Lookup, const C: usize>(
    segments: &[BlockerSegment<C>],
) -> Curve<N, L, C> {
    let mut curve = Curve::new();
    segments.iter().for_each(|segment| curve.insert(segment));
    curve
}

fn streamed<const N: usize, M: Metric, L: Lookup, const C: usize, const W: usize>(
    segments: &[BlockerSegment<C>],
) -> Curve<N, L, C> {
    let mut stream = Stream::<N, M, L, C, W>::new();
    segments.iter().for_each(|segment| stream.insert(segment));
    stream.finish()
}

/// Within [0, 1], never rising, and no further from the product of all blockers than
/// the curve says, in each channel. Returns the depths that were asked.
fn keeps_its_promises<const N: usize, L: Lookup, const C: usize>(
    curve: &Curve<N, L, C>,
    segments: &[BlockerSegment<C>],
    question: Question,
) -> Vec<f32> {
    assert!(curve.points().len() <= N);
    let largest = curve.max_error_bound();
    assert!((0.0..=1.0).contains(&largest), "a bound of {largest}");
    let depths = probes(blockers(segments, 0));
    for channel in 0..C {
        let truths = transmittances(blockers(segments, channel), &depths);
        let mut before = 1.0;
        for (&depth, truth) in depths.iter().zip(truths) {
            let value = curve.transmittances(depth)[channel];
            let bound = curve.error_bounds(depth)[channel];
            assert!((0.0..=1.0).contains(&value), "{value} at {depth:e}");
            assert!(
                value <= before,
                "rises from {before} to {value} at {depth:e}"
            );
            before = value;
            let error = (f64::from(value) - truth).abs();
            assert!(
                error <= f64::from(bound) && bound <= largest,
                "off by {error:e} at {depth:e}, bound {bound:e} of {largest:e}"
            );
        }
    }
    if matches!(question, Question::Packed) {
        survives_packing(curve, segments, &depths);
    }
    depths
}

/// Packed, it has the same values, and in halves values next to them, which never rise.
fn survives_packing<const N: usize, L: Lookup, const C: usize>(
    curve: &Curve<N, L, C>,
    segments: &[BlockerSegment<C>],
    depths: &[f32],
) {
    let packed = Packed::from(*curve);
    let half = PackedHalf::from(*curve);
    let sums = (0..C).map(|channel| -> f64 {
        let depth = |segment: &BlockerSegment<C>| f64::from(segment.optical_depth()[channel]);
        segments.iter().map(depth).sum()
    });
    let fits_halves = sums.fold(0.0, f64::max) < 65504.0;
    let share = if fits_halves { 65536_f64 } else { 4096.0 }.recip();
    let mut before = [1.0; C];
    for &depth in depths {
        assert_eq!(packed.evaluate(depth), curve.transmittances(depth));
        let values = half.evaluate(depth);
        let falls = |channel: usize| {
            let range = 0.0..=before[channel];
            range.contains(&values[channel])
        };
        assert!((0..C).all(falls), "{before:?} {values:?} at {depth:e}");
        before = values;
        is_near(curve, share, (depth, values));
    }
}

/// What halves of a curve give at a depth is what the curve gives at most `share` of its length
/// away from it.
fn is_near<const N: usize, L: Lookup, const C: usize>(
    curve: &Curve<N, L, C>,
    share: f64,
    (depth, values): (f32, [f32; C]),
) {
    const ROUNDING: f32 = 2.5e-4;
    if !depth.is_finite() {
        return;
    }
    let nodes: Vec<f32> = curve.points().map(|point| point.0).collect();
    let ends = [nodes.first(), nodes.last()].map(|end| f64::from(*end.unwrap_or(&0.0)));
    let step = (ends[1] - ends[0]) * share;
    let near = [f64::from(depth) - step, f64::from(depth) + step];
    let near = [(near[0] as f32).next_down(), (near[1] as f32).next_up()];
    let [most, least] = near.map(|depth| curve.transmittances(depth));
    for channel in 0..C {
        let range = least[channel] - ROUNDING..=most[channel] + ROUNDING;
        let value = values[channel];
        assert!(range.contains(&value), "{value} at {depth:e}, {range:?}");
    }
}

/// The same of one channel, and the inverse.
fn keeps_all_promises<const N: usize, L: Lookup>(
    curve: &Curve<N, L>,
    segments: &[BlockerSegment],
    question: Question,
) {
    let depths = keeps_its_promises(curve, segments, question);
    if !matches!(question, Question::Inverse) {
        return;
    }
    for depth in depths {
        let value = curve.transmittance(depth);
        let reached = curve.depth_at(value);
        assert!(
            curve.transmittance(reached) >= value,
            "{reached:e} is too far"
        );
    }
}

/// By both rules, in colours.
fn of_colours(which: u8, question: Question, bytes: &mut Bytes<'_>) {
    let segments = stream::<3>(bytes);
    match which % 3 {
        0 => keeps_its_promises(
            &by_papers_rule::<6, Exponential, 3>(&segments),
            &segments,
            question,
        ),
        1 => keeps_its_promises(
            &streamed::<8, Area, Linear, 3, 4>(&segments),
            &segments,
            question,
        ),
        _ => keeps_its_promises(
            &streamed::<4, Maximum, Exponential, 3, 4>(&segments),
            &segments,
            question,
        ),
    };
}

/// Every rule of removal and both lookups keep what [a curve](Curve) promises, packed and
/// unpacked, values and inverse; curves of sorted streams do not depend on the order.
///
/// # Panics
/// If not.
pub fn run(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (which, split) = (bytes.byte(), bytes.unit());
    let question = bytes.one_of(&[Question::Values, Question::Packed, Question::Inverse]);
    if which >= 192 {
        return of_colours(which, question, &mut bytes);
    }
    let segments = stream::<1>(&mut bytes);
    match which % 8 {
        0 => keeps_all_promises(
            &by_papers_rule::<8, Linear, 1>(&segments),
            &segments,
            question,
        ),
        1 => keeps_all_promises(
            &by_papers_rule::<4, Exponential, 1>(&segments),
            &segments,
            question,
        ),
        2 => keeps_all_promises(
            &streamed::<8, Area, Exponential, 1, 4>(&segments),
            &segments,
            question,
        ),
        3 => keeps_all_promises(
            &streamed::<4, Maximum, Exponential, 1, 4>(&segments),
            &segments,
            question,
        ),
        4 => keeps_all_promises(
            &streamed::<5, Area, Linear, 1, 3>(&segments),
            &segments,
            question,
        ),
        5 => keeps_all_promises(
            &streamed::<2, Maximum, Linear, 1, 2>(&segments),
            &segments,
            question,
        ),
        6 => {
            let (front, back) = segments.split_at((split * segments.len() as f32) as usize);
            let [front, back] = [front, back].map(by_papers_rule::<8, Exponential, 1>);
            keeps_all_promises(&front.merged(&back), &segments, question);
        }
        _ => {
            let sorted = |segments: &mut dyn Iterator<Item = &BlockerSegment>| {
                let mut sorted = Sorted::new(Stream::<8>::new());
                segments.for_each(|segment| sorted.insert(segment));
                sorted.finish()
            };
            let curve = sorted(&mut segments.iter());
            assert_eq!(curve, sorted(&mut segments.iter().rev()));
            keeps_all_promises(&curve, &segments, question);
        }
    }
}

/// A stream of each kind: smoke, walls, voxels that touch.
pub fn seeds() -> Vec<Vec<u8>> {
    (0..30_u8)
        .map(|seed| {
            let which = if seed < 24 { seed } else { 192 + seed };
            let mut bytes = vec![which, 0, 128, seed * 8, seed << 5, seed / 8 * 32];
            for i in 0..40_u8 {
                let kind = [0xff, 0x65, 0x0a, 0x2e][usize::from((i ^ seed) % 4)];
                bytes.extend([kind, i.wrapping_mul(37) ^ seed, i, 9, seed, 5, i]);
            }
            bytes
        })
        .collect()
}

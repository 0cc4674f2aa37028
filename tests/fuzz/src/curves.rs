//! Blockers in any order, into curves of every kind.

use reference::curves::{Blocker, probes, transmittance};
use transmittance::{
    Accumulate, Area, BlockerSegment, Curve, Exponential, Linear, Lookup, Maximum, Metric, Sorted,
    Stream,
};

use super::Bytes;

/// As many blockers as a stream has: their products in f64 take the most time.
const MOST: usize = 48;

fn stream(bytes: &mut Bytes<'_>) -> Vec<BlockerSegment> {
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
    while !bytes.is_empty() && segments.len() < MOST {
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
        let place = |x: f32| x * scale + shift;
        let (entry, exit) = (place(entry), place(entry + length));
        // Numbers that are none are turned away, as they should be.
        segments.extend(BlockerSegment::from_optical_depth(
            entry,
            exit.max(entry),
            tau,
        ));
    }
    segments
}

fn blockers(segments: &[BlockerSegment]) -> Vec<Blocker> {
    let blocker = |segment: &BlockerSegment| Blocker {
        entry: segment.entry(),
        exit: segment.exit(),
        optical_depth: segment.optical_depth()[0],
    };
    segments.iter().map(blocker).collect()
}

fn by_papers_rule<const N: usize, L: Lookup>(segments: &[BlockerSegment]) -> Curve<N, L> {
    let mut curve = Curve::new();
    segments.iter().for_each(|segment| curve.insert(segment));
    curve
}

fn streamed<const N: usize, M: Metric, L: Lookup, const W: usize>(
    segments: &[BlockerSegment],
) -> Curve<N, L> {
    let mut stream = Stream::<N, M, L, 1, W>::new();
    segments.iter().for_each(|segment| stream.insert(segment));
    stream.finish()
}

/// Within [0, 1], never rising, and no further from the product of all blockers than
/// the curve says.
fn keeps_its_promises<const N: usize, L: Lookup>(curve: &Curve<N, L>, blockers: &[Blocker]) {
    assert!(curve.points().len() <= N);
    let largest = curve.max_error_bound();
    assert!((0.0..=1.0).contains(&largest), "a bound of {largest}");
    let mut before = 1.0;
    for depth in probes(blockers.iter().copied()) {
        let (value, bound) = (curve.transmittance(depth), curve.error_bound(depth));
        assert!((0.0..=1.0).contains(&value), "{value} at {depth:e}");
        assert!(
            value <= before,
            "rises from {before} to {value} at {depth:e}"
        );
        before = value;
        let error = (f64::from(value) - transmittance(blockers.iter().copied(), depth)).abs();
        assert!(
            error <= f64::from(bound) && bound <= largest,
            "off by {error:e} at {depth:e}, bound {bound:e} of {largest:e}"
        );
        let reached = curve.depth_at(value);
        assert!(
            curve.transmittance(reached) >= value,
            "{reached:e} is too far"
        );
    }
}

/// Every rule of removal and both lookups keep what [a curve](Curve) promises; curves
/// of sorted streams do not depend on the order.
///
/// # Panics
/// If not.
pub fn run(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (which, split) = (bytes.byte(), bytes.unit());
    let segments = stream(&mut bytes);
    let blockers = blockers(&segments);
    match which % 8 {
        0 => keeps_its_promises(&by_papers_rule::<8, Linear>(&segments), &blockers),
        1 => keeps_its_promises(&by_papers_rule::<4, Exponential>(&segments), &blockers),
        2 => keeps_its_promises(&streamed::<8, Area, Exponential, 4>(&segments), &blockers),
        3 => keeps_its_promises(
            &streamed::<4, Maximum, Exponential, 4>(&segments),
            &blockers,
        ),
        4 => keeps_its_promises(&streamed::<5, Area, Linear, 3>(&segments), &blockers),
        5 => keeps_its_promises(&streamed::<2, Maximum, Linear, 2>(&segments), &blockers),
        6 => {
            let (front, back) = segments.split_at((split * segments.len() as f32) as usize);
            let [front, back] = [front, back].map(by_papers_rule::<8, Exponential>);
            keeps_its_promises(&front.merged(&back), &blockers);
        }
        _ => {
            let sorted = |segments: &mut dyn Iterator<Item = &BlockerSegment>| {
                let mut sorted = Sorted::new(Stream::<8>::new());
                segments.for_each(|segment| sorted.insert(segment));
                sorted.finish()
            };
            let curve = sorted(&mut segments.iter());
            assert_eq!(curve, sorted(&mut segments.iter().rev()));
            keeps_its_promises(&curve, &blockers);
        }
    }
}

/// A stream of each kind: smoke, walls, voxels that touch.
pub fn seeds() -> Vec<Vec<u8>> {
    (0..24_u8)
        .map(|seed| {
            let mut bytes = vec![seed, 0, 128, seed / 8 * 32];
            for i in 0..40_u8 {
                let kind = [0xff, 0x65, 0x0a, 0x2e][usize::from((i ^ seed) % 4)];
                bytes.extend([kind, i.wrapping_mul(37) ^ seed, i, 9, seed, 5, i]);
            }
            bytes
        })
        .collect()
}

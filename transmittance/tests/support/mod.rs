//! What judges curves: the truth in f64, streams of blockers, and the best
//! subset of nodes that there is.

#![allow(dead_code, reason = "every test file uses a part of it")]

pub(crate) mod optimal;
pub(crate) mod streams;

use transmittance::BlockerSegment;

/// The exact transmittance at `depth`: Beer–Lambert, in f64, blocker by blocker.
pub(crate) fn truth<const C: usize>(
    segments: &[BlockerSegment<C>],
    depth: f32,
    channel: usize,
) -> f64 {
    let z = f64::from(depth);
    let tau: f64 = segments
        .iter()
        .map(|segment| {
            let (a, b) = (f64::from(segment.entry()), f64::from(segment.exit()));
            let tau = f64::from(segment.optical_depth()[channel]);
            if z <= a {
                0.0
            } else if z >= b {
                tau
            } else {
                tau * ((z - a) / (b - a))
            }
        })
        .sum();
    (-tau).exp()
}

/// Depths at which curves of these blockers may go wrong: each end, the floats
/// beside it, and between each two.
pub(crate) fn probes<const C: usize>(segments: &[BlockerSegment<C>]) -> Vec<f32> {
    let mut ends: Vec<f32> = segments
        .iter()
        .flat_map(|segment| [segment.entry(), segment.exit()])
        .collect();
    ends.sort_by(f32::total_cmp);
    ends.dedup();
    let mut probes = vec![f32::NEG_INFINITY, f32::MIN, f32::MAX, f32::INFINITY, 0.0];
    for pair in ends.windows(2) {
        let (a, b) = (f64::from(pair[0]), f64::from(pair[1]));
        for share in [0.1, 0.5, 0.75] {
            probes.push((a + (b - a) * share) as f32);
        }
    }
    for end in ends {
        probes.extend([end.next_down(), end, end.next_up()]);
    }
    probes.sort_by(f32::total_cmp);
    probes
}

/// Mean and largest error over the depths from the first to the last end, by
/// Simpson's rule between the ends.
pub(crate) fn errors(segments: &[BlockerSegment], curve: impl Fn(f32) -> f32) -> (f64, f64) {
    let mut ends: Vec<f32> = segments
        .iter()
        .flat_map(|segment| [segment.entry(), segment.exit()])
        .collect();
    ends.sort_by(f32::total_cmp);
    ends.dedup();
    let error = |depth: f32| (f64::from(curve(depth)) - truth(segments, depth, 0)).abs();
    let (mut area, mut length, mut max) = (0.0, 0.0, 0.0_f64);
    for pair in ends.windows(2) {
        let (a, b) = (f64::from(pair[0]), f64::from(pair[1]));
        let middle = (0.5 * (a + b)) as f32;
        let sample = [pair[0].next_up(), middle, pair[1]].map(error);
        area += (b - a) * (sample[0] + 4.0 * sample[1] + sample[2]) / 6.0;
        length += b - a;
        max = sample.into_iter().fold(max, f64::max);
    }
    (area / length, max)
}

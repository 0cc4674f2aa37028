//! The truth of curves, and streams of blockers.

#![allow(dead_code, reason = "every test file uses a part of it")]

pub(crate) mod streams;

use reference::curves::{self, Blocker};
use transmittance::BlockerSegment;

/// A channel of segments as plain numbers.
pub(crate) fn blockers<const C: usize>(
    segments: &[BlockerSegment<C>],
    channel: usize,
) -> impl Iterator<Item = Blocker> {
    segments.iter().map(move |segment| Blocker {
        entry: segment.entry(),
        exit: segment.exit(),
        optical_depth: segment.optical_depth()[channel],
    })
}

/// The exact transmittance at `depth`.
pub(crate) fn truth<const C: usize>(
    segments: &[BlockerSegment<C>],
    depth: f32,
    channel: usize,
) -> f64 {
    curves::transmittance(blockers(segments, channel), depth)
}

/// Depths at which curves of these segments may go wrong.
pub(crate) fn probes<const C: usize>(segments: &[BlockerSegment<C>]) -> Vec<f32> {
    curves::probes(blockers(segments, 0))
}

/// Mean and largest error over the depths from the first to the last end.
pub(crate) fn errors(segments: &[BlockerSegment], curve: impl Fn(f32) -> f32) -> (f64, f64) {
    curves::errors(&blockers(segments, 0).collect::<Vec<_>>(), curve)
}

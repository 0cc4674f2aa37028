//! Streams on a GPU, and the curves that it makes of them.

use crate::support::streams;
use gpu_backend::Host;
use gpu_backend::gpu::{Gpu, GpuMemory, Queued};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use transmittance::gpu::{WgslRule, WgslStored};
use transmittance::{Accumulate, BlockerSegment, BuildMap, Lists, SegmentLists, TransmittanceMap};

pub(crate) type Streams<const C: usize = 1> = Vec<Vec<BlockerSegment<C>>>;

/// One texel per stream, in a row.
pub(crate) fn listed<const C: usize>(
    gpu: &Gpu<Queued>,
    streams: &Streams<C>,
) -> SegmentLists<GpuMemory, C> {
    let mut offsets = vec![0];
    for stream in streams {
        offsets.push(offsets[offsets.len() - 1] + stream.len() as u32);
    }
    let segments = streams.concat();
    let lists = Lists::new([streams.len(), 1], &offsets, &segments).unwrap();
    lists.upload(gpu).unwrap()
}

/// The curves of streams as the GPU makes them.
pub(crate) fn made<A, P, const C: usize>(
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

pub(crate) fn accumulated<A: Accumulate<C> + Clone, const C: usize>(
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
pub(crate) fn is_normal(stream: &[BlockerSegment]) -> bool {
    let ends = stream.iter().flat_map(|s| [s.entry(), s.exit()]);
    ends.into_iter()
        .all(|depth| depth == 0.0 || depth.is_normal())
}

/// Streams of every kind: hard ones, those like smoke and hair, and in any order.
pub(crate) fn all_kinds(most: usize) -> Streams {
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

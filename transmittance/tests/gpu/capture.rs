//! Segments that come in any order.

use crate::support::streams;
use gpu_backend::gpu::{Gpu, GpuMemory, Queued};
use gpu_backend::{Backend, Cpu, Download, Host, testing};
use transmittance::{CaptureSegments, Order, SegmentLists};

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

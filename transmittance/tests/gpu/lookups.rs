//! Receivers and what is stored, against the CPU.

use crate::made::{Streams, all_kinds, made};
use crate::support::{probes, streams};
use gpu_backend::gpu::{Gpu, Queued};
use gpu_backend::{Backend, Buffer, Cpu, Download, Host, testing};
use transmittance::gpu::{LOOKUP_ERROR, WgslStored};
use transmittance::{
    BlockerSegment, BuildMap, Curve, Evaluate, Exponential, Filter, Linear, Lookup, Packed,
    PackedHalf, QueryMap, Receiver, Stored, Stream, TransmittanceMap,
};

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
pub(crate) fn asked<P: WgslStored>(
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
        for filter in [Filter::Nearest, Filter::Bilinear, Filter::Square(3)] {
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

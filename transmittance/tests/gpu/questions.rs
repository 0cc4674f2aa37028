//! Bounds and inverses that shaders answer.

use crate::made::{Streams, all_kinds, made};
use crate::support::{probes, streams, truth};
use gpu_backend::gpu::{Argument, Gpu, INDEX_WGSL, Kernel, Queued, Workgroups};
use gpu_backend::{Backend, Download, Host, testing};
use transmittance::gpu::{WgslStored, lookup_parts};
use transmittance::{
    BlockerSegment, Curve, Exponential, Linear, Lookup, Packed, PackedHalf, TransmittanceMap,
};

/// Error bound, and depth at a transmittance, of a texel.
const QUESTIONS: &str = "
    struct Question { texel: u32, depth: f32, transmittance: f32 }
    @group(0) @binding(0) var<storage> words: array<u32>;
    @group(0) @binding(1) var<storage> questions: array<Question>;
    @group(0) @binding(2) var<storage, read_write> answers: array<vec2<f32>>;

    fn avsm_word(index: u32) -> u32 { return words[index]; }

    @compute @workgroup_size(64)
    fn answer(
        @builtin(workgroup_id) workgroup: vec3<u32>,
        @builtin(num_workgroups) workgroups: vec3<u32>,
        @builtin(local_invocation_index) local: u32,
    ) {
        let i = gpu_index(workgroup, workgroups, local, 64u);
        if i >= arrayLength(&questions) { return; }
        let q = questions[i];
        answers[i] = vec2(bound(q), avsm_depth_at(q.texel, q.transmittance, 0u));
    }
";

/// The bound, of stored forms that have one.
pub(crate) const BOUND: &str = "
    fn bound(q: Question) -> f32 { return avsm_error_bounds(q.texel, q.depth)[0]; }";

/// What a shader answers to questions: texel, bits of depth and of transmittance.
pub(crate) fn answered<P: WgslStored>(
    gpu: &Gpu<Queued>,
    map: &TransmittanceMap<Host, P>,
    bound: &'static str,
    questions: &[[u32; 3]],
) -> Vec<[f32; 2]> {
    let there = map.upload(gpu).unwrap();
    let buffer = gpu.upload(questions).unwrap();
    let mut answers = gpu.zeros::<[f32; 2]>(questions.len()).unwrap();
    let lookup = lookup_parts::<P, 1>();
    gpu.dispatch(
        &Kernel {
            label: "questions",
            parts: &[&[INDEX_WGSL], &lookup[..], &[QUESTIONS, bound]].concat(),
            entry: "answer",
            constants: &[],
        },
        &[&[
            Argument::read(there.words()),
            Argument::read(&buffer),
            Argument::write(&mut answers),
        ]],
        Workgroups::covering(questions.len(), 64),
    )
    .unwrap();
    gpu.download(&answers).unwrap()
}

fn bounds_and_inverses<const N: usize, L: Lookup>(gpu: &Gpu<Queued>, streams: &Streams) {
    let map = made::<_, Curve<N, L>, 1>(gpu, &Curve::<N, L>::new(), streams);
    let mut questions = Vec::new();
    for (texel, stream) in streams.iter().enumerate() {
        let asked = probes(stream);
        for (i, depth) in asked.iter().enumerate() {
            let transmittance = i as f32 / asked.len() as f32;
            questions.push([texel as u32, depth.to_bits(), transmittance.to_bits()]);
        }
    }
    let answers = answered(gpu, &map, BOUND, &questions);
    let mut excess = 0.0_f32;
    for (question, [bound, at]) in questions.iter().zip(answers) {
        let (depth, transmittance) = (f32::from_bits(question[1]), f32::from_bits(question[2]));
        let stream = &streams[question[0] as usize];
        let curve = map.texel(question[0] as usize, 0);
        let error = f64::from(curve.transmittance(depth)) - truth(stream, depth, 0);
        // With the error of a lookup, which the bound covers.
        assert!(
            error.abs() <= f64::from(bound),
            "off by {error:e}, bound {bound:e} at {depth:e} of {stream:?}"
        );
        let here = curve.error_bound(depth);
        excess = excess.max(bound - here);
        // 2e-6, and what `avsm_lost` is above 1 - exp(-x).
        assert!(bound <= 1.02 * here + 4e-6, "{bound:e} instead of {here:e}");

        let expected = curve.depth_at(transmittance);
        if expected.is_infinite() {
            assert_eq!(at, expected.signum() * f32::MAX);
            continue;
        }
        // The logarithm of shaders is within 2⁻²¹, 4.8e-7.
        let (before, behind) = (at.next_down().next_down(), at.next_up().next_up());
        let slack = 2e-6 + 1e-5 * transmittance;
        let width = 4e-7 * (curve.points().last().unwrap().0 - curve.points().next().unwrap().0);
        assert!(curve.transmittance(before - width) >= transmittance - slack);
        assert!(curve.transmittance(behind + width) <= transmittance + slack);
    }
    println!("bounds are at most {excess:e} above those of the CPU");
}

#[test]
fn error_bounds_and_inverses_in_shaders_are_those_of_the_curve() {
    let Some(gpu) = testing::gpu() else { return };
    let streams = all_kinds(30);
    bounds_and_inverses::<8, Exponential>(&gpu, &streams);
    bounds_and_inverses::<5, Linear>(&gpu, &streams);
}

#[test]
fn inverses_of_packed_curves_are_depths() {
    let Some(gpu) = testing::gpu() else { return };
    fn check<P: WgslStored + From<Curve<8>>>(gpu: &Gpu<Queued>) {
        // Stored forms without bounds.
        const NO_BOUND: &str = "fn bound(q: Question) -> f32 { return 0.0; }";
        let mut streams = vec![Vec::new()];
        streams.extend((0..20).map(streams::columns_of_smoke));
        streams.extend((0..20).map(streams::hair_in_smoke));
        // One that begins in front of the eye, and one far from it.
        for entry in [-3.0, 1e4] {
            streams.push(vec![
                BlockerSegment::from_optical_depth(entry, entry + 7.0, 2.0).unwrap(),
                BlockerSegment::surface(entry + 5.0, 0.25).unwrap(),
            ]);
        }
        // A surface alone: all nodes at one depth.
        streams.push(vec![BlockerSegment::surface(2.5, 0.5).unwrap()]);
        let map = made::<_, P, 1>(gpu, &Curve::<8>::new(), &streams);
        let curves = made::<_, Curve<8>, 1>(gpu, &Curve::<8>::new(), &streams);
        let questions: Vec<[u32; 3]> = (0..streams.len() as u32)
            .flat_map(|texel| (0..=33).map(move |i| [texel, 0, (i as f32 / 32.0).to_bits()]))
            .collect();
        let answers = answered(gpu, &map, NO_BOUND, &questions);
        for (&[texel, _, bits], [_, at]) in questions.iter().zip(answers) {
            let wanted = f32::from_bits(bits);
            let stored = map.texel(texel as usize, 0);
            let value = |depth: f32| stored.evaluate(depth)[0];
            if wanted > 1.0 {
                assert_eq!(at, -f32::MAX);
                continue;
            }
            if value(f32::INFINITY) >= wanted {
                assert_eq!(at, f32::MAX);
                continue;
            }
            let curve = curves.texel(texel as usize, 0);
            let depths: Vec<f32> = curve.points().map(|point| point.0).collect();
            let (first, last) = (depths[0], depths[depths.len() - 1]);
            assert!((first..=last).contains(&at), "{at} of {first}..{last}");
            // Depths of 16 bits may be shifted by 2⁻²⁰ of the range.
            let width = (last - first) / 1_048_576.0;
            let (before, behind) = (at.next_down().next_down(), at.next_up().next_up());
            let slack = 2e-6 + 1e-5 * wanted;
            assert!(value(before - width) >= wanted - slack, "{wanted} at {at}");
            assert!(value(behind + width) <= wanted + slack, "{wanted} at {at}");
        }
    }
    check::<PackedHalf<8>>(&gpu);
    check::<Packed<8>>(&gpu);
}

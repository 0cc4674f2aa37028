//! Nodes for an integrand of another shader's.

use gpu_backend::gpu::{Argument, INDEX_WGSL, InShader, Kernel, Workgroups};
use gpu_backend::shader::Assembly;
use gpu_backend::{Backend, Download, testing};
use reference::tolerances::Allowed;

use super::agreement::batches;
use crate::gpu::{EvaluatorSlot, SEGMENT};
use crate::quadrature::profile;
use crate::{Emission, Exact, PhaseFunction, Quadrature, Segment};

/// `4π` times the airlight of isotropic scattering, from the distances alone;
/// −1 if a node is not on the segment.
const ENTRY: &str = "
    struct Batch { sigma_t: f32, segments: u32 }
    @group(0) @binding(0) var<uniform> batch: Batch;
    @group(0) @binding(1) var<storage> segments: array<air_Segment>;
    @group(0) @binding(2) var<storage, read_write> sums: array<f32>;

    @compute @workgroup_size(64)
    fn integrate(
        @builtin(workgroup_id) workgroup: vec3<u32>,
        @builtin(num_workgroups) workgroups: vec3<u32>,
        @builtin(local_invocation_index) local: u32,
    ) {
        let i = gpu_index(workgroup, workgroups, local, 64u);
        if i >= batch.segments { return; }
        let segment = segments[i];
        var sum = 0.0;
        var nodes = air_nodes(batch.sigma_t, segment);
        loop {
            let node = air_next_node(&nodes);
            if node.done { break; }
            if node.distance < 0.0 || node.distance > segment.length {
                sum = -1.0;
                break;
            }
            let d = air_distance(segment.s + node.distance, segment.h);
            let depth = batch.sigma_t * (segment.x + node.distance + d);
            sum += air_exp2_times(node.weight, -air_LOG2_E * depth, 0);
        }
        sums[i] = sum;
    }";

#[test]
fn nodes_lie_on_the_segment_and_know_the_inverse_square() {
    let Some(gpu) = testing::gpu() else { return };
    let quadrature = Quadrature::fixed(PhaseFunction::Isotropic, 10).unwrap();
    let exact = Exact::new(PhaseFunction::Isotropic).unwrap();
    let mut compared = 0;
    for (sigma_t, segments) in batches(3000) {
        // Distances that may be added up in single precision.
        let segments: Vec<Segment> = segments.into_iter().filter(|s| s.length < 1e9).collect();
        let buffer = gpu.upload(&segments).unwrap();
        let mut sums = gpu.zeros::<f32>(segments.len()).unwrap();
        let mut shader = Assembly::new(&[INDEX_WGSL, SEGMENT, ENTRY]);
        shader
            .fill::<EvaluatorSlot>(&Quadrature::<PhaseFunction>::part())
            .unwrap();
        let parts = shader.finish(1);
        gpu.dispatch(
            &Kernel {
                label: "integrate",
                parts: &parts,
                entry: "integrate",
                constants: &[],
            },
            &[
                &[
                    Argument::uniform([sigma_t, f32::from_bits(segments.len() as u32)]),
                    Argument::read(&buffer),
                    Argument::write(&mut sums),
                ],
                &quadrature.arguments(),
            ],
            Workgroups::covering(segments.len(), 64),
        )
        .unwrap();
        for (segment, sum) in segments.iter().zip(gpu.download(&sums).unwrap()) {
            assert!(sum >= 0.0, "{segment:?}");
            let truth =
                4.0 * std::f64::consts::PI * exact.airlight(sigma_t.into(), &(*segment).into());
            // Nodes of less than 2^-126 count as 0; there are up to a hundred.
            if !(truth > 1e-28 && truth < 1e38) {
                continue;
            }
            // The way to where the light has faded.
            let reach = f64::from(segment.x + segment.s.abs() + segment.h);
            let depth = f64::from(sigma_t) * reach + 20.0;
            let allowed = Allowed::GpuAirlight.error() + depth * Allowed::GpuNodesDepth.error();
            let error = (f64::from(sum) / truth - 1.0).abs();
            assert!(error <= allowed, "{sigma_t} {segment:?}: {sum} for {truth}");
            compared += 1;
        }
    }
    assert!(compared > 1500, "{compared}");
}

/// `4π` times the airlight of isotropic scattering in light that fades towards a
/// range behind the end of the segment, with the nodes of a cosine and a spot on
/// top, which must change nothing.
const FADING: &str = "
    struct Batch { sigma_t: f32, segments: u32, extra: u32, padding: u32 }
    @group(0) @binding(0) var<uniform> batch: Batch;
    @group(0) @binding(1) var<storage> segments: array<air_Segment>;
    @group(0) @binding(2) var<storage> ranges: array<f32>;
    @group(0) @binding(3) var<storage, read_write> sums: array<f32>;

    @compute @workgroup_size(64)
    fn integrate(
        @builtin(workgroup_id) workgroup: vec3<u32>,
        @builtin(num_workgroups) workgroups: vec3<u32>,
        @builtin(local_invocation_index) local: u32,
    ) {
        let i = gpu_index(workgroup, workgroups, local, 64u);
        if i >= batch.segments { return; }
        let segment = segments[i];
        let pattern = air_Pattern(batch.extra + air_EXTRA_FADING, air_DEEPER, ranges[i]);
        var sum = 0.0;
        var nodes = air_pattern_nodes(batch.sigma_t, segment, pattern);
        loop {
            let node = air_next_node(&nodes);
            if node.done { break; }
            let d = air_distance(segment.s + node.distance, segment.h);
            let square = (d / ranges[i]) * (d / ranges[i]);
            let fading = (1.0 - square) * (1.0 + square);
            let depth = batch.sigma_t * (segment.x + node.distance + d);
            sum += air_exp2_times(node.weight * fading, -air_LOG2_E * depth, 0);
        }
        sums[i] = sum;
    }";

#[test]
fn light_that_fades_towards_its_range_has_its_nodes() {
    let Some(gpu) = testing::gpu() else { return };
    let phase = PhaseFunction::Isotropic;
    let exact = Exact::new(phase).unwrap();
    let tolerance = 1e-4;
    let quadrature = Quadrature::with_tolerance(phase, tolerance).unwrap();
    let mut compared = 0;
    for (sigma_t, segments) in batches(3000) {
        let segments: Vec<Segment> = segments.into_iter().filter(|s| s.length < 1e9).collect();
        // Next to the farther end, where all of it fades, and farther out.
        let ranges: Vec<f32> = segments
            .iter()
            .enumerate()
            .map(|(i, Segment { s, h, length, .. })| {
                [1.1, 3.0, 100.0][i % 3] * h.hypot(s.abs().max((s + length).abs()))
            })
            .collect();
        for extra in [0, profile::SPOT as u32] {
            let buffer = gpu.upload(&segments).unwrap();
            let range_buffer = gpu.upload(&ranges).unwrap();
            let mut sums = gpu.zeros::<f32>(segments.len()).unwrap();
            let mut shader = Assembly::new(&[INDEX_WGSL, SEGMENT, FADING]);
            shader
                .fill::<EvaluatorSlot>(&Quadrature::<PhaseFunction>::part())
                .unwrap();
            let parts = shader.finish(1);
            let count = segments.len() as u32;
            gpu.dispatch(
                &Kernel {
                    label: "integrate",
                    parts: &parts,
                    entry: "integrate",
                    constants: &[],
                },
                &[
                    &[
                        Argument::uniform([sigma_t.to_bits(), count, extra, 0]),
                        Argument::read(&buffer),
                        Argument::read(&range_buffer),
                        Argument::write(&mut sums),
                    ],
                    &quadrature.arguments(),
                ],
                Workgroups::covering(segments.len(), 64),
            )
            .unwrap();
            for ((segment, range), sum) in segments
                .iter()
                .zip(&ranges)
                .zip(gpu.download(&sums).unwrap())
            {
                let light = Emission::isotropic()
                    .fading_within(f64::from(*range))
                    .unwrap();
                let value = exact
                    .estimate_of(sigma_t.into(), &(*segment).into(), &light)
                    .value;
                let truth = 4.0 * std::f64::consts::PI * value;
                if !(truth > 1e-28 && truth < 1e38) {
                    continue;
                }
                // As above; the fading has the digits of 1 − (d/range)², which
                // is at least 0.17, so that 12 roundings count six times.
                let reach = f64::from(segment.x + segment.s.abs() + segment.h);
                let depth = f64::from(sigma_t) * reach + 20.0;
                let rounding = (300.0 + 72.0 + 16.0 * depth) / f64::from(1 << 24);
                let error = (f64::from(sum) / truth - 1.0).abs();
                assert!(
                    error <= rounding + f64::from(tolerance),
                    "{sigma_t} {segment:?} {range}: {sum} for {truth}"
                );
                compared += 1;
            }
        }
    }
    assert!(compared > 3000, "{compared}");
}

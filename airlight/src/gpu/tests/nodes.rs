//! Nodes for an integrand of another shader's.

use gpu_backend::gpu::{Argument, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Backend, Download, testing};
use reference::tolerances::Allowed;

use super::agreement::batches;
use crate::gpu::{SEGMENT, WgslEvaluator};
use crate::{Exact, PhaseFunction, Quadrature, Segment};

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
        let parts = [
            &[INDEX_WGSL, SEGMENT],
            Quadrature::<PhaseFunction>::parts(),
            &[ENTRY],
        ]
        .concat();
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

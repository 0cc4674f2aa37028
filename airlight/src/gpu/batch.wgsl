// Entry point: one segment per invocation.

struct Batch {
    sigma_t: f32,
    segments: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<storage> segments: array<air_Segment>;
@group(0) @binding(2) var<storage, read_write> airlight: array<f32>;

@compute @workgroup_size(64)
fn evaluate(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < batch.segments {
        airlight[i] = air_airlight(batch.sigma_t, segments[i]);
    }
}

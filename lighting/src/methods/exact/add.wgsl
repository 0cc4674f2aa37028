// Adds light that the CPU has computed to the radiance of rays: entry point. One invocation
// per ray.

@group(0) @binding(0) var<uniform> rays: u32;
@group(0) @binding(1) var<storage> light: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> radiance: array<vec4<f32>>;

@compute @workgroup_size(64)
fn add_light(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < rays {
        radiance[i] = vec4(radiance[i].xyz + light[i].xyz, radiance[i].w);
    }
}

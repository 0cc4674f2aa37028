// The direct light of many lights on surfaces, with shadows from their voxels: entry point.
// One invocation per point goes through the lights.
//
// Needs the part block.wgsl.

@group(0) @binding(5) var<storage> points: array<light_SurfacePoint>;
@group(0) @binding(6) var<storage, read_write> radiance: array<vec4<f32>>;

// The visibility of the current light from a point, by its voxels. A volume that is all lit
// or all dark for rays says nothing about surfaces, which then count as lit.
fn visibility(point: vec3<f32>) -> f32 {
    let voxels = light_voxels();
    if voxels.state <= light_ALL_DARK {
        return 1.0;
    }
    return vsv_visibility(voxels.lattice, voxels.sampling, point);
}

@compute @workgroup_size(64)
fn light_surfaces(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= block.count {
        return;
    }
    let point = points[i];
    if !any(point.response > vec3(0.0)) {
        return;
    }
    var sum = vec3(0.0);
    for (var light = 0u; light < block.lights; light += 1u) {
        current = light;
        let arrives = light_arriving(point.position, point.normal);
        if any(arrives > vec3(0.0)) {
            sum += arrives * visibility(point.position);
        }
    }
    radiance[i] = vec4(radiance[i].xyz + point.response * sum, radiance[i].w);
}

// The light of the environment on surfaces: entry point. One invocation per surface.

@group(0) @binding(1) var<storage> points: array<light_SurfacePoint>;
// For each patch of the environment ∫ ω dω and how far it reaches, its radiance, and its
// halo on all levels.
@group(0) @binding(2) var<storage> patches: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4<f32>>;

@compute @workgroup_size(64)
fn add_environment_light(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= scene.count {
        return;
    }
    let point = points[i];
    if !(any(point.response > vec3(0.0)) && point.openness > 0.0) {
        return;
    }
    let stride = 2u + scene.levels;
    let count = arrayLength(&patches) / stride;
    var sum = vec3(0.0);
    for (var k = 0u; k < count; k++) {
        let first = k * stride;
        let weighted = patches[first].xyz;
        // A patch that the horizon cuts counts as if n·ω were spread evenly over it.
        let reach = patches[first].w;
        var cos = dot(point.normal, weighted);
        if cos < reach {
            let above = max(cos + reach, 0.0);
            cos = above * above / (4.0 * reach);
        }
        if cos <= 0.0 {
            continue;
        }
        let way = way_through(point.position, normalize(weighted));
        let level = level_of(way);
        let low = patches[first + 2u + u32(level.x)].xyz;
        let high = patches[first + 2u + u32(level.y)].xyz;
        sum += cos * through(way, patches[first + 1u].xyz, mix(low, high, level.z));
    }
    let light = point.response * point.openness * sum;
    radiance[i] = vec4(radiance[i].xyz + light, radiance[i].w);
}

// The direct light of many lights on surfaces: entry point. One invocation per point goes
// through the lights of its list.
//
// Needs the parts ARRIVING, SURFACE_POINT and lights.wgsl.

struct Scene {
    medium: light_Medium,
    points: u32,
    lists: u32,
    // The entries of each list that this dispatch adds: the first, and how many at most.
    entry: u32,
    most: u32,
    // Where the texels of cookies begin in the table.
    cookies: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var<storage> points: array<light_SurfacePoint>;
// The lights, MANY_LIGHT entries each; then the texels of their cookies.
@group(0) @binding(2) var<storage> table: array<vec4<u32>>;
// First the number of each point's list; then where each list begins, and where the last one
// ends; then the lists.
@group(0) @binding(3) var<storage> lists: array<u32>;
@group(0) @binding(4) var<storage, read_write> radiance: array<vec4<f32>>;

@compute @workgroup_size(64)
fn add_direct_light(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= scene.points {
        return;
    }
    let point = points[i];
    if !any(point.response > vec3(0.0)) {
        return;
    }
    let list = scene.points + lists[i];
    let lights = scene.points + scene.lists + 1u;
    let begin = lists[list];
    let count = lists[list + 1u] - begin;
    let entry = min(scene.entry, count);
    let end = entry + min(scene.most, count - entry);
    var sum = radiance[i].xyz;
    for (var e = entry; e < end; e++) {
        many_number = lists[lights + begin + e];
        many_light = many_light_at(many_number);
        let arrives = light_arriving(point.position, point.normal);
        if any(arrives > vec3(0.0)) {
            sum += point.response * (arrives * light_surface_visibility(point.position, point.normal));
        }
    }
    radiance[i] = vec4(sum, radiance[i].w);
}

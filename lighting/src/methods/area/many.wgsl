// The airlight of a bundle of rays due to a block of lights: entry point. One
// invocation per ray goes through the lights.
//
// Needs the part block.wgsl.

@group(0) @binding(5) var<storage> rays: array<light_Ray>;
@group(0) @binding(6) var<storage, read_write> radiance: array<vec4<f32>>;

@compute @workgroup_size(64)
fn gather_many(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let number = gpu_index(workgroup, workgroups, local, 64u);
    if number >= block.count {
        return;
    }
    let i = block.first + number;
    var sum = vec3(0.0);
    for (var light = 0u; light < block.lights; light += 1u) {
        current = light;
        let unmoved = light_path(rays[i], i);
        if !(unmoved.start < unmoved.end) {
            continue;
        }
        let path = light_off_the_light(unmoved);
        var cursor = light_cursor(path);
        loop {
            let part = light_next_lit(&cursor, path);
            if light_is_dark(part) {
                break;
            }
            sum += part.visibility * light_airlight(path, part.start, part.end);
        }
    }
    radiance[i] = vec4(radiance[i].xyz + block.weight * sum, radiance[i].w);
}

// The airlight of a bundle of rays: entry point. One invocation per ray.

struct Scene {
    emitter: light_Emitter,
    medium: light_Medium,
    rays: u32,
    // Number of the first ray in its frame.
    first: u32,
    // Whether lit parts that touch are joined before they are evaluated.
    joined: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var<storage> rays: array<light_Ray>;
@group(0) @binding(2) var<storage> cookie: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4<f32>>;

fn light_emitter() -> light_Emitter {
    return scene.emitter;
}

fn light_medium() -> light_Medium {
    return scene.medium;
}

fn light_cookie(index: u32) -> vec3<f32> {
    return cookie[index].xyz;
}

@compute @workgroup_size(64)
fn gather(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= scene.rays {
        return;
    }
    let unmoved = light_path(rays[i], scene.first + i);
    if !(unmoved.start < unmoved.end) {
        return;
    }
    let sum = light_lit_airlight(light_off_the_light(unmoved), scene.joined != 0u);
    radiance[i] = vec4(radiance[i].xyz + sum, radiance[i].w);
}

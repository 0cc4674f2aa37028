// Light that reaches surfaces by way of the fog: entry point. One invocation per
// surface.

struct Scene {
    emitter: light_Emitter,
    medium: light_Medium,
    points: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var<storage> points: array<light_SurfacePoint>;
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
fn add_surface_scattering(
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
    let irradiance = light_scattered_irradiance(point.position, point.normal);
    radiance[i] = vec4(radiance[i].xyz + point.response * irradiance, radiance[i].w);
}

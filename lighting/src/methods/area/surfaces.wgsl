// The light of many lights on surfaces, with shadows from their voxels: entry point.
// One invocation per point goes through the lights.
//
// Needs the part block.wgsl.

@group(0) @binding(5) var<storage> points: array<light_SurfacePoint>;
@group(0) @binding(6) var<storage, read_write> radiance: array<vec4<f32>>;

// The irradiance at a point by the current light, without shadow.
fn arriving(point: light_SurfacePoint) -> vec3<f32> {
    let emitter = light_emitter();
    let medium = light_medium();
    var to_light = -emitter.position;
    var irradiance = emitter.intensity;
    var way = 0.0;
    if emitter.kind == light_DIRECTIONAL {
        // Sunlight in a medium without bounds was attenuated before.
        if medium.bounded != 0u {
            way = light_length_inside(point.position, to_light, light_FAR);
        }
    } else {
        let offset = emitter.position - point.position;
        let distance = length(offset);
        if !(distance > 0.0 && distance <= emitter.range) {
            return vec3(0.0);
        }
        to_light = offset / distance;
        irradiance *= light_factor(emitter, -to_light) * light_window_at(emitter, distance);
        irradiance /= distance * distance;
        way = light_length_inside(point.position, to_light, distance);
    }
    return irradiance * max(dot(point.normal, to_light), 0.0) * exp(-medium.sigma_t * way);
}

// What the voxels of the current light say of a point.
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
        let arrives = arriving(point);
        if any(arrives > vec3(0.0)) {
            sum += arrives * visibility(point.position);
        }
    }
    radiance[i] = vec4(radiance[i].xyz + point.response * sum, radiance[i].w);
}

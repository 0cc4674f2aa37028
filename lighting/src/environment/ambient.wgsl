// Even light from all around that fog scatters into the eye: entry point. One
// invocation per ray. The shader's side of `Ambient`.

struct Ambient {
    medium: light_Medium,
    radiance: vec3<f32>,
    // The number of rays.
    count: u32,
    // 1 if rays to the sky get it, too.
    before_sky: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(0) var<uniform> ambient: Ambient;
@group(0) @binding(1) var<storage> rays: array<light_Ray>;
@group(0) @binding(2) var<storage, read_write> radiance: array<vec4<f32>>;

fn light_medium() -> light_Medium {
    return ambient.medium;
}

// The part PATH needs a light; none is asked about here.
fn light_emitter() -> light_Emitter {
    return light_Emitter();
}

fn light_cookie(index: u32) -> vec3<f32> {
    return vec3(0.0);
}

// (1 − e^{−σ_t D}) σ_s/σ_t for the way D, m. Beyond a hundred mean free paths it no longer
// grows.
fn scattered(sigma_s: f32, sigma_t: f32, way: f32) -> f32 {
    if sigma_s == 0.0 || way <= 0.0 {
        return 0.0;
    }
    if way >= 100.0 / sigma_t {
        return sigma_s / sigma_t;
    }
    return sigma_s * way * light_mean_exponential(sigma_t * way);
}

@compute @workgroup_size(64)
fn add_ambient(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= ambient.count {
        return;
    }
    let ray = rays[i];
    if ray.length >= light_FAR && ambient.before_sky == 0u {
        return;
    }
    let medium = ambient.medium;
    let way = light_length_inside(ray.origin, ray.direction, ray.length);
    let seen = ambient.radiance * vec3(
        scattered(medium.sigma_s.x, medium.sigma_t.x, way),
        scattered(medium.sigma_s.y, medium.sigma_t.y, way),
        scattered(medium.sigma_s.z, medium.sigma_t.z, way),
    );
    radiance[i] = vec4(radiance[i].xyz + seen, radiance[i].w);
}

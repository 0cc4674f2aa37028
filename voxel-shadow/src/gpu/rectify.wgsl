// Rectification of a shadow map: entry point, one invocation per light ray. Finds the voxel
// along α that holds the ray's first blocker.

struct Parameters {
    lattice: epi_Lattice,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> planes: array<vec2<f32>>;
@group(0) @binding(2) var<storage> light_angles: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read_write> indices: array<u32>;

@compute @workgroup_size(64)
fn rectify(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    let l = parameters.lattice;
    if i >= l.theta * l.bits {
        return;
    }
    let phi = light_angles[i % l.bits];
    let ray = epi_light_ray(l, planes[i / l.bits], phi);
    indices[i] = epi_blocked_from(l, phi, vsv_first_blocker(ray.origin, ray.direction));
}

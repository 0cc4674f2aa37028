// Positions of points in a lattice, in voxels: entry point, one invocation per point.

struct Parameters {
    lattice: epi_Lattice,
    count: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> bounds: array<vec2<f32>>;
@group(0) @binding(2) var<storage> points: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> positions: array<vec4<f32>>;

fn epi_bound(index: u32) -> vec2<f32> {
    return bounds[index];
}

@compute @workgroup_size(64)
fn locate(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= parameters.count {
        return;
    }
    let l = parameters.lattice;
    let point = points[i].xyz;
    let ray = epi_ray_to(l, point);
    positions[i] = vec4(
        epi_alpha_position(l, ray.alpha),
        epi_theta_position(l, ray.theta),
        epi_phi_position(l, epi_phi(l, ray, point)),
        0.0,
    );
}

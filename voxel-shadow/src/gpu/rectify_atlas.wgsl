// Rectification of the blockers of many lights: entry point, one invocation per
// light ray.
//
// Needs the part EPIPOLAR of epipolar, and the slot of blockers, `AtlasBlockerSlot`,
//   fn vsv_first_blocker_of(tile: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32

struct Parameters {
    // Planes of a tile, voxels along φ, and tiles.
    theta: u32,
    bits: u32,
    tiles: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> lattices: array<epi_Lattice>;
// Those of all lattices, one after the other.
@group(0) @binding(2) var<storage> planes: array<vec2<f32>>;
@group(0) @binding(3) var<storage> light_angles: array<vec2<f32>>;
@group(0) @binding(4) var<storage, read_write> indices: array<u32>;

@compute @workgroup_size(64)
fn rectify_atlas(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    let plane = i / parameters.bits;
    let tile = plane / parameters.theta;
    if tile >= parameters.tiles {
        return;
    }
    let l = lattices[tile];
    let phi = light_angles[tile * parameters.bits + i % parameters.bits];
    let ray = epi_light_ray(l, planes[plane], phi);
    let distance = vsv_first_blocker_of(tile, ray.origin, ray.direction);
    indices[i] = epi_blocked_from(l, phi, distance);
}

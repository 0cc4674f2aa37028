// The heights of the vertices of a light volume: entry point. One invocation per texel.
//
// Needs the parts face.wgsl and mesh.wgsl.

struct Heights {
    // 0 for parallel rays, else the tangent of half the opening angle.
    tan: f32,
    resolution: u32,
    // The number of texels of all pictures.
    texels: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> record: Heights;
@group(0) @binding(1) var<storage> depths: array<f32>;
@group(0) @binding(2) var<storage, read_write> heights: array<f32>;

@compute @workgroup_size(64)
fn find_heights(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = gpu_index(workgroup, workgroups, local, 64u);
    if index >= record.texels {
        return;
    }
    let depth = depths[index];
    if depth == light_EMPTY || record.tan == 0.0 {
        heights[index] = depth;
        return;
    }
    let n = record.resolution;
    let centre = vec2<f32>(vec2(index % n, index / n % n) * 2u + 1u) / f32(n) - 1.0;
    let at = centre * record.tan;
    // The depth is the distance from the light, which is z times this root; the height is
    // −1/z, so that planes are linear in the picture.
    heights[index] = -sqrt(at.x * at.x + at.y * at.y + 1.0) / max(depth, light_volume_NEAREST);
}

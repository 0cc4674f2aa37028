// The least and the greatest depth of the blocks of a shadow map: entry point. One invocation
// per block. A block is eight texels of a row or of a column.
//
// Needs the parts face.wgsl and fan.wgsl.

struct Blocks {
    resolution: u32,
    // The number of blocks of all pictures, along rows and along columns.
    blocks: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> record: Blocks;
@group(0) @binding(1) var<storage> depths: array<f32>;
@group(0) @binding(2) var<storage, read_write> bounds: array<vec2<f32>>;

@compute @workgroup_size(64)
fn find_bounds(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = gpu_index(workgroup, workgroups, local, 64u);
    if index >= record.blocks {
        return;
    }
    let n = record.resolution;
    let per_side = (n + (1u << light_BLOCK) - 1u) >> light_BLOCK;
    let across = index % n;
    let block = index / n % per_side;
    let kind = index / n / per_side;
    let base = kind / 2u * n * n;
    var node = vec2(light_EMPTY, 0.0);
    for (var cell = block << light_BLOCK; cell < min((block + 1u) << light_BLOCK, n); cell++) {
        let at = select(across * n + cell, cell * n + across, (kind & 1u) != 0u);
        let depth = depths[base + at];
        node = vec2(min(node.x, depth), max(node.y, depth));
    }
    bounds[index] = node;
}

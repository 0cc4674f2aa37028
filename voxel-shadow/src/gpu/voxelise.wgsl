// Sets the bits of a rectified map: entry points.

struct Parameters {
    // Rows along α, and words of a row.
    rows: u32,
    columns: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read_write> words: array<u32>;
// For each light ray the row of its first blocker; the number of rows for none.
@group(0) @binding(2) var<storage> indices: array<u32>;

// One invocation per word of the grid.
@compute @workgroup_size(64)
fn clear(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < parameters.rows * parameters.columns {
        words[i] = 0u;
    }
}

// One invocation per column of words, which no other invocation touches.
@compute @workgroup_size(64)
fn voxelise(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let column = gpu_index(workgroup, workgroups, local, 64u);
    if column >= parameters.columns {
        return;
    }
    for (var bit = 0u; bit < 32u; bit += 1u) {
        let row = indices[32u * column + bit];
        if row < parameters.rows {
            words[row * parameters.columns + column] |= 1u << bit;
        }
    }
}

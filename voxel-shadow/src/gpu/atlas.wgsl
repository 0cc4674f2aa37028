// From the index maps of many lights to their grids: entry point. One invocation per column
// of words of a tile. It clears the column, sets its bits and extrudes them; no other
// invocation touches the column.

struct Parameters {
    // Rows of a tile, words of a row, and tiles.
    rows: u32,
    columns: u32,
    tiles: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read_write> words: array<u32>;
// For each light ray the row of its first blocker; the number of rows for none.
@group(0) @binding(2) var<storage> indices: array<u32>;

@compute @workgroup_size(64)
fn build_atlas(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let columns = parameters.columns;
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= parameters.tiles * columns {
        return;
    }
    let top = i / columns * parameters.rows * columns + i % columns;
    for (var row = 0u; row < parameters.rows; row += 1u) {
        words[top + row * columns] = 0u;
    }
    for (var bit = 0u; bit < 32u; bit += 1u) {
        let row = indices[32u * i + bit];
        if row < parameters.rows {
            words[top + row * columns] |= 1u << bit;
        }
    }
    // What is dark in a row is dark in all rows behind it.
    var sum = 0u;
    for (var row = 0u; row < parameters.rows; row += 1u) {
        sum |= words[top + row * columns];
        words[top + row * columns] = sum;
    }
}

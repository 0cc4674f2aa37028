// Fans of epipolar lines: the shader's side of `Fan`.

struct light_Fan {
    // The picture of the eye: along the cells, across, w.
    eye: vec3<f32>,
    // Where the first slice meets the side, and slices per unit there.
    first: f32,
    density: f32,
    // 0 if there is no such fan.
    slices: u32,
    // The first cell from the side, and the logarithm of the number of leaves.
    first_cell: u32,
    height: u32,
    // The first node.
    nodes: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// The logarithm of the number of cells per leaf.
const light_LEAF: u32 = 3u;

// The logarithm of the number of texels of a block.
const light_BLOCK: u32 = 3u;

// The number of a cell from the side of a fan, or the cell of that number. Sides of
// odd fans are at the last cell.
fn light_from_side(fan: u32, cell: i32, resolution: u32) -> i32 {
    return select(cell, i32(resolution) - 1 - cell, (fan & 1u) != 0u);
}

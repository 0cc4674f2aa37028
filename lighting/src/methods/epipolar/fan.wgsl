// Fans of epipolar lines: the shader's side of `Fan`, which says what they are.

struct light_Fan {
    // The image of the eye: coordinates along the cells and across, and w.
    eye: vec3<f32>,
    // The position at which the first slice meets the side, and the number of slices per unit
    // there.
    first: f32,
    density: f32,
    // 0 if there is no such fan.
    slices: u32,
    // The first cell from the side that is in the trees, and the base-2 logarithm of the
    // number of leaves.
    first_cell: u32,
    height: u32,
    // The index of the first node.
    nodes: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// The base-2 logarithm of the number of cells per leaf.
const light_LEAF: u32 = 3u;

// The base-2 logarithm of the number of texels of a block.
const light_BLOCK: u32 = 3u;

// The index of a cell counted from the side of a fan, or the cell with that index: the
// function is its own inverse. Sides of fans with odd numbers are at the last cell.
fn light_from_side(fan: u32, cell: i32, resolution: u32) -> i32 {
    return select(cell, i32(resolution) - 1 - cell, (fan & 1u) != 0u);
}

// Where the froxels of a view are: the shader's side of `FroxelGrid`.

struct light_Froxels {
    eye: vec3<f32>,
    near: f32,
    right: vec3<f32>,
    far: f32,
    up: vec3<f32>,
    // The side of a tile on a picture at the distance 1.
    tile: f32,
    forward: vec3<f32>,
    slices: u32,
    // Where the axis of the camera is, in tiles.
    middle: vec2<f32>,
    columns: u32,
    rows: u32,
}

// The two neighbours of a position among centres at whole numbers plus ½, and the share of
// the second.
struct light_Neighbours {
    low: u32,
    high: u32,
    share: f32,
}

// The distance from the eye at which the slice u begins, m; slices get longer with distance.
fn light_froxel_depth(grid: light_Froxels, u: f32) -> f32 {
    let t = u / f32(grid.slices);
    return grid.near + (grid.far - grid.near) * (t * t);
}

// The slice at a distance, as a real number: the inverse of light_froxel_depth.
fn light_froxel_slice(grid: light_Froxels, x: f32) -> f32 {
    let t = clamp((x - grid.near) / (grid.far - grid.near), 0.0, 1.0);
    return f32(grid.slices) * sqrt(t);
}

// The direction through a place of the picture, in tiles.
fn light_froxel_direction(grid: light_Froxels, at: vec2<f32>) -> vec3<f32> {
    let plane = (at - grid.middle) * grid.tile;
    return normalize(grid.forward + plane.x * grid.right - plane.y * grid.up);
}

// Where a direction is in the picture, in tiles; the third number is 0 for directions that
// do not point to the front of the camera, else 1.
fn light_froxel_place(grid: light_Froxels, direction: vec3<f32>) -> vec3<f32> {
    let scale = dot(direction, grid.forward) * grid.tile;
    if !(scale > 0.0) {
        return vec3(0.0);
    }
    let plane = vec2(dot(direction, grid.right), -dot(direction, grid.up)) / scale;
    return vec3(grid.middle + plane, 1.0);
}

// Column and row of the tile with this number.
fn light_froxel_tile(grid: light_Froxels, number: u32) -> vec2<f32> {
    return vec2(f32(number % grid.columns), f32(number / grid.columns));
}

// The index of the froxel in a slice of a tile.
fn light_froxel_index(grid: light_Froxels, column: u32, row: u32, slice: u32) -> u32 {
    return (row * grid.columns + column) * grid.slices + slice;
}

fn light_froxel_neighbours(position: f32, count: u32) -> light_Neighbours {
    let last = f32(count - 1u);
    let from_first = clamp(position - 0.5, 0.0, last);
    let low = floor(from_first);
    return light_Neighbours(u32(low), u32(min(low + 1.0, last)), from_first - low);
}

// Blends the froxels of a frame with those of earlier frames: entry point. One invocation
// per froxel.

struct Blend {
    grid: light_Froxels,
    before: light_Froxels,
    // The largest share of earlier frames.
    share: f32,
    // Whether both grids have the same froxels.
    is_same: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> blend: Blend;
@group(0) @binding(1) var<storage> before: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> scattered: array<vec4<f32>>;

fn before_between(column: u32, row: u32, depth: light_Neighbours) -> vec4<f32> {
    let first = before[light_froxel_index(blend.before, column, row, depth.low)];
    let second = before[light_froxel_index(blend.before, column, row, depth.high)];
    return first + (second - first) * depth.share;
}

// What earlier frames have at a point of the world: the light, and how many frames it is the
// mean of. All 0 if they did not see the point.
fn before_at(point: vec3<f32>) -> vec4<f32> {
    let grid = blend.before;
    let offset = point - grid.eye;
    let place = light_froxel_place(grid, offset);
    let x = length(offset);
    let end = vec2(f32(grid.columns), f32(grid.rows));
    let is_seen = place.z > 0.0
        && all(place.xy >= vec2(0.0)) && all(place.xy <= end)
        && x >= grid.near && x <= grid.far;
    if !is_seen {
        return vec4(0.0);
    }
    let across = light_froxel_neighbours(place.x, grid.columns);
    let down = light_froxel_neighbours(place.y, grid.rows);
    let depth = light_froxel_neighbours(light_froxel_slice(grid, x), grid.slices);
    let left = before_between(across.low, down.low, depth);
    let right = before_between(across.high, down.low, depth);
    let upper = left + (right - left) * across.share;
    let lower_left = before_between(across.low, down.high, depth);
    let lower_right = before_between(across.high, down.high, depth);
    let lower = lower_left + (lower_right - lower_left) * across.share;
    return upper + (lower - upper) * down.share;
}

@compute @workgroup_size(64)
fn blend_froxels(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let grid = blend.grid;
    let i = gpu_index(workgroup, workgroups, local, 64u);
    let number = i / grid.slices;
    if number >= grid.columns * grid.rows {
        return;
    }
    var earlier: vec4<f32>;
    if blend.is_same != 0u {
        earlier = before[i];
    } else {
        let direction = light_froxel_direction(grid, light_froxel_tile(grid, number) + 0.5);
        let x = light_froxel_depth(grid, f32(i % grid.slices) + 0.5);
        earlier = before_at(grid.eye + x * direction);
    }
    let now = scattered[i];
    let of_earlier = min(blend.share, earlier.w / (earlier.w + 1.0));
    let mean = now.xyz + (earlier.xyz - now.xyz) * of_earlier;
    scattered[i] = vec4(mean, 1.0 / (1.0 - of_earlier));
}

// The airlight at the ends of rays: entry point. One invocation per ray.

struct LookUp {
    grid: light_Froxels,
    rays: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

struct Ray {
    origin: vec3<f32>,
    length: f32,
    direction: vec3<f32>,
    padding: f32,
}

@group(0) @binding(0) var<uniform> look: LookUp;
@group(0) @binding(1) var<storage> airlight: array<vec4<f32>>;
@group(0) @binding(2) var<storage> rays: array<Ray>;
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4<f32>>;

// The airlight of a tile up to the slice `u`, interpolated between ends of slices.
fn at_depth(column: u32, row: u32, u: f32) -> vec3<f32> {
    let slice = min(u32(u), look.grid.slices - 1u);
    let i = light_froxel_index(look.grid, column, row, slice);
    var before = vec3(0.0);
    if slice > 0u {
        before = airlight[i - 1u].xyz;
    }
    return before + (airlight[i].xyz - before) * (u - f32(slice));
}

@compute @workgroup_size(64)
fn look_up(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= look.rays {
        return;
    }
    let grid = look.grid;
    let ray = rays[i];
    let place = light_froxel_place(grid, ray.direction);
    if !(place.z > 0.0 && ray.length > grid.near) {
        return;
    }
    let u = light_froxel_slice(grid, min(ray.length, grid.far));
    let across = light_froxel_neighbours(place.x, grid.columns);
    let down = light_froxel_neighbours(place.y, grid.rows);
    let left = at_depth(across.low, down.low, u);
    let upper = left + (at_depth(across.high, down.low, u) - left) * across.share;
    let lower_left = at_depth(across.low, down.high, u);
    let lower = lower_left + (at_depth(across.high, down.high, u) - lower_left) * across.share;
    let light = upper + (lower - upper) * down.share;
    radiance[i] = vec4(radiance[i].xyz + light, radiance[i].w);
}

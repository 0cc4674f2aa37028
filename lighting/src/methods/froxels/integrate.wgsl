// The airlight from the eye to the end of each froxel: entry point. One invocation per tile
// goes along its slices.

struct Integration {
    grid: light_Froxels,
    medium: light_Medium,
}

@group(0) @binding(0) var<uniform> integration: Integration;
@group(0) @binding(1) var<storage> scattered: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> airlight: array<vec4<f32>>;

fn light_medium() -> light_Medium {
    return integration.medium;
}

// The part PATH needs a light; none is asked about here.
fn light_emitter() -> light_Emitter {
    return light_Emitter();
}

fn light_cookie(index: u32) -> vec3<f32> {
    return vec3(0.0);
}

@compute @workgroup_size(64)
fn integrate(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let grid = integration.grid;
    let sigma_t = integration.medium.sigma_t;
    let number = gpu_index(workgroup, workgroups, local, 64u);
    if number >= grid.columns * grid.rows {
        return;
    }
    let direction = light_froxel_direction(grid, light_froxel_tile(grid, number) + 0.5);
    let inside = light_inside(grid.eye, direction, vec2(0.0, grid.far));
    var sum = vec3(0.0);
    for (var slice = 0u; slice < grid.slices; slice++) {
        let start = max(light_froxel_depth(grid, f32(slice)), inside.x);
        let end = min(light_froxel_depth(grid, f32(slice + 1u)), inside.y);
        let i = number * grid.slices + slice;
        if start < end {
            let length = end - start;
            let mean = vec3(
                light_mean_exponential(sigma_t.x * length),
                light_mean_exponential(sigma_t.y * length),
                light_mean_exponential(sigma_t.z * length),
            );
            let before = exp(-sigma_t * (start - inside.x));
            sum = min(sum + scattered[i].xyz * (before * mean * length), vec3(light_FAR));
        }
        airlight[i] = vec4(sum, 0.0);
    }
}

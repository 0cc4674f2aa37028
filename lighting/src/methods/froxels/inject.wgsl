// The light of a lamp that froxels scatter towards the eye: entry point. One invocation per
// froxel.
//
// Needs the slot of the point visibility,
//   fn light_point_visibility(point: vec3<f32>) -> vec3<f32>

struct Injection {
    grid: light_Froxels,
    emitter: light_Emitter,
    medium: light_Medium,
    // Where each froxel is sampled, from 0 to 1 across, down and along.
    jitter: vec3<f32>,
    // Whether the froxels have the light of other lights already.
    adds: u32,
    // Whether the medium dims the light on its way.
    extinction: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(0) var<uniform> injection: Injection;
@group(0) @binding(1) var<storage> cookie: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> scattered: array<vec4<f32>>;

// The least square of a distance from a light, m².
const LEAST_SQUARE: f32 = 1e-24;

fn light_emitter() -> light_Emitter {
    return injection.emitter;
}

fn light_medium() -> light_Medium {
    return injection.medium;
}

fn light_cookie(index: u32) -> vec3<f32> {
    return cookie[index].xyz;
}

// The light that a metre of a ray along `direction` scatters at a point towards the eye,
// without the extinction between the two.
fn light_scattered_at(direction: vec3<f32>, point: vec3<f32>, least_square: f32) -> vec3<f32> {
    let emitter = injection.emitter;
    let medium = injection.medium;
    let is_sun = emitter.kind == light_DIRECTIONAL;
    var travel = emitter.position;
    var factor = vec3(1.0);
    var inverse_square = 1.0;
    var leg = 0.0;
    if is_sun {
        if medium.bounded != 0u {
            // A position on a face may be rounded out of the box.
            let inside = clamp(point, medium.low, medium.high);
            leg = light_length_inside(inside, -travel, light_FAR);
        }
    } else {
        let offset = point - emitter.position;
        let square = dot(offset, offset);
        let d = sqrt(square);
        if !(d <= emitter.range) {
            return vec3(0.0);
        }
        travel = direction;
        if d > 0.0 {
            travel = offset / d;
        }
        factor = light_window_at(emitter, d) * light_factor(emitter, travel);
        if max(factor.x, max(factor.y, factor.z)) <= 0.0 {
            return vec3(0.0);
        }
        inverse_square = 1.0 / max(square, least_square);
        leg = light_length_inside(point, -travel, d);
    }
    let visibility = light_point_visibility(point);
    if max(visibility.x, max(visibility.y, visibility.z)) <= 0.0 {
        return vec3(0.0);
    }
    let cos = clamp(-dot(direction, travel), -1.0, 1.0);
    let phase = air_phase(medium.phase, medium.phase_parameters, 1.0 - cos, 1.0 + cos);
    if injection.extinction != 0u {
        factor *= exp(-medium.sigma_t * leg);
    }
    // Factors that may be 0 come first, so that large ones cannot overflow before them.
    return visibility * (factor * medium.sigma_s) * (phase * emitter.intensity) * inverse_square;
}

@compute @workgroup_size(64)
fn inject(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let grid = injection.grid;
    let i = gpu_index(workgroup, workgroups, local, 64u);
    let number = i / grid.slices;
    if number >= grid.columns * grid.rows {
        return;
    }
    let slice = f32(i % grid.slices);
    let at = light_froxel_tile(grid, number) + injection.jitter.xy;
    let direction = light_froxel_direction(grid, at);
    let inside = light_inside(grid.eye, direction, vec2(0.0, grid.far));
    let start = max(light_froxel_depth(grid, slice), inside.x);
    let end = min(light_froxel_depth(grid, slice + 1.0), inside.y);
    var light = vec3(0.0);
    if start < end {
        let length = end - start;
        let x = start + injection.jitter.z * length;
        let least_square = max(x * grid.tile * length / 8.0, LEAST_SQUARE);
        light = light_scattered_at(direction, grid.eye + x * direction, least_square);
    }
    var before = vec4(0.0, 0.0, 0.0, 1.0);
    if injection.adds != 0u {
        before = scattered[i];
    }
    scattered[i] = vec4(min(before.xyz + light, vec3(light_FAR)), before.w);
}

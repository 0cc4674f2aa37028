// Lit parts of many rays: entry points, one invocation per ray.

struct Parameters {
    dag: dag_Shadows,
    space: dag_Space,
    count: u32,
    // The most lit intervals that are stored per ray.
    places: u32,
    padding_a: u32,
    padding_b: u32,
}

struct Ray {
    origin: vec3<f32>,
    length: f32,
    direction: vec3<f32>,
    padding: f32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> words: array<u32>;
@group(0) @binding(2) var<storage> rays: array<Ray>;
@group(0) @binding(3) var<storage, read_write> lengths: array<f32>;
@group(0) @binding(3) var<storage, read_write> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> intervals: array<dag_LitInterval>;

fn dag_word(index: u32) -> u32 {
    return words[index];
}

// False for infinity and NaN, whose exponents have all bits set.
fn is_finite(x: vec3<f32>) -> bool {
    return all((bitcast<vec3<u32>>(x) & vec3(0x7f800000u)) != vec3(0x7f800000u));
}

// The walk along a ray. A ray with infinite numbers, NaN or no direction has no length.
fn cursor(ray: Ray) -> dag_Cursor {
    let sound = is_finite(ray.origin) && is_finite(ray.direction) && any(ray.direction != vec3(0.0));
    let length = select(0.0, clamp(ray.length, 0.0, dag_FAR), sound);
    return dag_cursor(parameters.space, ray.origin, ray.direction, 0.0, length);
}

@compute @workgroup_size(64)
fn lit_length(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < parameters.count {
        var ray = cursor(rays[i]);
        lengths[i] = dag_lit_length(parameters.dag, parameters.space, &ray);
    }
}

@compute @workgroup_size(64)
fn lit_intervals(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= parameters.count {
        return;
    }
    var ray = cursor(rays[i]);
    var count = 0u;
    loop {
        let interval = dag_next_lit(parameters.dag, parameters.space, &ray);
        if interval.start == interval.end {
            break;
        }
        if count < parameters.places {
            intervals[i * parameters.places + count] = interval;
        }
        count += 1u;
    }
    counts[i] = count;
}

// Queries of many rays or points: entry points, one invocation each.

struct Parameters {
    lattice: epi_Lattice,
    sampling: vsv_Sampling,
    count: u32,
    // Unused here: the layout is that of intervals.wgsl.
    capacity: u32,
    // Where the words of the volume begin.
    first_word: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> bounds: array<vec2<f32>>;
@group(0) @binding(2) var<storage> words: array<u32>;
// Direction of a ray and distance of its surface; for `visibility` the position of a point.
@group(0) @binding(3) var<storage> rays: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> results: array<f32>;
// For each voxel along φ the sum of the weights of those before it.
@group(0) @binding(5) var<storage> sums: array<f32>;

fn epi_bound(index: u32) -> vec2<f32> {
    return bounds[index];
}

fn vsv_word(index: u32) -> u32 {
    return words[parameters.first_word + index];
}

@compute @workgroup_size(64)
fn visibility(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < parameters.count {
        results[i] = vsv_visibility(parameters.lattice, parameters.sampling, rays[i].xyz);
    }
}

@compute @workgroup_size(64)
fn lit_fraction(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < parameters.count {
        var cursor = vsv_cursor(parameters.lattice, parameters.sampling, rays[i].xyz, rays[i].w);
        results[i] = vsv_lit_fraction(parameters.lattice, parameters.sampling, &cursor);
    }
}

// The weight of all voxels before a position along φ, and of its share of the voxel it is in.
fn weight_before(position: f32) -> f32 {
    let first = min(u32(position), parameters.lattice.bits - 1u);
    return sums[first] + clamp(position - f32(first), 0.0, 1.0) * (sums[first + 1u] - sums[first]);
}

// The sum of the weights of the lit voxels of each ray.
@compute @workgroup_size(64)
fn weighted_sum(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= parameters.count {
        return;
    }
    var cursor = vsv_cursor(parameters.lattice, parameters.sampling, rays[i].xyz, rays[i].w);
    var sum = 0.0;
    loop {
        let run = vsv_next_run(parameters.lattice, parameters.sampling, &cursor);
        if run.visibility <= 0.0 {
            break;
        }
        sum += run.visibility * (weight_before(run.end) - weight_before(run.start));
    }
    results[i] = sum;
}

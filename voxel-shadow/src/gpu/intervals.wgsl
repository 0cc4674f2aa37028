// Lit intervals of many rays: entry point, one invocation per ray.

struct Parameters {
    lattice: epi_Lattice,
    sampling: vsv_Sampling,
    count: u32,
    // The most intervals that are stored per ray; all are counted.
    capacity: u32,
    // Where the words of the volume begin.
    first_word: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> bounds: array<vec2<f32>>;
@group(0) @binding(2) var<storage> words: array<u32>;
// Direction, and distance of the surface.
@group(0) @binding(3) var<storage> rays: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> intervals: array<vsv_LitInterval>;
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;

fn epi_bound(index: u32) -> vec2<f32> {
    return bounds[index];
}

fn vsv_word(index: u32) -> u32 {
    return words[parameters.first_word + index];
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
    let l = parameters.lattice;
    var cursor = vsv_cursor(l, parameters.sampling, rays[i].xyz, rays[i].w);
    var count = 0u;
    loop {
        let interval = vsv_next_lit(l, parameters.sampling, &cursor);
        if interval.visibility <= 0.0 {
            break;
        }
        if count < parameters.capacity {
            intervals[i * parameters.capacity + count] = interval;
        }
        count += 1u;
    }
    counts[i] = count;
}

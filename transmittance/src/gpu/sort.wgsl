// Sorts captured segments by one digit of one of their numbers: entry points.
// Equal ones stay in their order. Every invocation has CHUNK segments, counts
// their digits, and knows from the sums of all counts where its own begin.

const CHUNK: u32 = 256u;
const DIGITS: u32 = 16u;

struct Parameters {
    count: u32,
    chunks: u32,
    // 0: the texel, else the number of the segment in front of this.
    field: u32,
    shift: u32,
    texels: u32,
    stride: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> texels: array<u32>;
@group(0) @binding(2) var<storage> numbers: array<u32>;
// Which segment is where, before and after.
@group(0) @binding(3) var<storage> order: array<u32>;
@group(0) @binding(4) var<storage, read_write> counts: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted: array<u32>;

fn digit(segment: u32) -> u32 {
    var key = min(texels[segment], parameters.texels);
    if parameters.field > 0u {
        // Integers that are ordered as the numbers are.
        let bits = numbers[segment * parameters.stride + parameters.field - 1u];
        key = bits ^ select(0x80000000u, 0xffffffffu, bits >= 0x80000000u);
    }
    return (key >> parameters.shift) % DIGITS;
}

@compute @workgroup_size(64)
fn count_digits(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let chunk = gpu_index(workgroup, workgroups, local, 64u);
    if chunk >= parameters.chunks {
        return;
    }
    var own: array<u32, DIGITS>;
    let end = min((chunk + 1u) * CHUNK, parameters.count);
    for (var i = chunk * CHUNK; i < end; i++) {
        own[digit(order[i])] += 1u;
    }
    for (var d = 0u; d < DIGITS; d++) {
        counts[d * parameters.chunks + chunk] = own[d];
    }
}

@compute @workgroup_size(64)
fn place(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let chunk = gpu_index(workgroup, workgroups, local, 64u);
    if chunk >= parameters.chunks {
        return;
    }
    var next: array<u32, DIGITS>;
    for (var d = 0u; d < DIGITS; d++) {
        next[d] = counts[d * parameters.chunks + chunk];
    }
    let end = min((chunk + 1u) * CHUNK, parameters.count);
    for (var i = chunk * CHUNK; i < end; i++) {
        let segment = order[i];
        let d = digit(segment);
        sorted[next[d]] = segment;
        next[d] += 1u;
    }
}

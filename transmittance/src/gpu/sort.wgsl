// A pass of a radix sort: sorts captured segments by one digit of one of their numbers.
// Entry points. Equal digits stay in their order. Every invocation has CHUNK segments,
// counts their digits, and learns from the scanned counts where its own go.

const CHUNK: u32 = 256u;
const DIGITS: u32 = 16u;

struct Parameters {
    count: u32,
    chunks: u32,
    // What is sorted by: 0 is the texel, k > 0 the number k − 1 of a segment.
    field: u32,
    // The lowest bit of the digit.
    shift: u32,
    // Texels of the map; segments with larger ones come last.
    texels: u32,
    stride: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> texels: array<u32>;
@group(0) @binding(2) var<storage> numbers: array<u32>;
// The segments in the order before this pass.
@group(0) @binding(3) var<storage> order: array<u32>;
// How often each digit occurs in each chunk, digit by digit; after the scan, where the
// first of them goes.
@group(0) @binding(4) var<storage, read_write> counts: array<u32>;
// The segments in the order after it.
@group(0) @binding(5) var<storage, read_write> sorted: array<u32>;

// The digit of a segment.
fn digit(segment: u32) -> u32 {
    var key = min(texels[segment], parameters.texels);
    if parameters.field > 0u {
        // Flips the bits of floats so that integers compare as the floats do.
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

// An exclusive prefix sum: each number is replaced by the sum of those before it. Entry
// points. Every invocation takes a chunk of CHUNK numbers by itself, without barriers; the
// sums of the chunks are scanned in between in the same way.

const CHUNK: u32 = 256u;

@group(0) @binding(0) var<uniform> count: u32;
@group(0) @binding(1) var<storage, read_write> numbers: array<u32>;
@group(0) @binding(2) var<storage, read_write> sums: array<u32>;

// The sum of each chunk.
@compute @workgroup_size(64)
fn sum_chunks(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let first = gpu_index(workgroup, workgroups, local, 64u) * CHUNK;
    if first >= count {
        return;
    }
    var sum = 0u;
    for (var i = first; i < min(first + CHUNK, count); i++) {
        sum += numbers[i];
    }
    sums[first / CHUNK] = sum;
}

// The sums within each chunk; `sums` now holds the sum of all numbers before each chunk.
@compute @workgroup_size(64)
fn sum_before(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let first = gpu_index(workgroup, workgroups, local, 64u) * CHUNK;
    if first >= count {
        return;
    }
    var before = sums[first / CHUNK];
    for (var i = first; i < min(first + CHUNK, count); i++) {
        let number = numbers[i];
        numbers[i] = before;
        before += number;
    }
}

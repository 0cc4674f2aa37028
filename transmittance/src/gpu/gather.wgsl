// From sorted segments to lists by texel: entry points.

struct Parameters {
    // Segments, texels of the map, and numbers of a segment.
    count: u32,
    texels: u32,
    stride: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
// The texel of each segment, and its numbers, as they were captured.
@group(0) @binding(1) var<storage> texels: array<u32>;
@group(0) @binding(2) var<storage> numbers: array<u32>;
// The segments in the order of the lists.
@group(0) @binding(3) var<storage> order: array<u32>;
@group(0) @binding(4) var<storage, read_write> results: array<u32>;

// Where the list of each texel begins: behind the segments of all texels before it. Found
// by bisection; one more invocation than there are texels finds where the last list ends.
@compute @workgroup_size(64)
fn find_offsets(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let texel = gpu_index(workgroup, workgroups, local, 64u);
    if texel > parameters.texels {
        return;
    }
    var first = 0u;
    var end = parameters.count;
    while first < end {
        let middle = first + (end - first) / 2u;
        if texels[order[middle]] < texel {
            first = middle + 1u;
        } else {
            end = middle;
        }
    }
    results[texel] = first;
}

// Copies the numbers of each segment to its place in the lists.
@compute @workgroup_size(64)
fn gather(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= parameters.count {
        return;
    }
    for (var k = 0u; k < parameters.stride; k++) {
        results[i * parameters.stride + k] = numbers[order[i] * parameters.stride + k];
    }
}

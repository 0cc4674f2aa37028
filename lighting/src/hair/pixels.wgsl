// Adds the light of its points to each pixel: entry point. One invocation per pixel.

struct Pixels {
    // How many, and the first.
    count: u32,
    first: u32,
    // The points of each pixel that this dispatch adds: the first, and how many at most.
    begin: u32,
    most: u32,
}

@group(0) @binding(0) var<uniform> pixels: Pixels;
// The index behind the last point of each pixel.
@group(0) @binding(1) var<storage> ends: array<u32>;
@group(0) @binding(2) var<storage> scattered: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4<f32>>;

@compute @workgroup_size(64)
fn add_to_pixels(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= pixels.count {
        return;
    }
    var start = 0u;
    if i > 0u {
        start = ends[i - 1u];
    }
    let begin = start + min(pixels.begin, ends[i] - start);
    let end = begin + min(pixels.most, ends[i] - begin);
    var sum = radiance[pixels.first + i];
    for (var k = begin; k < end; k++) {
        sum += scattered[k];
    }
    radiance[pixels.first + i] = sum;
}

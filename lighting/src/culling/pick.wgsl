// Copies some of the pixels of a picture into a buffer of their own, or back: entry points,
// one invocation per copied pixel.

// Which pixels of the picture they are.
@group(0) @binding(0) var<storage> which: array<u32>;
// What is read, and what is written.
@group(0) @binding(1) var<storage> from_pixels: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> to_pixels: array<vec4<f32>>;

@compute @workgroup_size(64)
fn pick(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < arrayLength(&which) && which[i] < arrayLength(&from_pixels) {
        to_pixels[i] = from_pixels[which[i]];
    }
}

@compute @workgroup_size(64)
fn put_back(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < arrayLength(&which) && which[i] < arrayLength(&to_pixels) {
        to_pixels[which[i]] = from_pixels[i];
    }
}

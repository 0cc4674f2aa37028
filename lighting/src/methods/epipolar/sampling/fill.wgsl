// Fills a picture from the samples on epipolar lines: the shader's side of `FillFromLines`.
// One invocation per pixel.

// A pixel between two lines, and on each of them between two samples.
struct Mixture {
    samples: vec2<u32>,
    along: vec2<f32>,
    across: f32,
    padding: u32,
}

// Stands for the first sample of pixels that take nothing from lines.
const NONE: u32 = 0xffffffffu;

@group(0) @binding(0) var<storage> mixtures: array<Mixture>;
@group(0) @binding(1) var<storage> gathered: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> radiance: array<vec4<f32>>;

// The light between a sample and the next one on its line.
fn line(first: u32, along: f32) -> vec3<f32> {
    let light = gathered[first].xyz;
    if along == 0.0 {
        return light;
    }
    return (1.0 - along) * light + along * gathered[first + 1u].xyz;
}

@compute @workgroup_size(64)
fn fill_from_lines(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= arrayLength(&radiance) {
        return;
    }
    let mixture = mixtures[i];
    if mixture.samples.x == NONE {
        return;
    }
    var light = line(mixture.samples.x, mixture.along.x);
    if mixture.across != 0.0 {
        let other = line(mixture.samples.y, mixture.along.y);
        light = (1.0 - mixture.across) * light + mixture.across * other;
    }
    radiance[i] += vec4(light, 0.0);
}

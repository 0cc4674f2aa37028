struct Parameters {
    count: u32,
    key: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read_write> output: array<u32>;
@group(0) @binding(2) var<storage> input: array<u32>;

@compute @workgroup_size(64)
fn scramble(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64);
    if i >= parameters.count {
        return;
    }
    let turned = (i << 7u) | (i >> 25u);
    output[i] = ((input[i] ^ turned) * 2654435761u) ^ parameters.key;
}

@compute @workgroup_size(64)
fn add(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64);
    if i < parameters.count {
        output[i] += parameters.key;
    }
}
// The end of a part may be a comment

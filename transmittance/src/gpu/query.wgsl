// How much light gets to receivers: entry point, one invocation each.

struct Receiver {
    // In texels of the map.
    position: array<f32, 2>,
    depth: f32,
}

struct Parameters {
    width: u32,
    height: u32,
    // Receivers, and texels per side of the filter, as for avsm_filtered.
    count: u32,
    side: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> words: array<u32>;
@group(0) @binding(2) var<storage> receivers: array<Receiver>;
@group(0) @binding(3) var<storage, read_write> results: array<f32>;

fn avsm_word(index: u32) -> u32 {
    return words[index];
}

@compute @workgroup_size(64)
fn query(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= parameters.count {
        return;
    }
    let extent = vec2(parameters.width, parameters.height);
    var result: array<f32, avsm_CHANNELS>;
    if extent.x > 0u && extent.y > 0u {
        let receiver = receivers[i];
        let position = vec2(receiver.position[0], receiver.position[1]);
        result = avsm_filtered(extent, position, receiver.depth, parameters.side);
    } else {
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            result[c] = 1.0;
        }
    }
    for (var c = 0u; c < avsm_CHANNELS; c++) {
        results[i * avsm_CHANNELS + c] = result[c];
    }
}

// Makes a level of a pyramid from the one that is twice as fine: entry point, one invocation
// per channel of a texel.
//
// Needs the part level.wgsl.

struct Coarser {
    // The level that is made.
    level: light_Level,
    // Where the moments of the finer level begin, and where those of this one do.
    finer: u32,
    own: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> coarser: Coarser;
@group(0) @binding(1) var<storage, read_write> moments: array<f32>;

// Texels of the map that a texel of the finer level covers along an axis.
fn covered(number: u32) -> f32 {
    let finer = coarser.level.level - 1u;
    let first = number << finer;
    return f32(min(first + (1u << finer), coarser.level.pictures.resolution) - first);
}

@compute @workgroup_size(64)
fn coarsen(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = gpu_index(workgroup, workgroups, local, 64u);
    let channels = coarser.level.channels;
    let width = coarser.level.side;
    if index >= coarser.level.pictures.face_count * width * width * channels {
        return;
    }
    let texel = index / channels;
    let face = texel / (width * width);
    let first = 2u * vec2(texel % width, texel / width % width);
    let finer = coarser.level.level - 1u;
    let side = (coarser.level.pictures.resolution + (1u << finer) - 1u) >> finer;
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let at = first + vec2(i % 2u, i / 2u);
        if any(at >= vec2(side)) {
            continue;
        }
        // Texels at the far borders of the map may cover less, and weigh less.
        let size = covered(at.x) * covered(at.y);
        let number = (face * side + at.y) * side + at.x;
        sum += size * moments[coarser.finer + number * channels + index % channels];
        count += size;
    }
    moments[coarser.own + index] = sum / count;
}

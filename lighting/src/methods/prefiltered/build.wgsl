// The moments of a level: entry point. One invocation per texel.
//
// Needs the part levels.wgsl.

struct Build {
    levels: light_Levels,
    // Which of the two levels, and the number of its first texel.
    index: u32,
    first_texel: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> build: Build;
@group(0) @binding(1) var<storage> depths: array<f32>;
@group(0) @binding(2) var<storage, read_write> moments: array<f32>;

@compute @workgroup_size(64)
fn prefilter(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let levels = build.levels;
    let width = select(levels.fine, levels.coarse, build.index != 0u);
    let texel = gpu_index(workgroup, workgroups, local, 64u);
    if texel >= levels.pictures.face_count * width * width {
        return;
    }
    let side = levels.pictures.resolution;
    let level = levels.first + build.index;
    let face = texel / (width * width);
    let start = vec2(texel % width, texel / width % width) << vec2(level);
    let end = min(start + vec2(1u << level), vec2(side));
    var sums = array<f32, 6>();
    for (var row = start.y; row < end.y; row++) {
        // Sums of rows: few roundings of many texels.
        var sum = array<f32, 6>();
        for (var column = start.x; column < end.x; column++) {
            let depth = depths[(face * side + row) * side + column];
            let of_depth = light_moments_of(levels.kind, light_levels_depth(levels, depth));
            for (var i = 0u; i < 6u; i++) {
                sum[i] += of_depth[i];
            }
        }
        for (var i = 0u; i < 6u; i++) {
            sums[i] += sum[i];
        }
    }
    let count = f32((end.x - start.x) * (end.y - start.y));
    let at = (build.first_texel + texel) * levels.channels;
    for (var i = 0u; i < levels.channels; i++) {
        moments[at + i] = sums[i] / count;
    }
}

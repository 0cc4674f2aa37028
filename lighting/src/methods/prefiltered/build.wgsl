// The moments of a level: entry point. One invocation per texel.
//
// Needs the part level.wgsl.

@group(0) @binding(0) var<uniform> level: light_Level;
@group(0) @binding(1) var<storage> depths: array<f32>;
@group(0) @binding(2) var<storage, read_write> moments: array<f32>;

@compute @workgroup_size(64)
fn prefilter(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let width = level.side;
    let texel = gpu_index(workgroup, workgroups, local, 64u);
    if texel >= level.pictures.face_count * width * width {
        return;
    }
    let side = level.pictures.resolution;
    let face = texel / (width * width);
    let start = vec2(texel % width, texel / width % width) << vec2(level.level);
    let end = min(start + vec2(1u << level.level), vec2(side));
    var sums = array<f32, 6>();
    for (var row = start.y; row < end.y; row++) {
        // Sums of rows: few roundings of many texels.
        var sum = array<f32, 6>();
        for (var column = start.x; column < end.x; column++) {
            let depth = depths[(face * side + row) * side + column];
            let of_depth = light_moments_of(level.kind, light_level_depth(level, depth));
            for (var i = 0u; i < 6u; i++) {
                sum[i] += of_depth[i];
            }
        }
        for (var i = 0u; i < 6u; i++) {
            sums[i] += sum[i];
        }
    }
    let count = f32((end.x - start.x) * (end.y - start.y));
    for (var i = 0u; i < level.channels; i++) {
        moments[texel * level.channels + i] = sums[i] / count;
    }
}

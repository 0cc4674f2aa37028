// The moments of a level: entry points. At once, one invocation per texel; or rows
// first, one per row of the map and column of texels, and then their sums. Sums of
// rows are added up either way: few roundings of many texels.
//
// Needs the part level.wgsl.

@group(0) @binding(0) var<uniform> level: light_Level;
// Depths, or sums of rows.
@group(0) @binding(1) var<storage> values: array<f32>;
// Moments, or sums of rows.
@group(0) @binding(2) var<storage, read_write> moments: array<f32>;

struct Sums {
    a: vec3<f32>,
    b: vec3<f32>,
}

// What a texel covers along an axis.
fn covered(number: u32) -> vec2<u32> {
    let first = number << level.level;
    return vec2(first, min(first + (1u << level.level), level.pictures.resolution));
}

// The sum over a part of a row of all faces.
fn of_row(row: u32, columns: vec2<u32>) -> Sums {
    var sums: Sums;
    for (var column = columns.x; column < columns.y; column++) {
        let depth = values[row * level.pictures.resolution + column];
        var m = light_moments_of(level.kind, light_level_depth(level, depth));
        sums.a += vec3(m[0], m[1], m[2]);
        sums.b += vec3(m[3], m[4], m[5]);
    }
    return sums;
}

fn store(texel: u32, sums: Sums) {
    let all = array<f32, 6>(sums.a.x, sums.a.y, sums.a.z, sums.b.x, sums.b.y, sums.b.z);
    for (var i = 0u; i < level.channels; i++) {
        moments[texel * level.channels + i] = all[i];
    }
}

// The number of a face, and of a row and a column of texels.
fn place(texel: u32) -> vec3<u32> {
    let width = level.side;
    return vec3(texel / (width * width), texel / width % width, texel % width);
}

@compute @workgroup_size(64)
fn prefilter(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let texel = gpu_index(workgroup, workgroups, local, 64u);
    if texel >= level.pictures.face_count * level.side * level.side {
        return;
    }
    let at = place(texel);
    let rows = covered(at.y);
    let columns = covered(at.z);
    var sums: Sums;
    for (var row = rows.x; row < rows.y; row++) {
        let sum = of_row(at.x * level.pictures.resolution + row, columns);
        sums.a += sum.a;
        sums.b += sum.b;
    }
    let count = f32((rows.y - rows.x) * (columns.y - columns.x));
    store(texel, Sums(sums.a / count, sums.b / count));
}

@compute @workgroup_size(64)
fn sum_rows(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = gpu_index(workgroup, workgroups, local, 64u);
    if index >= level.pictures.face_count * level.pictures.resolution * level.side {
        return;
    }
    store(index, of_row(index / level.side, covered(index % level.side)));
}

@compute @workgroup_size(64)
fn join_rows(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    // One invocation per number of a texel.
    let index = gpu_index(workgroup, workgroups, local, 64u);
    let channels = level.channels;
    if index >= level.pictures.face_count * level.side * level.side * channels {
        return;
    }
    let at = place(index / channels);
    let rows = covered(at.y);
    let columns = covered(at.z);
    var sum = 0.0;
    for (var row = rows.x; row < rows.y; row++) {
        let number = (at.x * level.pictures.resolution + row) * level.side + at.z;
        sum += values[number * channels + index % channels];
    }
    moments[index] = sum / f32((rows.y - rows.x) * (columns.y - columns.x));
}

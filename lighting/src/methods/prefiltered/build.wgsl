// The moments of a level: entry points. `prefilter` makes them at once, with one invocation
// per texel. `sum_rows` first sums each row of a texel and `join_rows` then adds these up,
// which occupies more invocations if texels are large. Either way texels are summed row by
// row, so that few roundings add up.
//
// Needs the part level.wgsl.

@group(0) @binding(0) var<uniform> level: light_Level;
// What is read: depths, or sums of rows.
@group(0) @binding(1) var<storage> values: array<f32>;
// What is written: moments, or sums of rows.
@group(0) @binding(2) var<storage, read_write> moments: array<f32>;

struct Sums {
    a: vec3<f32>,
    b: vec3<f32>,
}

// The texels of the map that a texel of the level covers along an axis: the first, and the
// one behind the last.
fn covered(number: u32) -> vec2<u32> {
    let first = number << level.level;
    return vec2(first, min(first + (1u << level.level), level.pictures.resolution));
}

// The sum of the moments over a part of a row; rows of all faces are numbered through.
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

// The face, row and column of a texel of the level.
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
    // One invocation per channel of a texel.
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

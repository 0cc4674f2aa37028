// The greatest depths of cells of a shadow map: entry points, one invocation per cell. The
// finest level is made first, then each coarser one.
//
// Needs the parts face.wgsl and place.wgsl.

struct Cells {
    pictures: light_Pictures,
    // Texels per side of a finest cell, finest cells per side, and texels around a cell
    // that count as its own.
    cell: u32,
    side: u32,
    margin: u32,
    // The level that is made.
    level: u32,
    // Depths are made larger by a factor and by so many metres, which covers rounding; none
    // exceeds `most`.
    factor: f32,
    more: f32,
    most: f32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> record: Cells;
@group(0) @binding(1) var<storage> depths: array<f32>;
@group(0) @binding(2) var<storage, read_write> values: array<f32>;

// The depth at the middle of a texel outside of a picture of a cube, which another picture
// shows.
fn depth_beyond(picture: u32, texel: vec2<i32>) -> f32 {
    let n = record.pictures.resolution;
    let face = record.pictures.faces[picture];
    let plane = face.tan * ((2.0 * vec2<f32>(texel) + 1.0) / f32(n) - 1.0);
    let v = face.forward + plane.x * face.right - plane.y * face.up;
    let other = light_cube_face(v);
    let at = light_texel_along(record.pictures.faces[other], n, v);
    // Rounding may put it outside, where it is negative; conversions saturate.
    let place = min(vec2<u32>(max(at, vec2(0.0))), vec2(n - 1u));
    return depths[(other * n + place.y) * n + place.x];
}

// The first texel of a column or row of cells and the one behind its last, with the margin.
fn texels(cell: u32) -> vec2<i32> {
    let margin = i32(record.margin);
    let first = i32(cell * record.cell) - margin;
    let end = i32((cell + 1u) * record.cell) + margin;
    return vec2(max(first, -margin), min(end, i32(record.pictures.resolution) + margin));
}

@compute @workgroup_size(64)
fn find_far(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = gpu_index(workgroup, workgroups, local, 64u);
    let side = record.side;
    if index >= record.pictures.face_count * side * side {
        return;
    }
    let n = i32(record.pictures.resolution);
    let picture = index / (side * side);
    let rows = texels(index / side % side);
    let columns = texels(index % side);
    var greatest = 0.0;
    for (var y = rows.x; y < rows.y; y++) {
        for (var x = columns.x; x < columns.y; x++) {
            let is_inside = x >= 0 && x < n && y >= 0 && y < n;
            if is_inside {
                greatest = max(greatest, depths[(i32(picture) * n + y) * n + x]);
            } else if record.pictures.face_count > 1u {
                greatest = max(greatest, depth_beyond(picture, vec2(x, y)));
            }
        }
    }
    values[index] = min(min(greatest, record.most) * record.factor + record.more, record.most);
}

@compute @workgroup_size(64)
fn raise_far(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = gpu_index(workgroup, workgroups, local, 64u);
    let width = record.side >> record.level;
    let pictures = record.pictures.face_count;
    if index >= pictures * width * width {
        return;
    }
    // Where the values of a level begin: the levels below it, each with a quarter of the
    // cells of the one before, are a geometric series.
    let all = record.side * record.side;
    let own = 4u * (all - width * width) / 3u * pictures;
    let finer = 4u * (all - 4u * width * width) / 3u * pictures;
    // A level has the rows of all pictures one after the other.
    let first = finer + 2u * (index / width) * 2u * width + 2u * (index % width);
    let upper = max(values[first], values[first + 1u]);
    let lower = max(values[first + 2u * width], values[first + 2u * width + 1u]);
    values[own + index] = max(upper, lower);
}

// The least depths of cells of the pictures of a light, from the triangles: entry points.
//
// Needs the parts face.wgsl and place.wgsl.
//
// A triangle in a picture is three corners in homogeneous texels, of which only sums and
// products are formed. Bounds of their rounding errors are carried along, and every test that
// these leave open is decided in favour of the triangle.

struct Near {
    pictures: light_Pictures,
    // Texels per side of a finest cell, and finest cells per side.
    cell: u32,
    side: u32,
    triangles: u32,
    // The level that is made.
    level: u32,
    // A triangle counts in a cell if it comes within so many texels of it.
    border: f32,
    // Depths are made less by this share of themselves and by so many metres, which covers
    // rounding; `most` is the depth of a cell without triangles.
    factor: f32,
    less: f32,
    most: f32,
}

@group(0) @binding(0) var<uniform> record: Near;
// Nine coordinates for each triangle.
@group(0) @binding(1) var<storage> corners: array<f32>;
// The least depths of the finest cells, as integers that compare as the depths do.
@group(0) @binding(2) var<storage, read_write> least: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read_write> values: array<f32>;

// The rounding error of a sum of a few products, relative to the sum of their magnitudes: 8
// units of 2^-24.
const ROUNDING: f32 = 5e-7;

// Triangles of a workgroup, and its invocations, which share the cells of large triangles.
const BATCH: u32 = 32u;
const GROUP: u32 = 64u;

// An invocation goes through so many cells of a triangle by itself.
const FEW: u32 = 16u;

// A corner whose depth along the picture's axis is less than this share of the largest
// coordinate is not projected.
const NEAR: f32 = 1e-4;

// A triangle as a picture shows it.
struct Seen {
    // Corners in homogeneous texels (x, y, w), in units of `scale` metres; the largest errors
    // of their x and y, and those of their w.
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    texel_errors: vec3<f32>,
    w_errors: vec3<f32>,
    scale: f32,
    // Its normal to the right, down and forward, and the largest error of each; computed from
    // differences of corners, so that slivers have one.
    normal: vec3<f32>,
    normal_error: f32,
    // The first corner to the right, down and forward, m.
    corner: vec3<f32>,
    // A lower bound of the distance between light and plane times the length of the normal, in
    // units of `scale`.
    volume: f32,
    // Which side is seen, 1 or −1; 0 if the triangle is nearly edge-on, so that rounding
    // leaves it open.
    turn: f32,
    // A lower bound of the depths of its corners, and the largest error of a depth, m.
    depth: f32,
    depth_error: f32,
    picture: u32,
    // The cells that it may touch, from `low` to before `end`; none if it is not seen.
    low: vec2<u32>,
    end: vec2<u32>,
    // The rectangle of texels around it, from (x, y) to (z, w).
    texels: vec4<f32>,
}

var<workgroup> batch: array<Seen, 32>;

// Integers that compare as the values do, and back.
fn in_order(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(bits | 0x80000000u, ~bits, bits >> 31u == 1u);
}

fn of_order(number: u32) -> f32 {
    return bitcast<f32>(select(~number, number ^ 0x80000000u, number >> 31u == 1u));
}

// The sum of the magnitudes of its components.
fn sum_of(v: vec3<f32>) -> f32 {
    return abs(v.x) + abs(v.y) + abs(v.z);
}

// A corner in the frame of a square of texels, in units of half its side: the square is the
// directions (u, v, 1) with u and v from −1 to 1.
fn within(corner: vec3<f32>, middle: vec2<f32>, half: f32) -> vec3<f32> {
    return vec3((corner.xy - middle * corner.z) / half, corner.z);
}

// The size of a texel of a picture, to the right and down: as tangents, or in metres for
// parallel light.
fn per_texel(picture: u32) -> vec2<f32> {
    let face = record.pictures.faces[picture];
    let extent = select(vec2(face.half_width, face.half_height), vec2(face.tan), face.tan > 0.0);
    return 2.0 * extent / f32(record.pictures.resolution);
}

// Where a texel lies, to the right of the axis and down from it, in the same units.
fn on_plane(picture: u32, texel: vec2<f32>) -> vec2<f32> {
    return (texel - 0.5 * f32(record.pictures.resolution)) * per_texel(picture);
}

// A lower bound of the depth, along the axis of the picture, of the part of a triangle that
// lies in a square of texels; `most` if none does.
fn least_depth(seen: Seen, middle: vec2<f32>, half: f32) -> f32 {
    let a = within(seen.a, middle, half);
    let b = within(seen.b, middle, half);
    let c = within(seen.c, middle, half);
    // The largest errors of their coordinates, and the sums of their magnitudes.
    let r = seen.texel_errors / half + seen.w_errors;
    let m = vec3(sum_of(a), sum_of(b), sum_of(c));
    let x = vec3(a.x, b.x, c.x);
    let y = vec3(a.y, b.y, c.y);
    let w = vec3(a.z, b.z, c.z);
    // Whether all corners are beyond the same side of the square, or behind the light.
    let s = 2.0 * r;
    let is_apart = all(w < -s)
        || all(w - x < -s) || all(w + x < -s) || all(w - y < -s) || all(w + y < -s);
    if is_apart {
        return record.most;
    }
    // Seen edge-on it may be anywhere on its plane, but no nearer than its nearest corner.
    if seen.turn == 0.0 {
        return seen.depth;
    }
    // The weights of the corners in a direction are linear in it and have one sign inside of
    // the triangle. `e` bounds their errors.
    let bc = cross(b, c);
    let ca = cross(c, a);
    let ab = cross(a, b);
    let e = m.yzx * r.zxy + m.zxy * r.yzx + r.yzx * r.zxy
        + 2.0 * ROUNDING * m.yzx * m.zxy + vec3(1e-30);
    let edges = seen.turn * vec3(bc.z, ca.z, ab.z)
        + abs(vec3(bc.x, ca.x, ab.x)) + abs(vec3(bc.y, ca.y, ab.y));
    if any(edges < -3.0 * e) {
        return record.most;
    }
    let normal = seen.normal;
    let at = on_plane(seen.picture, middle);
    let reach = half * per_texel(seen.picture);
    let slope = abs(normal.x) * reach.x + abs(normal.y) * reach.y;
    if record.pictures.faces[seen.picture].tan > 0.0 {
        // In the direction d the plane has the depth w with w (normal · d) = volume.
        let most_of = 1.0 + abs(at.x) + abs(at.y) + reach.x + reach.y;
        let greatest = seen.turn * (normal.x * at.x + normal.y * at.y + normal.z) + slope
            + seen.normal_error * most_of;
        if greatest <= 0.0 {
            return record.most;
        }
        return max(seen.depth, seen.volume / greatest * (1.0 - 4.0 * ROUNDING) * seen.scale);
    }
    // How much nearer the plane gets in the square than it is at the first corner.
    let off = at - seen.corner.xy;
    let far_off = abs(off.x) + abs(off.y) + reach.x + reach.y;
    let rise = seen.turn * (normal.x * off.x + normal.y * off.y) + slope
        + seen.normal_error * far_off + (abs(normal.x) + abs(normal.y)) * seen.depth_error;
    let forward = abs(normal.z) - seen.normal_error * select(-1.0, 1.0, rise > 0.0);
    let nearest = seen.corner.z - rise / forward - ROUNDING * abs(rise / forward);
    return max(seen.depth, nearest - seen.depth_error);
}

// A lower bound of the distance, from the light, of something at this depth that is seen
// between two texels.
fn least_distance(picture: u32, depth: f32, from_texel: vec2<f32>, to_texel: vec2<f32>) -> f32 {
    let tan = record.pictures.faces[picture].tan;
    if !(tan > 0.0) {
        return depth;
    }
    // The tangents between the two that are closest to 0.
    let low = on_plane(picture, from_texel);
    let high = on_plane(picture, to_texel);
    let closest = max(low, vec2(0.0)) + min(high, vec2(0.0));
    return max(depth, 0.0) * sqrt(1.0 + dot(closest, closest));
}

fn corner(triangle: u32, number: u32) -> vec3<f32> {
    let first = 9u * triangle + 3u * number;
    return vec3(corners[first], corners[first + 1u], corners[first + 2u]);
}

// The first cell along an axis that contains some of the texels from `low` to `high`, and the
// one behind the last.
fn cells_of(low: f32, high: f32) -> vec2<u32> {
    let last = f32(record.side - 1u);
    let per_cell = 1.0 / f32(record.cell);
    // NaN leaves it open where they are: then all cells count.
    let first = select(0.0, clamp(low * per_cell, 0.0, last), low > 0.0);
    let end = select(last, clamp(high * per_cell, 0.0, last), high < last * f32(record.cell));
    return vec2(u32(first), u32(end) + 1u);
}

// What a picture shows of a triangle.
fn look(triangle: u32, picture: u32) -> Seen {
    var seen: Seen;
    seen.picture = picture;
    let face = record.pictures.faces[picture];
    let n = f32(record.pictures.resolution);
    let half = 0.5 * n;
    let points = array(corner(triangle, 0u), corner(triangle, 1u), corner(triangle, 2u));
    // From the light's origin.
    let origin = record.pictures.faces[0].origin;
    var at = array(points[0] - origin, points[1] - origin, points[2] - origin);
    let lengths = vec3(sum_of(at[0]), sum_of(at[1]), sum_of(at[2]));
    let longest = max(max(lengths.x, lengths.y), max(lengths.z, 1e-30));
    let is_central = face.tan > 0.0;
    seen.scale = select(1.0, longest, is_central);
    var texels = array<vec3<f32>, 3>();
    var depths = vec3(0.0);
    for (var i = 0; i < 3; i++) {
        let v = at[i];
        let plane = vec2(dot(v, face.right), -dot(v, face.up));
        let z = dot(v, face.forward);
        depths[i] = z;
        if i == 0 {
            seen.corner = vec3(plane, z);
        }
        if is_central {
            texels[i] = vec3(half * (z + plane / face.tan), z) / seen.scale;
        } else {
            texels[i] = vec3(half * (1.0 + plane / vec2(face.half_width, face.half_height)), 1.0);
        }
    }
    seen.a = texels[0];
    seen.b = texels[1];
    seen.c = texels[2];
    let parts = lengths / seen.scale;
    if is_central {
        // The same again when they are moved to any texel of the picture.
        seen.texel_errors = 3.0 * ROUNDING * n * (1.0 + 1.0 / face.tan) * parts;
        seen.w_errors = 2.0 * ROUNDING * parts;
    } else {
        let narrower = min(face.half_width, face.half_height);
        seen.texel_errors = 3.0 * ROUNDING * n * (1.0 + lengths / narrower);
    }
    let extent = 0.5 * n * per_texel(picture);
    seen.depth_error = 2.0 * ROUNDING * (longest + select(extent.x + extent.y, 0.0, is_central));
    seen.depth = min(depths.x, min(depths.y, depths.z)) - seen.depth_error;

    let first = (points[1] - points[0]) / longest;
    let second = (points[2] - points[0]) / longest;
    let normal = cross(first, second);
    seen.normal = vec3(dot(normal, face.right), -dot(normal, face.up), dot(normal, face.forward));
    seen.normal_error = 4.0 * ROUNDING * sum_of(first) * sum_of(second) + 1e-36;
    var towards = seen.normal.z;
    var error = seen.normal_error;
    if is_central {
        towards = dot(normal, at[0] / longest);
        error *= lengths.x / longest;
    }
    if abs(towards) > 2.0 * error {
        seen.turn = sign(towards);
        seen.volume = abs(towards) - error;
    }

    // A triangle that is not in the picture at all has no cells.
    let middle = vec2(0.5 * f32(record.side * record.cell));
    if least_depth(seen, middle, middle.x + record.border) == record.most {
        return seen;
    }
    let w = vec3(seen.a.z, seen.b.z, seen.c.z);
    var columns = vec2(0u, record.side);
    var rows = columns;
    seen.texels = vec4(-n, -n, 2.0 * n, 2.0 * n);
    if !is_central || all(w > vec3(NEAR)) {
        let x = vec3(seen.a.x, seen.b.x, seen.c.x) / w;
        let y = vec3(seen.a.y, seen.b.y, seen.c.y) / w;
        let own = 2.0 * seen.texel_errors / w + record.border;
        let x_own = own + 2.0 * abs(x) * (seen.w_errors / w + ROUNDING);
        let y_own = own + 2.0 * abs(y) * (seen.w_errors / w + ROUNDING);
        let low = vec2(least_of(x - x_own), least_of(y - y_own));
        let high = vec2(-least_of(-x - x_own), -least_of(-y - y_own));
        seen.texels = vec4(low + record.border, high - record.border);
        columns = cells_of(low.x, high.x);
        rows = cells_of(low.y, high.y);
    }
    seen.low = vec2(columns.x, rows.x);
    seen.end = vec2(columns.y, rows.y);
    return seen;
}

fn least_of(v: vec3<f32>) -> f32 {
    return min(v.x, min(v.y, v.z));
}

// Counts a triangle in the cell with this number among those it may touch. A small triangle
// counts in each of them, at its least depth; others only where they are, at their least depth
// there.
fn count_in(seen: Seen, number: u32, is_small: bool) {
    let columns = seen.end.x - seen.low.x;
    let at = seen.low + vec2(number % columns, number / columns);
    let size = f32(record.cell);
    let middle = (vec2<f32>(at) + 0.5) * size;
    let half = 0.5 * size + record.border;
    var depth = least_distance(seen.picture, seen.depth, seen.texels.xy, seen.texels.zw);
    if !is_small {
        depth = least_depth(seen, middle, half);
        if depth == record.most {
            return;
        }
        depth = least_distance(seen.picture, depth, middle - half, middle + half);
    }
    let value = in_order(depth);
    let index = (seen.picture * record.side + at.y) * record.side + at.x;
    atomicMin(&least[index], value);
}

// Empties the finest cells. One invocation per cell.
@compute @workgroup_size(64)
fn clear(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < record.pictures.face_count * record.side * record.side {
        atomicStore(&least[i], in_order(record.most));
    }
}

// Counts the triangles in the finest cells. A workgroup takes 32 triangles of a picture, each
// by one invocation; all invocations share the cells of triangles that have many.
@compute @workgroup_size(64)
fn count(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let first = gpu_index(workgroup, workgroups, 0u, BATCH);
    let i = first + local;
    if local < BATCH && i < record.triangles * record.pictures.face_count {
        let seen = look(i % record.triangles, i / record.triangles);
        let size = seen.end - seen.low;
        let cells = size.x * size.y;
        batch[local] = seen;
        if cells <= FEW {
            for (var number = 0u; number < cells; number++) {
                count_in(seen, number, all(size <= vec2(2u)));
            }
            // Leaves nothing for the workgroup.
            batch[local].end = seen.low;
        }
    }
    workgroupBarrier();
    for (var k = 0u; k < BATCH; k++) {
        let size = batch[k].end - batch[k].low;
        let cells = size.x * size.y;
        for (var number = local; number < cells; number += GROUP) {
            count_in(batch[k], number, false);
        }
    }
}

// Writes the values of the finest level, made less by what rounding may be. One invocation
// per cell.
@compute @workgroup_size(64)
fn bound(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= record.pictures.face_count * record.side * record.side {
        return;
    }
    let depth = of_order(atomicLoad(&least[i]));
    values[i] = depth - record.factor * abs(depth) - record.less;
}

// Makes a coarser level: each value is the least of four. One invocation per cell.
@compute @workgroup_size(64)
fn lower(
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
    let upper = min(values[first], values[first + 1u]);
    let below = min(values[first + 2u * width], values[first + 2u * width + 1u]);
    values[own + index] = min(upper, below);
}

// Visibility: the lit runs of a shadow map by min–max trees; the shader's side of
// `MapRuns`.
//
// Needs the parts face.wgsl, place.wgsl, line.wgsl and fan.wgsl and the variables
//   light_runs: light_Runs
//   light_runs_depths: array<f32>, face by face, row by row
//   light_runs_nodes: array<vec2<f32>>, the trees of all slices

struct light_Runs {
    pictures: light_Pictures,
    // By picture, kind of cells and side; see light_Fan.
    fans: array<light_Fan, 24>,
    // The origin of the rays for which there are trees; others are walked texel by texel.
    eye: vec3<f32>,
    padding: u32,
}

// See `LEAST_SINE` in `fan.rs`.
const light_runs_LEAST_SINE: f32 = 4e-6;

// A node is wholly lit or dark only if it is so by more than this share of the distance,
// which covers rounding.
const light_runs_CLEAR: f32 = 1e-6;

// What the cursor does next: it enters a picture, asks a node, or walks a cell or a texel.
const light_runs_PICTURE: u32 = 0u;
const light_runs_NODE: u32 = 1u;
const light_runs_CELL: u32 = 2u;
const light_runs_TEXEL: u32 = 3u;

struct light_runs_Cursor {
    next: u32,
    // The position reached, and the end of the ray. Positions on the ray are measured from
    // the foot point.
    s: f32,
    end: f32,
    // From the light to the position 0.
    base: vec3<f32>,
    // The picture, and the part of the ray in it.
    face: u32,
    a: f32,
    b: f32,
    // Homogeneous coordinates in the picture at the position 0, and their slope:
    // along the cells, across, w.
    at: vec3<f32>,
    slope: vec3<f32>,
    // Whether cells are rows.
    is_row_major: bool,
    // The cells in which the part begins and ends.
    first: i32,
    last: i32,
    // The fan, and the index in front of that of the slice's first node.
    fan: u32,
    has_tree: bool,
    root: u32,
    // The cell at hand and the last one. With a tree, cells are counted from the side of the
    // fan, else as they are in the picture.
    number: i32,
    last_number: i32,
    // The last cell that is walked before the next node is asked.
    walked_to: i32,
    // The level of the next node; 0 is that of the leaves.
    level: u32,
    // Within a cell: where the ray leaves it, and the texels across it, the next and the last.
    cell_end: f32,
    across: i32,
    across_end: i32,
}

fn light_runs_cursor(path: light_Path) -> light_runs_Cursor {
    var cursor: light_runs_Cursor;
    let first = light_runs.pictures.faces[0];
    cursor.next = light_runs_PICTURE;
    cursor.s = path.start - path.foot;
    cursor.end = select(path.end - path.foot, light_FAR, path.end >= light_line_END);
    if first.tan > 0.0 {
        cursor.base = path.h * path.to_foot;
    } else {
        cursor.base = path.origin - first.origin;
    }
    return cursor;
}

// Coordinates in the order along the cells, across, w.
fn light_runs_turned(v: vec3<f32>, is_row_major: bool) -> vec3<f32> {
    return select(v, v.yxz, is_row_major);
}

// Finds the picture that shows what follows s, and the part of the ray in it.
fn light_runs_enter(cursor: ptr<function, light_runs_Cursor>, path: light_Path) {
    let s = (*cursor).s;
    let first = light_runs.pictures.faces[0];
    let count = light_runs.pictures.face_count;
    let ray = light_line_Ray((*cursor).base, path.direction);
    let shown = light_line_enter(first, count, ray, s, (*cursor).end);
    (*cursor).a = s;
    (*cursor).b = shown.end;
    (*cursor).face = shown.face;
}

// A coordinate of the picture at the position s: axis 0 is along the cells, 1 across.
fn light_runs_coordinate(cursor: ptr<function, light_runs_Cursor>, axis: u32, s: f32) -> f32 {
    let at = (*cursor).at;
    let slope = (*cursor).slope;
    if s < light_line_END {
        let x = at[axis] + s * slope[axis];
        let w = at.z + s * slope.z;
        if w != 0.0 {
            return x / w;
        }
        // At the light itself the ray has no place in the picture: it counts as being where it
        // goes.
        if x != 0.0 {
            return 2.0 * sign(x);
        }
    }
    if slope.z != 0.0 {
        return slope[axis] / slope.z;
    }
    if slope[axis] != 0.0 {
        return sign(slope[axis]);
    }
    return select(0.0, at[axis] / at.z, at.z != 0.0);
}

fn light_runs_cell_at(coordinate: f32) -> i32 {
    let n = f32(light_runs.pictures.resolution);
    return i32(clamp(floor(0.5 * (1.0 + coordinate) * n), 0.0, n - 1.0));
}

// The position at which the ray crosses the border in front of a cell (axis 0) or in front of
// a texel across (axis 1).
fn light_runs_border(cursor: ptr<function, light_runs_Cursor>, axis: u32, cell: i32) -> f32 {
    let n = f32(light_runs.pictures.resolution);
    let border = 2.0 * f32(cell) / n - 1.0;
    let slope = (*cursor).slope[axis] - border * (*cursor).slope.z;
    if slope == 0.0 {
        return (*cursor).b;
    }
    let s = (border * (*cursor).at.z - (*cursor).at[axis]) / slope;
    return clamp(s, (*cursor).a, (*cursor).b);
}

// The positions at which the ray enters and leaves a cell.
fn light_runs_entry(cursor: ptr<function, light_runs_Cursor>, cell: i32) -> f32 {
    if cell == (*cursor).first {
        return (*cursor).a;
    }
    return light_runs_border(cursor, 0u, cell + i32((*cursor).last < (*cursor).first));
}

fn light_runs_exit(cursor: ptr<function, light_runs_Cursor>, cell: i32) -> f32 {
    if cell == (*cursor).last {
        return (*cursor).b;
    }
    return light_runs_border(cursor, 0u, cell + i32((*cursor).first < (*cursor).last));
}

// The cell of the picture that has this number.
fn light_runs_cell_of(cursor: ptr<function, light_runs_Cursor>, number: i32) -> i32 {
    if !(*cursor).has_tree {
        return number;
    }
    let fan = (*cursor).fan;
    let from_side = number + i32(light_runs.fans[fan].first_cell);
    return light_from_side(fan, from_side, light_runs.pictures.resolution);
}

// Begins with the picture that was entered, by a tree where there is one.
fn light_runs_begin(cursor: ptr<function, light_runs_Cursor>, path: light_Path) {
    let face = light_runs.pictures.faces[(*cursor).face];
    let origin = light_runs.pictures.faces[0].origin;
    let n = light_runs.pictures.resolution;
    let at = light_line_picture(face, (*cursor).base, 1.0);
    let slope = light_line_picture(face, path.direction, 0.0);
    // The image of the ray's origin. There is a tree only if that is the eye.
    let eye = light_line_picture(face, path.origin - origin, 1.0);
    let across = cross(eye, slope);
    let is_row_major = abs(across.x) > abs(across.y);
    (*cursor).is_row_major = is_row_major;
    (*cursor).at = light_runs_turned(at, is_row_major);
    (*cursor).slope = light_runs_turned(slope, is_row_major);
    let a = (*cursor).a;
    let b = (*cursor).b;
    let first = light_runs_cell_at(light_runs_coordinate(cursor, 0u, a));
    let last = light_runs_cell_at(light_runs_coordinate(cursor, 0u, b));
    (*cursor).first = first;
    (*cursor).last = last;
    (*cursor).number = first;
    (*cursor).last_number = last;
    (*cursor).walked_to = last;
    (*cursor).has_tree = false;
    (*cursor).next = light_runs_CELL;
    let turned = light_runs_turned(eye, is_row_major);
    let along = light_runs_turned(slope, is_row_major);
    let normal = cross(turned, along);
    let most = abs(turned);
    let most_slope = abs(along);
    let scale = max(most.x, max(most.y, most.z)) * max(most_slope.x, max(most_slope.y, most_slope.z));
    if any(path.origin != light_runs.eye)
        || !(abs(normal.y) > light_runs_LEAST_SINE * f32(n) * scale) {
        return;
    }
    let middle = light_runs_coordinate(cursor, 0u, light_line_middle(a, b));
    let is_last = turned.z == 0.0 || (middle * turned.z - turned.x) * sign(turned.z) > 0.0;
    let side = select(-1.0, 1.0, is_last);
    let index = 4u * (*cursor).face + 2u * u32(is_row_major) + u32(is_last);
    let fan = light_runs.fans[index];
    let meets = -(normal.x * side + normal.z) / normal.y;
    let slice = (meets - fan.first) * fan.density;
    if fan.slices == 0u || !(slice >= 0.0 && slice < f32(fan.slices)) {
        return;
    }
    let number = vec2(light_from_side(index, first, n), light_from_side(index, last, n))
        - i32(fan.first_cell);
    let reach = 1i << (fan.height + light_LEAF);
    if any(number < vec2(0)) || any(number >= vec2(reach)) {
        return;
    }
    (*cursor).has_tree = true;
    (*cursor).fan = index;
    (*cursor).root = fan.nodes + min(u32(slice), fan.slices - 1u) * (2u << fan.height);
    (*cursor).number = number.x;
    (*cursor).last_number = number.y;
    // The smallest node that contains all of the part.
    let differs = u32(number.x ^ number.y) >> light_LEAF;
    (*cursor).level = 32u - countLeadingZeros(differs);
    (*cursor).next = light_runs_NODE;
}

// Whether the part from a to b is lit (1) or dark (0) if the depths of its texels are within
// those of a node; −1 if that does not decide it.
fn light_runs_verdict(
    cursor: ptr<function, light_runs_Cursor>,
    path: light_Path,
    node: vec2<f32>,
    a: f32,
    b: f32,
) -> i32 {
    if node.x == light_EMPTY {
        return 1;
    }
    let first = light_runs.pictures.faces[0];
    var near: f32;
    var far: f32;
    if first.tan > 0.0 {
        far = light_FAR;
        if b < light_line_END {
            far = length(vec2(path.h, max(abs(a), abs(b))));
        }
        var s = 0.0;
        if !(a <= 0.0 && 0.0 <= b) {
            s = min(abs(a), abs(b));
        }
        near = length(vec2(path.h, s));
    } else {
        let base = dot((*cursor).base, first.forward);
        let slope = dot(path.direction, first.forward);
        let start = base + a * slope;
        var end = base + min(b, light_line_END) * slope;
        near = min(start, end);
        far = max(start, end);
        let clear = light_runs_CLEAR * (abs(base) + abs(start));
        near -= clear;
        far += clear;
    }
    if far + light_runs_CLEAR * abs(far) <= node.x {
        return 1;
    }
    if node.y < light_EMPTY && near - light_runs_CLEAR * abs(near) > node.y {
        return 0;
    }
    return -1;
}

// The part from a to b that is no deeper than a texel.
fn light_runs_up_to(
    cursor: ptr<function, light_runs_Cursor>,
    path: light_Path,
    texel: f32,
    a: f32,
    b: f32,
) -> vec2<f32> {
    if texel == light_EMPTY {
        return vec2(a, b);
    }
    let first = light_runs.pictures.faces[0];
    if first.tan > 0.0 {
        if texel < path.h {
            return vec2(a);
        }
        let half = sqrt((texel - path.h) * (texel + path.h));
        return vec2(max(a, -half), min(b, half));
    }
    let rest = texel - dot((*cursor).base, first.forward);
    let slope = dot(path.direction, first.forward);
    if slope > 0.0 {
        return vec2(a, min(b, rest / slope));
    }
    if slope < 0.0 {
        return vec2(max(a, rest / slope), b);
    }
    return vec2(a, select(a, b, rest >= 0.0));
}

// The part from a to b as a lit part, in distances along the ray.
fn light_runs_part(path: light_Path, a: f32, b: f32) -> light_Lit {
    let end = select(b + path.foot, path.end, b >= light_line_END);
    return light_lit(max(a + path.foot, path.start), min(end, path.end), 1.0);
}

fn light_runs_next_lit(cursor: ptr<function, light_runs_Cursor>, path: light_Path) -> light_Lit {
    var now = *cursor;
    var found = light_dark();
    loop {
        var lit = vec2(0.0);
        if now.next == light_runs_PICTURE {
            if !(now.s < now.end) {
                break;
            }
            light_runs_enter(&now, path);
            if now.face == light_line_NO_PICTURE {
                lit = vec2(now.a, now.b);
                now.s = now.b;
            } else {
                light_runs_begin(&now, path);
            }
        } else if now.next == light_runs_NODE {
            let is_rising = now.number <= now.last_number;
            let shift = now.level + light_LEAF;
            let index = now.number >> shift;
            var end_number: i32;
            if is_rising {
                end_number = min(((index + 1) << shift) - 1, now.last_number);
            } else {
                end_number = max(index << shift, now.last_number);
            }
            let end = light_runs_exit(&now, light_runs_cell_of(&now, end_number));
            let leaves = 1u << light_runs.fans[now.fan].height;
            let node = light_runs_nodes[now.root + (leaves >> now.level) + u32(index)];
            let verdict = light_runs_verdict(&now, path, node, now.s, end);
            if verdict >= 0 {
                lit = select(vec2(0.0), vec2(now.s, end), verdict == 1);
                now.s = end;
                light_runs_advance(&now, end_number);
            } else if now.level > 0u {
                now.level -= 1u;
            } else {
                now.walked_to = end_number;
                now.next = light_runs_CELL;
            }
        } else if now.next == light_runs_CELL {
            let cell = light_runs_cell_of(&now, now.number);
            now.s = light_runs_entry(&now, cell);
            now.cell_end = max(light_runs_exit(&now, cell), now.s);
            now.across = light_runs_cell_at(light_runs_coordinate(&now, 1u, now.s));
            now.across_end = light_runs_cell_at(light_runs_coordinate(&now, 1u, now.cell_end));
            now.next = light_runs_TEXEL;
        } else {
            let cell = light_runs_cell_of(&now, now.number);
            let step = select(-1, 1, now.across <= now.across_end);
            let is_last = now.across == now.across_end;
            var end = now.cell_end;
            if !is_last {
                let border = light_runs_border(&now, 1u, now.across + i32(step > 0));
                end = clamp(border, now.s, now.cell_end);
            }
            let at = select(vec2(cell, now.across), vec2(now.across, cell), now.is_row_major);
            let side = light_runs.pictures.resolution;
            let texel = light_runs_depths[(now.face * side + u32(at.y)) * side + u32(at.x)];
            lit = light_runs_up_to(&now, path, texel, now.s, end);
            now.s = end;
            now.across += step;
            if is_last {
                light_runs_walked(&now);
            }
        }
        if lit.x < lit.y {
            found = light_runs_part(path, lit.x, lit.y);
            if found.start < found.end {
                break;
            }
            found = light_dark();
        }
    }
    *cursor = now;
    return found;
}

// Goes on behind a node or a leaf that ends with the cell `end_number`.
fn light_runs_advance(cursor: ptr<function, light_runs_Cursor>, end_number: i32) {
    let last = (*cursor).last_number;
    if end_number == last {
        (*cursor).s = (*cursor).b;
        (*cursor).next = light_runs_PICTURE;
        return;
    }
    let is_rising = (*cursor).number <= last;
    let number = end_number + select(-1, 1, is_rising);
    (*cursor).number = number;
    // The largest node that begins here; those that contain it are known to be mixed.
    let leaf = u32(number) >> light_LEAF;
    let level = countTrailingZeros(select(leaf + 1u, leaf, is_rising));
    (*cursor).level = min(level, light_runs.fans[(*cursor).fan].height);
    (*cursor).next = light_runs_NODE;
}

// Goes on behind a cell that was walked.
fn light_runs_walked(cursor: ptr<function, light_runs_Cursor>) {
    let number = (*cursor).number;
    if number == (*cursor).walked_to {
        if (*cursor).has_tree {
            light_runs_advance(cursor, number);
        } else {
            (*cursor).s = (*cursor).b;
            (*cursor).next = light_runs_PICTURE;
        }
        return;
    }
    (*cursor).number = number + select(-1, 1, number <= (*cursor).last_number);
    (*cursor).next = light_runs_CELL;
}

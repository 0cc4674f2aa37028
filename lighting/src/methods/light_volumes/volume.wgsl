// Visibility: the lit runs of a light volume; the shader's side of `LightVolume`.
//
// Needs the parts face.wgsl, place.wgsl, line.wgsl and mesh.wgsl and the variables
//   light_volume: light_Volume
//   light_volume_heights: array<f32>, of the vertices, face by face, row by row
//   light_volume_nodes: array<vec2<f32>>, see level.wgsl

struct light_Volume {
    pictures: light_Pictures,
    mesh: light_volume_Layout,
}

// Rays end at this position at the latest.
const light_volume_FARTHEST: f32 = 1e18;

// What the cursor does next: it enters a picture, asks a node, or takes a piece of a patch.
const light_volume_PICTURE: u32 = 0u;
const light_volume_NODE: u32 = 1u;
const light_volume_PIECE: u32 = 2u;

struct light_volume_Cursor {
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
    // Homogeneous coordinates at the position 0, in cells, and their slope; the height of
    // the ray times w, and its slope.
    at: vec3<f32>,
    slope: vec3<f32>,
    height: vec2<f32>,
    // The cell at s, the last one, and the level of the node to be asked.
    cell: vec2<i32>,
    last: vec2<i32>,
    level: u32,
    // A square of cells, where the ray leaves it along each axis, and the first of these.
    origin: vec2<i32>,
    exits: vec2<f32>,
    exit: f32,
    // The surface over it, and where the ray crosses from one piece of it to another.
    kind: u32,
    corners: vec4<f32>,
    splits: vec2<f32>,
}

fn light_volume_cursor(path: light_Path) -> light_volume_Cursor {
    var cursor: light_volume_Cursor;
    let first = light_volume.pictures.faces[0];
    cursor.next = light_volume_PICTURE;
    cursor.s = path.start - path.foot;
    let farthest = max(light_volume_FARTHEST, 4.0 * abs(cursor.s));
    cursor.end = min(min(path.end, light_line_END) - path.foot, farthest);
    if first.tan > 0.0 {
        cursor.base = path.h * path.to_foot;
        cursor.height = vec2(-1.0, 0.0);
    } else {
        cursor.base = path.origin - first.origin;
        cursor.height = vec2(dot(cursor.base, first.forward), dot(path.direction, first.forward));
    }
    return cursor;
}

fn light_volume_node(face: u32, level: u32, at: vec2<i32>) -> vec2<f32> {
    let side = light_volume_side(light_volume.mesh.resolution, level);
    let first = light_volume.mesh.first[level / 4u][level % 4u];
    return light_volume_nodes[first + (face * side + u32(at.y)) * side + u32(at.x)];
}

fn light_volume_height(face: u32, cell: vec2<i32>) -> f32 {
    return light_volume_heights[light_volume_vertex(light_volume.mesh.resolution, face, cell)];
}

// The cell at a position.
fn light_volume_cell(cursor: ptr<function, light_volume_Cursor>, s: f32) -> vec2<i32> {
    let at = (*cursor).at + s * (*cursor).slope;
    var place: vec2<f32>;
    if at.z > 0.0 {
        place = at.xy / at.z;
    } else if (*cursor).slope.z != 0.0 && all(at.xy == vec2(0.0)) {
        // At the light itself the ray counts as being where it goes.
        place = (*cursor).slope.xy / (*cursor).slope.z;
    } else {
        place = light_FAR * sign(at.xy);
    }
    let side = f32(light_volume.mesh.resolution);
    return vec2<i32>(clamp(floor(place), vec2(0.0), vec2(side)));
}

// Where a x + b y + c is 0 along the ray, with x and y in cells; −light_FAR if it never is.
fn light_volume_crossing(cursor: ptr<function, light_volume_Cursor>, line: vec3<f32>) -> f32 {
    let slope = dot(line, (*cursor).slope);
    if slope == 0.0 {
        return -light_FAR;
    }
    return -dot(line, (*cursor).at) / slope;
}

// The position at which the ray leaves a square of cells along an axis.
fn light_volume_exit(
    cursor: ptr<function, light_volume_Cursor>,
    axis: u32,
    origin: i32,
    size: i32,
) -> f32 {
    let last = (*cursor).last[axis];
    if last >= origin && last < origin + size {
        return (*cursor).b;
    }
    let border = f32(select(origin + size, origin, last < origin));
    let slope = (*cursor).slope[axis] - border * (*cursor).slope.z;
    if slope == 0.0 {
        return (*cursor).b;
    }
    let s = (border * (*cursor).at.z - (*cursor).at[axis]) / slope;
    return clamp(s, (*cursor).a, (*cursor).b);
}

// Begins with the picture that was entered.
fn light_volume_begin(cursor: ptr<function, light_volume_Cursor>, path: light_Path) {
    let face = light_volume.pictures.faces[(*cursor).face];
    let n = f32(light_volume.mesh.resolution);
    let at = light_line_picture(face, (*cursor).base, 1.0);
    let slope = light_line_picture(face, path.direction, 0.0);
    (*cursor).at = vec3(0.5 * (n * (at.z + at.xy) + at.z), at.z);
    (*cursor).slope = vec3(0.5 * (n * (slope.z + slope.xy) + slope.z), slope.z);
    let first = light_volume_cell(cursor, (*cursor).a);
    let last = light_volume_cell(cursor, (*cursor).b);
    (*cursor).cell = first;
    (*cursor).last = last;
    // The smallest node that contains the whole part, or the patch that contains that.
    let differ = u32((first.x ^ last.x) | (first.y ^ last.y));
    var level = max(32u - countLeadingZeros(differ), 1u);
    while level < light_volume.mesh.levels {
        let node = light_volume_node((*cursor).face, level + 1u, first >> vec2(level + 1u));
        if node.x < node.y {
            break;
        }
        level += 1u;
    }
    (*cursor).level = level;
    (*cursor).next = light_volume_NODE;
}

// How far in front of a plane over the square the ray is, times w, which is linear in s.
fn light_volume_before(
    cursor: ptr<function, light_volume_Cursor>,
    plane: vec3<f32>,
    s: f32,
) -> f32 {
    let at = (*cursor).at + s * (*cursor).slope;
    let inside = at.xy - vec2<f32>((*cursor).origin) * at.z;
    let height = (*cursor).height.x + s * (*cursor).height.y;
    return plane.x * at.z + dot(plane.yz, inside) - height;
}

// Goes on behind the square.
fn light_volume_advance(cursor: ptr<function, light_volume_Cursor>) {
    let exits = (*cursor).exits;
    let b = (*cursor).b;
    if all(exits == vec2(b)) {
        (*cursor).s = b;
        (*cursor).next = light_volume_PICTURE;
        return;
    }
    let step = u32(exits.y < exits.x);
    let other = 1u - step;
    let origin = (*cursor).origin;
    let size = 1i << (*cursor).level;
    let is_falling = (*cursor).last[step] < origin[step];
    let old = select(origin[step] + size - 1, origin[step], is_falling);
    let beyond = select(old + 1, old - 1, is_falling);
    // Along the other axis it goes on, but no farther than the square or the end.
    let now = (*cursor).cell[other];
    let last = (*cursor).last[other];
    let across = light_volume_cell(cursor, (*cursor).exit)[other];
    var next = max(min(across, now), max(last, origin[other]));
    if now <= last {
        next = min(max(across, now), min(last, origin[other] + size - 1));
    }
    (*cursor).cell = select(vec2(beyond, next), vec2(next, beyond), step == 1u);
    // The largest node that begins here; those that contain it are known to be mixed.
    (*cursor).level = 31u - countLeadingZeros(u32(old ^ beyond));
    (*cursor).s = (*cursor).exit;
    (*cursor).next = light_volume_NODE;
}

// Asks the node that the ray is in; returns the ray's part in it if all of it is lit, else an
// empty part.
fn light_volume_look(cursor: ptr<function, light_volume_Cursor>) -> vec2<f32> {
    let level = (*cursor).level;
    let face = (*cursor).face;
    let s = (*cursor).s;
    let size = 1i << level;
    let index = (*cursor).cell >> vec2(level);
    let origin = index << vec2(level);
    (*cursor).origin = origin;
    let exits = vec2(
        light_volume_exit(cursor, 0u, origin.x, size),
        light_volume_exit(cursor, 1u, origin.y, size),
    );
    (*cursor).exits = exits;
    let exit = max(min(exits.x, exits.y), s);
    (*cursor).exit = exit;
    if level > 0u {
        let node = light_volume_node(face, level, index);
        if node.x < node.y {
            if node.x == light_EMPTY || light_volume_is_before(cursor, node.x, s, exit) {
                light_volume_advance(cursor);
                return vec2(s, exit);
            }
            if node.y < light_EMPTY && light_volume_is_behind(cursor, node.y, s, exit) {
                light_volume_advance(cursor);
            } else {
                (*cursor).level = level - 1u;
            }
            return vec2(0.0);
        }
    }
    let corners = vec4(
        light_volume_height(face, origin),
        light_volume_height(face, origin + vec2(size, 0)),
        light_volume_height(face, origin + vec2(0, size)),
        light_volume_height(face, origin + size),
    );
    let least = min(min(corners.x, corners.y), min(corners.z, corners.w));
    let greatest = max(max(corners.x, corners.y), max(corners.z, corners.w));
    if least == light_EMPTY {
        light_volume_advance(cursor);
        return vec2(s, exit);
    }
    let x = f32(origin.x);
    let y = f32(origin.y);
    var kind = light_volume_WALL;
    if greatest < light_EMPTY {
        let steep = light_volume_STEEP * light_volume_width(light_volume.mesh.width, greatest);
        if level > 0u || greatest - least <= steep {
            kind = light_volume_triangles(corners);
        }
    }
    var splits = vec2(-light_FAR);
    if kind == light_volume_WALL {
        splits.x = light_volume_crossing(cursor, vec3(1.0, 0.0, -(x + 0.5)));
        splits.y = light_volume_crossing(cursor, vec3(0.0, 1.0, -(y + 0.5)));
    } else if kind == light_volume_FALLING {
        splits.x = light_volume_crossing(cursor, vec3(1.0, -1.0, y - x));
    } else {
        splits.x = light_volume_crossing(cursor, vec3(1.0, 1.0, -(x + y + f32(size))));
    }
    (*cursor).kind = kind;
    (*cursor).corners = corners;
    (*cursor).splits = splits;
    (*cursor).next = light_volume_PIECE;
    return vec2(0.0);
}

// Whether all of a part is in front of a height, or at it.
fn light_volume_is_before(
    cursor: ptr<function, light_volume_Cursor>,
    height: f32,
    a: f32,
    b: f32,
) -> bool {
    let plane = vec3(height, 0.0, 0.0);
    return light_volume_before(cursor, plane, a) >= 0.0
        && light_volume_before(cursor, plane, b) >= 0.0;
}

// Whether all of a part is behind a height.
fn light_volume_is_behind(
    cursor: ptr<function, light_volume_Cursor>,
    height: f32,
    a: f32,
    b: f32,
) -> bool {
    let plane = vec3(height, 0.0, 0.0);
    return light_volume_before(cursor, plane, a) < 0.0
        && light_volume_before(cursor, plane, b) < 0.0;
}

// The lit part of the next piece of a patch.
fn light_volume_piece(cursor: ptr<function, light_volume_Cursor>) -> vec2<f32> {
    let s = (*cursor).s;
    let splits = (*cursor).splits;
    let size = f32(1i << (*cursor).level);
    var next = (*cursor).exit;
    next = select(next, splits.x, s < splits.x && splits.x < next);
    next = select(next, splits.y, s < splits.y && splits.y < next);
    let middle = (*cursor).at + (0.5 * (s + next)) * (*cursor).slope;
    let inside = (middle.xy / middle.z - vec2<f32>((*cursor).origin)) / size;
    var plane = light_volume_plane((*cursor).kind, (*cursor).corners, inside);
    var lit = vec2(s, next);
    if plane.x < light_EMPTY {
        plane = vec3(plane.x, plane.yz / size);
        let g = light_volume_before(cursor, plane, s);
        let h = light_volume_before(cursor, plane, next);
        if g < 0.0 && h < 0.0 {
            lit = vec2(s);
        } else if g < 0.0 || h < 0.0 {
            let crossing = clamp(s + (next - s) * (g / (g - h)), s, next);
            lit = select(vec2(s, crossing), vec2(crossing, next), g < 0.0);
        }
    }
    (*cursor).s = next;
    if !(next < (*cursor).exit) {
        light_volume_advance(cursor);
    }
    return lit;
}

fn light_volume_next_lit(
    cursor: ptr<function, light_volume_Cursor>,
    path: light_Path,
) -> light_Lit {
    var now = *cursor;
    var found = light_dark();
    loop {
        var lit = vec2(0.0);
        if now.next == light_volume_PICTURE {
            if !(now.s < now.end) {
                break;
            }
            let pictures = light_volume.pictures.face_count;
            let ray = light_line_Ray(now.base, path.direction);
            let first = light_volume.pictures.faces[0];
            let shown = light_line_enter(first, pictures, ray, now.s, now.end);
            now.face = shown.face;
            now.a = now.s;
            now.b = shown.end;
            if shown.face == light_line_NO_PICTURE {
                lit = vec2(now.a, now.b);
                now.s = now.b;
            } else {
                light_volume_begin(&now, path);
            }
        } else if now.next == light_volume_NODE {
            lit = light_volume_look(&now);
        } else {
            lit = light_volume_piece(&now);
        }
        if lit.x < lit.y {
            let end = select(lit.y + path.foot, path.end, lit.y >= now.end);
            found = light_lit(max(lit.x + path.foot, path.start), min(end, path.end), 1.0);
            if found.start < found.end {
                break;
            }
            found = light_dark();
        }
    }
    *cursor = now;
    return found;
}

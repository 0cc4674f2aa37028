// Visibility: a march that asks a shadow map only where a ray is in shadow volumes; the
// shader's side of `Hybrid`.
//
// Needs the parts face.wgsl, place.wgsl and map.wgsl, the slot of what is asked,
//   fn light_point_visibility(point: vec3<f32>) -> vec3<f32>
// and the variables
//   light_hybrid: light_Hybrid
//   light_hybrid_near: array<f32>, least depths, the finest level first, each picture
//       by picture, row by row

struct light_Hybrid {
    steps: u32,
    // Texels per side of a finest cell, finest cells per side; none: all of every ray
    // is marched.
    cell: u32,
    side: u32,
    padding: u32,
}

// See `search.rs`.
const light_hybrid_PAST: f32 = 2e-6;
const light_hybrid_MOST_PICTURES: u32 = 16u;
const light_hybrid_MOST_TURNS: u32 = 4096u;
const light_hybrid_START: u32 = 2u;

// See `mod.rs`.
const light_hybrid_HALVINGS: u32 = 3u;

// See `asking.rs`.
const light_hybrid_LEAP: u32 = 24u;

struct light_hybrid_Cursor {
    start: f32,
    end: f32,
    // The next step, and the one after the last that is asked about: those from there
    // on are lit.
    next: u32,
    last: u32,
    lit_in_a_row: u32,
    leap: u32,
    was_lit: bool,
    // Where the run that is open begins.
    lit_from: f32,
}

// A ray as the light sees it; positions on it are measured from its foot point.
struct light_hybrid_Line {
    base: vec3<f32>,
    direction: vec3<f32>,
    h: f32,
    // Distance from the eye at the position 0.
    foot: f32,
}

// How far rounding may take a position.
fn light_hybrid_past(line: light_hybrid_Line, s: f32) -> f32 {
    return light_hybrid_PAST * (abs(s) + line.h) + 1e-20;
}

// Homogeneous texels of the light's origin plus v; of a direction if w is 0.
fn light_hybrid_texels(face: light_Face, v: vec3<f32>, w: f32) -> vec3<f32> {
    let half = 0.5 * f32(light_map.resolution);
    let x = dot(v, face.right);
    let y = -dot(v, face.up);
    if face.tan > 0.0 {
        let z = dot(v, face.forward);
        return vec3(half * (z + x / face.tan), half * (z + y / face.tan), z);
    }
    return vec3(half * (w + x / face.half_width), half * (w + y / face.half_height), w);
}

// The part of start to end where base + s slope is not negative.
fn light_hybrid_clip(base: f32, slope: f32, part: vec2<f32>) -> vec2<f32> {
    if slope > 0.0 {
        return vec2(max(part.x, -base / slope), part.y);
    }
    if slope < 0.0 {
        return vec2(part.x, min(part.y, -base / slope));
    }
    return select(part, part.xx, base < 0.0);
}

fn light_hybrid_least(picture: u32, level: u32, cell: vec2<u32>) -> f32 {
    let side = light_hybrid.side;
    let width = side >> level;
    let before = 4u * (side * side - width * width) / 3u * light_map.face_count;
    return light_hybrid_near[before + (picture * width + cell.y) * width + cell.x];
}

// The first position from `s` to `exit` that is farther away than `near`;
// light_FAR if there is none. `depth` is that at the position 0 in parallel light, and
// its slope.
fn light_hybrid_entry(
    line: light_hybrid_Line,
    is_central: bool,
    depth: vec2<f32>,
    near: f32,
    s: f32,
    exit: f32,
) -> f32 {
    if is_central {
        let least = max(near, 0.0);
        let square = least * least - line.h * line.h;
        if s * s > square {
            return s;
        }
        return select(light_FAR, clamp(sqrt(square), s, exit), exit * exit > square);
    }
    if depth.x + s * depth.y > near {
        return s;
    }
    if depth.x + exit * depth.y > near {
        return clamp((near - depth.x) / depth.y, s, exit);
    }
    return light_FAR;
}

// The first position within a picture that may be in shadow; light_FAR if there is
// none.
fn light_hybrid_first_in(
    line: light_hybrid_Line,
    picture: u32,
    at: vec3<f32>,
    slope: vec3<f32>,
    part: vec2<f32>,
    shortest: f32,
) -> f32 {
    let face = light_map.faces[picture];
    let is_central = face.tan > 0.0;
    let depth = vec2(dot(line.base, face.forward), dot(line.direction, face.forward));
    let rises = slope.xy * at.z - at.xy * slope.z >= vec2(0.0);
    let after = select(vec2(0u), vec2(1u), rises);
    let top = firstLeadingBit(light_hybrid.side);
    var level = top - min(top, light_hybrid_START);
    var s = part.x;
    for (var turn = 0u; turn < light_hybrid_MOST_TURNS; turn++) {
        if !(s < part.y) {
            return light_FAR;
        }
        let width = light_hybrid.side >> level;
        let size = f32(light_hybrid.cell << level);
        let here = at + s * slope;
        // At the light itself anywhere.
        let place = clamp(here.xy / (here.z * size), vec2(0.0), vec2(f32(width) - 0.5));
        let cell = min(vec2<u32>(place), vec2(width - 1u));
        let texel = size * vec2<f32>(cell + after);
        let towards = slope.xy - texel * slope.z;
        // Borders along the line or beyond its vanishing point are never met, and where the
        // picture ends so does the part. One that is right here is met, whatever rounding
        // says.
        let ahead = select(-towards, towards, rises);
        let number = cell + after;
        let is_met = (ahead > vec2(0.0)) & (number > vec2(0u)) & (number < vec2(width));
        let crossings = max((texel * at.z - at.xy) / towards, vec2(s));
        let borders = select(vec2(light_FAR), crossings, is_met);
        let exit = min(min(borders.x, borders.y), part.y);
        let near = light_hybrid_least(picture, level, cell);
        let entry = light_hybrid_entry(line, is_central, depth, near, s, exit);
        if entry == light_FAR {
            s = exit + light_hybrid_past(line, exit);
            let crossed = select(number.x, number.y, borders.y < borders.x);
            if crossed % 2u == 0u && level < top {
                level += 1u;
            }
            continue;
        }
        s = entry;
        if level == 0u || exit - s <= shortest {
            return s;
        }
        level -= 1u;
    }
    return s;
}

// The first position of a part of a line that may be in shadow; light_FAR if there is
// none.
fn light_hybrid_first(line: light_hybrid_Line, part: vec2<f32>, shortest: f32) -> f32 {
    let last = f32(light_map.resolution) + 1.0;
    var s = part.x;
    for (var turn = 0u; turn < light_hybrid_MOST_PICTURES; turn++) {
        if !(s < part.y) {
            return light_FAR;
        }
        let past = s + light_hybrid_past(line, s);
        let picture = light_face_along(light_map.face_count, line.base + past * line.direction);
        let face = light_map.faces[picture];
        let at = light_hybrid_texels(face, line.base, 1.0);
        let slope = light_hybrid_texels(face, line.direction, 0.0);
        var inside = vec2(s, part.y);
        // And a texel around it: what is on its border may be rounded to either side.
        inside = light_hybrid_clip(at.x + at.z, slope.x + slope.z, inside);
        inside = light_hybrid_clip(at.y + at.z, slope.y + slope.z, inside);
        inside = light_hybrid_clip(last * at.z - at.x, last * slope.z - slope.x, inside);
        inside = light_hybrid_clip(last * at.z - at.y, last * slope.z - slope.y, inside);
        if inside.x < inside.y {
            let found = light_hybrid_first_in(line, picture, at, slope, inside, shortest);
            if found != light_FAR {
                return found;
            }
        }
        if light_map.face_count == 1u {
            return light_FAR;
        }
        s = max(inside.y, past);
    }
    return s;
}

fn light_hybrid_middle(cursor: light_hybrid_Cursor, i: u32) -> f32 {
    let t = (f32(i) + 0.5) / f32(light_hybrid.steps);
    return cursor.start + t * (cursor.end - cursor.start);
}

fn light_hybrid_line(path: light_Path) -> light_hybrid_Line {
    let v = path.origin - light_map.faces[0].origin;
    var line: light_hybrid_Line;
    line.base = cross(path.direction, cross(v, path.direction));
    line.direction = path.direction;
    line.h = length(line.base);
    line.foot = -dot(v, path.direction);
    return line;
}

// The number, and a part of one, of the step at a position.
fn light_hybrid_number(cursor: light_hybrid_Cursor, line: light_hybrid_Line, s: f32) -> f32 {
    let steps = f32(light_hybrid.steps);
    return (s + line.foot - cursor.start) / (cursor.end - cursor.start) * steps;
}

// The number of the first step with its middle at a position or behind it.
fn light_hybrid_step_from(cursor: light_hybrid_Cursor, line: light_hybrid_Line, s: f32) -> u32 {
    let front = s - light_hybrid_past(line, s) - light_hybrid_PAST * abs(line.foot);
    let number = ceil(light_hybrid_number(cursor, line, front) - 0.5);
    return u32(clamp(number, 0.0, f32(light_hybrid.steps)));
}

fn light_hybrid_step_length(cursor: light_hybrid_Cursor) -> f32 {
    return (cursor.end - cursor.start) / f32(light_hybrid.steps);
}

fn light_hybrid_cursor(path: light_Path) -> light_hybrid_Cursor {
    var cursor: light_hybrid_Cursor;
    let steps = light_hybrid.steps;
    cursor.start = path.start;
    cursor.end = min(path.end, path.start + light_medium().far_end);
    cursor.lit_from = cursor.start;
    cursor.was_lit = true;
    cursor.last = steps;
    cursor.leap = light_hybrid_LEAP;
    if light_hybrid.side == 0u {
        return cursor;
    }
    var line = light_hybrid_line(path);
    let step = light_hybrid_step_length(cursor);
    let ends = vec2(cursor.start, cursor.end) - line.foot;
    let front = light_hybrid_first(line, ends, step);
    var back = light_FAR;
    if front != light_FAR {
        line.direction = -line.direction;
        back = light_hybrid_first(line, vec2(-ends.y, -front), step);
    }
    // None of the steps is asked about.
    if back == light_FAR {
        cursor.next = steps;
        return cursor;
    }
    cursor.next = light_hybrid_step_from(cursor, line, front);
    let end = -back + light_hybrid_past(line, back) + light_hybrid_PAST * abs(line.foot);
    let last = floor(light_hybrid_number(cursor, line, end) + 0.5);
    cursor.last = u32(clamp(last, 0.0, f32(steps)));
    return cursor;
}

// Past steps that are lit, after so many in a row that it pays to look for where the next
// volume begins; `x` is the middle of the last of them.
fn light_hybrid_leap(cursor: ptr<function, light_hybrid_Cursor>, path: light_Path, x: f32) {
    let line = light_hybrid_line(path);
    let ends = vec2(x, (*cursor).end) - line.foot;
    let front = light_hybrid_first(line, ends, light_hybrid_step_length(*cursor));
    var first = (*cursor).last;
    if front != light_FAR {
        first = light_hybrid_step_from(*cursor, line, front);
    }
    if first < (*cursor).next + light_hybrid_LEAP {
        (*cursor).leap *= 2u;
    }
    (*cursor).next = min(max((*cursor).next, first), (*cursor).last);
    (*cursor).lit_in_a_row = 0u;
}

fn light_hybrid_is_lit(path: light_Path, x: f32) -> bool {
    return light_point_visibility(path.origin + x * path.direction).x > 0.0;
}

// Where the light changes between the middles of two steps.
fn light_hybrid_border(path: light_Path, first: f32, second: f32, was_lit: bool) -> f32 {
    var before = first;
    var after = second;
    for (var i = 0u; i < light_hybrid_HALVINGS; i++) {
        let x = 0.5 * (before + after);
        if light_hybrid_is_lit(path, x) == was_lit {
            before = x;
        } else {
            after = x;
        }
    }
    return 0.5 * (before + after);
}

fn light_hybrid_next_lit(
    cursor: ptr<function, light_hybrid_Cursor>,
    path: light_Path,
) -> light_Lit {
    let steps = light_hybrid.steps;
    while (*cursor).next < min((*cursor).last + 1u, steps) {
        let i = (*cursor).next;
        (*cursor).next = i + 1u;
        let x = light_hybrid_middle(*cursor, i);
        let was_lit = (*cursor).was_lit;
        let is_lit = i >= (*cursor).last || light_hybrid_is_lit(path, x);
        (*cursor).lit_in_a_row = select(0u, (*cursor).lit_in_a_row + 1u, is_lit);
        let may_leap = light_hybrid.side > 0u && i < (*cursor).last;
        if may_leap && (*cursor).lit_in_a_row >= (*cursor).leap {
            light_hybrid_leap(cursor, path, x);
        }
        if is_lit == was_lit {
            continue;
        }
        (*cursor).was_lit = is_lit;
        if i == 0u {
            continue;
        }
        let border = light_hybrid_border(path, light_hybrid_middle(*cursor, i - 1u), x, was_lit);
        if is_lit {
            (*cursor).lit_from = border;
        } else if (*cursor).lit_from < border {
            return light_lit((*cursor).lit_from, border, 1.0);
        }
    }
    if (*cursor).was_lit && (*cursor).lit_from < (*cursor).end {
        (*cursor).was_lit = false;
        return light_lit((*cursor).lit_from, (*cursor).end, 1.0);
    }
    return light_dark();
}

// Which steps of a ray have to ask the shadow map, by volumes of shadow and of light.
//
// Needs the parts face.wgsl and place.wgsl, the variables
//   light_map: light_Pictures
//   light_hybrid: light_Hybrid
// and
//   fn light_hybrid_stored(of_light: bool, index: u32) -> f32
// for the least depths of shadow or the greatest ones of light, the finest level first, each
// level picture by picture and row by row. It is only called for volumes that exist.

struct light_Hybrid {
    steps: u32,
    // Texels per side of a finest cell, and finest cells per side; 0 if the whole of every ray
    // is marched.
    cell: u32,
    side: u32,
    // Whether steps are spread over the span between the volumes instead of the whole ray.
    by_span: u32,
    has_shadow: u32,
    has_light: u32,
    padding_a: u32,
    padding_b: u32,
}

// See `search.rs`.
const light_hybrid_PAST: f32 = 2e-6;
const light_hybrid_MOST_PICTURES: u32 = 16u;
const light_hybrid_MOST_TURNS: u32 = 4096u;
const light_hybrid_START: u32 = 2u;

// See `asking.rs`.
const light_hybrid_LEAP: u32 = 24u;
const light_hybrid_SHORT: f32 = 0.25;

struct light_hybrid_Cursor {
    // Where the ray ends, and the part of it over which steps are spread.
    end: f32,
    part: vec2<f32>,
    // Cells that are no longer than this along the ray are not divided.
    shortest: f32,
    // The next step, and the first from which on steps do not ask.
    next: u32,
    last: u32,
    // How many steps in a row had the same result, and from how many on it pays to search for
    // the next volume.
    alike: u32,
    leap: u32,
    was_lit: bool,
    // Whether the ray is lit behind the last step that asks.
    is_lit_behind: bool,
    // Where the run at hand begins.
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

// How far off rounding may put a position.
fn light_hybrid_past(line: light_hybrid_Line, s: f32) -> f32 {
    return light_hybrid_PAST * (abs(s) + line.h) + 1e-20;
}

// The same for a distance from the eye.
fn light_hybrid_margin(line: light_hybrid_Line, s: f32) -> f32 {
    return light_hybrid_past(line, s) + light_hybrid_PAST * abs(line.foot);
}

// Homogeneous texels of the light's origin plus v; of the direction v if w is 0.
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

// The part of an interval where base + s slope is not negative.
fn light_hybrid_clip(base: f32, slope: f32, part: vec2<f32>) -> vec2<f32> {
    if slope > 0.0 {
        return vec2(max(part.x, -base / slope), part.y);
    }
    if slope < 0.0 {
        return vec2(part.x, min(part.y, -base / slope));
    }
    return select(part, part.xx, base < 0.0);
}

// The value of a cell of volumes of light or of shadow.
fn light_hybrid_value(of_light: bool, picture: u32, level: u32, cell: vec2<u32>) -> f32 {
    let side = light_hybrid.side;
    let width = side >> level;
    let before = 4u * (side * side - width * width) / 3u * light_map.face_count;
    return light_hybrid_stored(of_light, before + (picture * width + cell.y) * width + cell.x);
}

// The first position from `s` to `exit` that is farther from the light than `value`, or for
// volumes of light no farther; light_FAR if there is none. `depth` is the depth at the
// position 0 in parallel light, and its slope.
fn light_hybrid_entry(
    line: light_hybrid_Line,
    is_central: bool,
    depth: vec2<f32>,
    of_light: bool,
    value: f32,
    s: f32,
    exit: f32,
) -> f32 {
    if is_central {
        let least = max(value, 0.0);
        let square = least * least - line.h * line.h;
        if of_light {
            if s * s <= square {
                return s;
            }
            // Where the ray comes as close as that.
            if !(s < 0.0 && square >= 0.0 && -sqrt(square) <= exit) {
                return light_FAR;
            }
            return clamp(-sqrt(square), s, exit);
        }
        if s * s > square {
            return s;
        }
        return select(light_FAR, clamp(sqrt(square), s, exit), exit * exit > square);
    }
    if (depth.x + s * depth.y > value) != of_light {
        return s;
    }
    if (depth.x + exit * depth.y > value) != of_light {
        return clamp((value - depth.x) / depth.y, s, exit);
    }
    return light_FAR;
}

// The first position within a picture that may be in a volume; light_FAR if there is
// none.
fn light_hybrid_first_in(
    line: light_hybrid_Line,
    of_light: bool,
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
        // At the light itself this may be any cell.
        let place = clamp(here.xy / (here.z * size), vec2(0.0), vec2(f32(width) - 0.5));
        let cell = min(vec2<u32>(place), vec2(width - 1u));
        let texel = size * vec2<f32>(cell + after);
        let towards = slope.xy - texel * slope.z;
        // Borders parallel to the line or beyond its vanishing point are never met, and those
        // of the picture end the part. A border right here is met, whatever rounding does.
        let ahead = select(-towards, towards, rises);
        let number = cell + after;
        let is_met = (ahead > vec2(0.0)) & (number > vec2(0u)) & (number < vec2(width));
        let crossings = max((texel * at.z - at.xy) / towards, vec2(s));
        let borders = select(vec2(light_FAR), crossings, is_met);
        let exit = min(min(borders.x, borders.y), part.y);
        let value = light_hybrid_value(of_light, picture, level, cell);
        let entry = light_hybrid_entry(line, is_central, depth, of_light, value, s, exit);
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

// The first position of a part of a line that may be in a volume; light_FAR if there is
// none.
fn light_hybrid_first(
    line: light_hybrid_Line,
    of_light: bool,
    part: vec2<f32>,
    shortest: f32,
) -> f32 {
    // A position on the border of a picture may be rounded to either side, so a texel around a
    // picture counts as part of it. Light may be in the neighbour's cells alone, so that the
    // parts overlap when light is sought. Everything outside of a single picture is lit: its
    // border is moved inwards by a texel.
    let is_single = light_map.face_count == 1u;
    let is_outside_lit = of_light && is_single;
    let texels = select(1.0, -1.0, is_outside_lit);
    let last = f32(light_map.resolution) + texels;
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
        var inside = vec2(select(s, part.x, of_light), part.y);
        inside = light_hybrid_clip(at.x + texels * at.z, slope.x + texels * slope.z, inside);
        inside = light_hybrid_clip(at.y + texels * at.z, slope.y + texels * slope.z, inside);
        inside = light_hybrid_clip(last * at.z - at.x, last * slope.z - slope.x, inside);
        inside = light_hybrid_clip(last * at.z - at.y, last * slope.z - slope.y, inside);
        let is_in = inside.x <= s && s < inside.y && light_map.resolution > 2u;
        if is_outside_lit && !is_in {
            return s;
        }
        if inside.x < inside.y {
            let found =
                light_hybrid_first_in(line, of_light, picture, at, slope, inside, shortest);
            if found != light_FAR {
                return found;
            }
        }
        if is_single {
            return select(light_FAR, inside.y, is_outside_lit && inside.y < part.y);
        }
        s = max(inside.y, past);
    }
    return s;
}

// Where a part of a ray enters the first volume, as a distance from the eye; light_FAR if
// there is none.
fn light_hybrid_front(
    line: light_hybrid_Line,
    of_light: bool,
    part: vec2<f32>,
    shortest: f32,
) -> f32 {
    let front = light_hybrid_first(line, of_light, part - line.foot, shortest);
    if front == light_FAR {
        return light_FAR;
    }
    return clamp(front - light_hybrid_margin(line, front) + line.foot, part.x, part.y);
}

// Where it leaves the last one: the same search from the other end.
fn light_hybrid_back(
    line: light_hybrid_Line,
    of_light: bool,
    part: vec2<f32>,
    shortest: f32,
) -> f32 {
    var reversed = line;
    reversed.direction = -line.direction;
    let back = light_hybrid_first(reversed, of_light, line.foot - part.yx, shortest);
    if back == light_FAR {
        return light_FAR;
    }
    return clamp(light_hybrid_margin(line, back) - back + line.foot, part.x, part.y);
}

// The middle of a step; for the one behind the last, the end of all.
fn light_hybrid_middle(cursor: light_hybrid_Cursor, i: u32) -> f32 {
    if i >= light_hybrid.steps {
        return cursor.part.y;
    }
    let t = (f32(i) + 0.5) / f32(light_hybrid.steps);
    return cursor.part.x + t * (cursor.part.y - cursor.part.x);
}

// The middle of the previous step; for the first step, the start of all.
fn light_hybrid_before(cursor: light_hybrid_Cursor, i: u32) -> f32 {
    if i == 0u {
        return cursor.part.x;
    }
    return light_hybrid_middle(cursor, i - 1u);
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

// The step at a distance from the eye, as a real number.
fn light_hybrid_number(cursor: light_hybrid_Cursor, x: f32) -> f32 {
    let part = cursor.part;
    return (x - part.x) / (part.y - part.x) * f32(light_hybrid.steps);
}

// The first step whose middle is not in front of a distance.
fn light_hybrid_step_from(cursor: light_hybrid_Cursor, x: f32) -> u32 {
    let number = ceil(light_hybrid_number(cursor, x) - 0.5);
    return u32(clamp(number, 0.0, f32(light_hybrid.steps)));
}

// What the volumes tell about a ray: the part about which the map has to be asked, empty if
// everything is known, and whether the ray is lit in front of it and behind it.
struct light_hybrid_Known {
    part: vec2<f32>,
    outside: vec2<bool>,
}

fn light_hybrid_known(
    line: light_hybrid_Line,
    whole: vec2<f32>,
    shortest: f32,
) -> light_hybrid_Known {
    var part = whole;
    var outside = vec2(true);
    if light_hybrid.has_shadow != 0u {
        part.x = light_hybrid_front(line, false, whole, shortest);
        if part.x != light_FAR {
            part.y = light_hybrid_back(line, false, part, shortest);
        }
        if part.x == light_FAR || part.y == light_FAR {
            return light_hybrid_Known(whole.xx, outside);
        }
    }
    if light_hybrid.has_light == 0u {
        return light_hybrid_Known(part, outside);
    }
    // The lit ends of a ray outside of the shadow volumes are inside of volumes of light.
    if part.x <= whole.x {
        let front = light_hybrid_front(line, true, part, shortest);
        if front == light_FAR {
            return light_hybrid_Known(whole.xx, vec2(false));
        }
        part.x = front;
        outside.x = front <= whole.x;
    }
    if part.y >= whole.y {
        let back = light_hybrid_back(line, true, part, shortest);
        part.y = select(back, part.x, back == light_FAR);
        outside.y = part.y >= whole.y;
    }
    return light_hybrid_Known(part, outside);
}

fn light_hybrid_cursor(path: light_Path) -> light_hybrid_Cursor {
    var cursor: light_hybrid_Cursor;
    let steps = light_hybrid.steps;
    let by_span = light_hybrid.by_span != 0u;
    let whole = vec2(path.start, min(path.end, path.start + light_medium().far_end));
    let step = (whole.y - whole.x) / f32(steps);
    cursor.end = whole.y;
    cursor.part = whole;
    cursor.shortest = select(step, light_hybrid_SHORT * step, by_span);
    cursor.lit_from = whole.x;
    cursor.was_lit = true;
    cursor.is_lit_behind = true;
    cursor.last = steps;
    cursor.leap = light_hybrid_LEAP;
    if light_hybrid.side == 0u {
        return cursor;
    }
    let known = light_hybrid_known(light_hybrid_line(path), whole, cursor.shortest);
    cursor.was_lit = known.outside.x;
    cursor.is_lit_behind = known.outside.y;
    if by_span && known.part.x < known.part.y {
        cursor.part = known.part;
        return cursor;
    }
    cursor.next = light_hybrid_step_from(cursor, known.part.x);
    let last = floor(light_hybrid_number(cursor, known.part.y) + 0.5);
    cursor.last = max(cursor.next, u32(clamp(last, 0.0, f32(steps))));
    return cursor;
}

// Skips the steps that are known to have the same result as the last one, whose middle is
// `x`: those in front of the next volume of the other kind.
fn light_hybrid_leap(cursor: ptr<function, light_hybrid_Cursor>, path: light_Path, x: f32) {
    let of_light = !(*cursor).was_lit;
    if select(light_hybrid.has_shadow, light_hybrid.has_light, of_light) == 0u {
        return;
    }
    let rest = vec2(x, (*cursor).end);
    let line = light_hybrid_line(path);
    let front = light_hybrid_front(line, of_light, rest, (*cursor).shortest);
    var first = (*cursor).last;
    if front != light_FAR {
        first = light_hybrid_step_from(*cursor, front);
    }
    if first < (*cursor).next + light_hybrid_LEAP {
        (*cursor).leap *= 2u;
    }
    (*cursor).next = min(max((*cursor).next, first), (*cursor).last);
    (*cursor).alike = 0u;
}

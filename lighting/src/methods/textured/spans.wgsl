// Visibility: a shadow map that is asked between the front of the first shadow volume and
// the back of the last one; the shader's side of `ShadowSpans`.
//
// Needs search.wgsl and what it needs, lattice.wgsl, the slot of the point visibility,
//   fn light_point_visibility(point: vec3<f32>) -> vec3<f32>
// and the variable
//   light_spans: light_Steps

// See `spans.rs`.
const light_spans_HALVINGS: u32 = 3u;

struct light_spans_Cursor {
    lattice: light_Lattice,
    end: f32,
    // The part about which the map is asked.
    asked: vec2<f32>,
    // The start of the next step, and the index of the position in front of it.
    at: f32,
    number: f32,
    was_lit: bool,
    // Where the run at hand begins.
    lit_from: f32,
    // Whether it is known for any position if it is lit, and the last such position.
    knows: bool,
    last: f32,
}

fn light_spans_asked(path: light_Path, whole: vec2<f32>) -> vec2<f32> {
    if light_hybrid.side == 0u {
        return whole;
    }
    let line = light_hybrid_line(path);
    let step = (whole.y - whole.x) / light_spans.count;
    let front = light_hybrid_front(line, false, whole, step);
    if front == light_FAR {
        return whole.xx;
    }
    let back = light_hybrid_back(line, false, vec2(front, whole.y), step);
    if back == light_FAR {
        return whole.xx;
    }
    return vec2(front, back);
}

fn light_spans_cursor(path: light_Path) -> light_spans_Cursor {
    var cursor: light_spans_Cursor;
    cursor.end = min(path.end, path.start + light_medium().far_end);
    cursor.asked = light_spans_asked(path, vec2(path.start, cursor.end));
    cursor.lattice = light_lattice(light_spans, path, cursor.asked);
    cursor.at = cursor.asked.x;
    cursor.number = light_lattice_number(cursor.lattice, path, cursor.at);
    cursor.was_lit = true;
    cursor.lit_from = path.start;
    cursor.knows = cursor.asked.x > path.start;
    cursor.last = cursor.asked.x;
    return cursor;
}

fn light_spans_is_lit(path: light_Path, x: f32) -> bool {
    return light_point_visibility(path.origin + x * path.direction).x > 0.0;
}

// Where the light changes between two positions, found by halving.
fn light_spans_border(path: light_Path, first: f32, second: f32, was_lit: bool) -> f32 {
    var before = first;
    var after = second;
    for (var i = 0u; i < light_spans_HALVINGS; i++) {
        let x = 0.5 * (before + after);
        if light_spans_is_lit(path, x) == was_lit {
            before = x;
        } else {
            after = x;
        }
    }
    return 0.5 * (before + after);
}

fn light_spans_next_lit(cursor: ptr<function, light_spans_Cursor>, path: light_Path) -> light_Lit {
    let asked = (*cursor).asked;
    while (*cursor).at < asked.y {
        let start = (*cursor).at;
        (*cursor).number += 1.0;
        let mark = light_lattice_position((*cursor).lattice, path, (*cursor).number);
        let end = min(mark, asked.y);
        if !(start < end) {
            continue;
        }
        (*cursor).at = end;
        let middle = light_lattice_middle((*cursor).lattice, path, start, end);
        let was_lit = (*cursor).was_lit;
        let is_lit = light_spans_is_lit(path, middle);
        // The start of a ray is no border, even if the ray begins in shadow.
        var border = start;
        if is_lit != was_lit && (*cursor).knows {
            border = light_spans_border(path, (*cursor).last, middle, was_lit);
        }
        (*cursor).knows = true;
        (*cursor).last = middle;
        (*cursor).was_lit = is_lit;
        if is_lit == was_lit {
            continue;
        }
        if is_lit {
            (*cursor).lit_from = border;
        } else if (*cursor).lit_from < border {
            return light_lit((*cursor).lit_from, border, 1.0);
        }
    }
    if !(*cursor).was_lit && asked.x < asked.y && asked.y < (*cursor).end {
        (*cursor).lit_from = light_spans_border(path, (*cursor).last, asked.y, false);
        (*cursor).was_lit = true;
    }
    if (*cursor).was_lit && (*cursor).lit_from < (*cursor).end {
        let run = light_lit((*cursor).lit_from, (*cursor).end, 1.0);
        // There is no more.
        (*cursor).lit_from = (*cursor).end;
        return run;
    }
    return light_dark();
}

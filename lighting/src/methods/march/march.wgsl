// Visibility: a march in equal steps of distance, of angle or of the picture of a
// spotlight, which asks for the visibility once in each step.
//
// Needs the variable
//   light_march: light_March
// and the slot of the point visibility,
//   fn light_point_visibility(point: vec3<f32>) -> vec3<f32>

// Values of `spacing`; others are equal steps of angle.
const light_march_DISTANCE: u32 = 0u;
const light_march_PICTURE: u32 = 2u;

// The least depth of one end in front of a spotlight, as a share of that of the other end.
const light_march_LEAST_DEPTH: f32 = 1e-3;

struct light_March {
    steps: u32,
    spacing: u32,
    // Interleaved rays: the first `stride · each` rays take every `stride`-th step. The first
    // `each` of them begin with step 0, the next `each` with step 1, and so on.
    stride: u32,
    each: u32,
}

struct light_march_Cursor {
    arc: light_Arc,
    equi_angular: bool,
    // Depths of the ends in front of a spotlight; 1 for steps of equal distance.
    depths: vec2<f32>,
    end: f32,
    // The start of the next step, and its number.
    start: f32,
    step: u32,
    // How many steps the ray goes on by.
    stride: u32,
}

fn light_march_cursor(path: light_Path) -> light_march_Cursor {
    var cursor: light_march_Cursor;
    cursor.start = path.start;
    cursor.step = 0u;
    cursor.stride = 1u;
    if path.index < light_march.stride * light_march.each {
        cursor.step = path.index / light_march.each;
        cursor.stride = light_march.stride;
    }
    let emitter = light_emitter();
    let is_spot = emitter.kind == light_POINT && emitter.emission == light_SPOT;
    let in_picture = light_march.spacing == light_march_PICTURE && is_spot;
    let by_angle = light_march.spacing != light_march_DISTANCE && !in_picture;
    cursor.equi_angular = by_angle && emitter.kind == light_POINT;
    cursor.depths = vec2<f32>(1.0);
    if cursor.equi_angular {
        cursor.arc = light_arc(path, path.start, path.end);
        cursor.end = path.end;
    } else {
        cursor.end = min(path.end, path.start + light_medium().far_end);
    }
    if in_picture {
        let before = dot(path.origin - emitter.position, emitter.axis);
        let slope = dot(path.direction, emitter.axis);
        let depths = max(before + vec2<f32>(path.start, cursor.end) * slope, vec2<f32>(0.0));
        let least = light_march_LEAST_DEPTH * max(depths.x, depths.y);
        if least > 0.0 {
            cursor.depths = max(depths, vec2<f32>(least));
        }
    }
    return cursor;
}

// The distance from the eye at the share t of the steps.
fn light_march_position(cursor: light_march_Cursor, path: light_Path, t: f32) -> f32 {
    if cursor.equi_angular {
        return light_arc_position(cursor.arc, t);
    }
    let weight = t * cursor.depths.x;
    let share = weight / (weight + (1.0 - t) * cursor.depths.y);
    return path.start + share * (cursor.end - path.start);
}

fn light_march_next_lit(cursor: ptr<function, light_march_Cursor>, path: light_Path) -> light_Lit {
    let steps = light_march.steps;
    let step = 1.0 / f32(steps);
    while (*cursor).step < steps {
        let i = (*cursor).step;
        (*cursor).step = i + (*cursor).stride;
        var start = (*cursor).start;
        if (*cursor).stride > 1u && i > 0u {
            start = light_march_position(*cursor, path, f32(i) * step);
        }
        var end = (*cursor).end;
        if i + 1u < steps {
            end = light_march_position(*cursor, path, f32(i + 1u) * step);
        }
        let middle = light_march_position(*cursor, path, (f32(i) + 0.5) * step);
        (*cursor).start = max(start, end);
        if start < end {
            let visibility = light_point_visibility(path.origin + middle * path.direction);
            let part = light_Lit(start, end, f32((*cursor).stride) * visibility);
            if !light_is_dark(part) {
                return part;
            }
        }
    }
    return light_dark();
}

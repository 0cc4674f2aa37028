// Visibility: a march in equal steps of distance or angle, one question each.
//
// Needs the variable
//   light_march: light_March
// and the slot of what is asked,
//   fn light_point_visibility(point: vec3<f32>) -> vec3<f32>

struct light_March {
    steps: u32,
    equi_angular: u32,
}

struct light_march_Cursor {
    arc: light_Arc,
    equi_angular: bool,
    end: f32,
    // Start of the next step, and its number.
    start: f32,
    step: u32,
}

fn light_march_cursor(path: light_Path) -> light_march_Cursor {
    var cursor: light_march_Cursor;
    cursor.start = path.start;
    cursor.step = 0u;
    cursor.equi_angular = light_march.equi_angular != 0u && light_emitter().kind == light_POINT;
    if cursor.equi_angular {
        cursor.arc = light_arc(path, path.start, path.end);
        cursor.end = path.end;
    } else {
        cursor.end = min(path.end, path.start + light_medium().far_end);
    }
    return cursor;
}

fn light_march_position(cursor: light_march_Cursor, path: light_Path, t: f32) -> f32 {
    if cursor.equi_angular {
        return light_arc_position(cursor.arc, t);
    }
    return path.start + t * (cursor.end - path.start);
}

fn light_march_next_lit(cursor: ptr<function, light_march_Cursor>, path: light_Path) -> light_Lit {
    let steps = light_march.steps;
    let step = 1.0 / f32(steps);
    while (*cursor).step < steps {
        let i = (*cursor).step;
        (*cursor).step = i + 1u;
        let start = (*cursor).start;
        var end = (*cursor).end;
        if i + 1u < steps {
            end = light_march_position(*cursor, path, f32(i + 1u) * step);
        }
        let middle = light_march_position(*cursor, path, (f32(i) + 0.5) * step);
        (*cursor).start = max(start, end);
        if start < end {
            let part =
                light_Lit(start, end, light_point_visibility(path.origin + middle * path.direction));
            if !light_is_dark(part) {
                return part;
            }
        }
    }
    return light_dark();
}

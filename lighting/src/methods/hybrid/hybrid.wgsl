// Visibility: a march that asks a shadow map only where volumes of shadow and of light leave
// open whether a ray is lit; the shader's side of `Hybrid`.
//
// Needs the part search.wgsl and the slot of the point visibility,
//   fn light_point_visibility(point: vec3<f32>) -> vec3<f32>

// How many times the interval between a lit step and a dark one is halved; see `mod.rs`.
const light_hybrid_HALVINGS: u32 = 3u;

fn light_hybrid_is_lit(path: light_Path, x: f32) -> bool {
    return light_point_visibility(path.origin + x * path.direction).x > 0.0;
}

// Where the light changes between the middles of two steps, found by halving.
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
    // Whether any of the ray lies in front of the first step, and behind the last one.
    let is_before = (*cursor).part.x > path.start;
    let is_behind = (*cursor).part.y < (*cursor).end;
    let most = select(steps, steps + 1u, is_behind);
    while (*cursor).next < min((*cursor).last + 1u, most) {
        let i = (*cursor).next;
        (*cursor).next = i + 1u;
        let x = light_hybrid_middle(*cursor, i);
        let was_lit = (*cursor).was_lit;
        var is_lit = (*cursor).is_lit_behind;
        if i < (*cursor).last {
            is_lit = light_hybrid_is_lit(path, x);
        }
        (*cursor).was_lit = is_lit;
        (*cursor).alike = select(1u, (*cursor).alike + 1u, is_lit == was_lit);
        if i < (*cursor).last && (*cursor).alike >= (*cursor).leap {
            light_hybrid_leap(cursor, path, x);
        }
        if is_lit == was_lit {
            continue;
        }
        // The start of the ray is no border.
        if i == 0u && !is_before {
            continue;
        }
        let before = light_hybrid_before(*cursor, i);
        let border = light_hybrid_border(path, before, x, was_lit);
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

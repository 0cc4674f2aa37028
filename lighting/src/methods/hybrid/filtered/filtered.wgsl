// Visibility: a march between volumes that takes the lit share of each step from a filtered
// map; the shader's side of `FilteredHybrid`.
//
// Needs the part search.wgsl and the slot of the step visibility,
//   fn light_step_visibility(start: vec3<f32>, end: vec3<f32>) -> vec3<f32>

struct light_filtered_Cursor {
    search: light_hybrid_Cursor,
    // What has been yielded ends here, and whether what lies between this and the next step
    // that is asked about is lit.
    start: f32,
    is_known_lit: bool,
    // A step that is yielded after the lit part in front of it.
    found: light_Lit,
    is_over: bool,
}

fn light_filtered_cursor(path: light_Path) -> light_filtered_Cursor {
    var cursor: light_filtered_Cursor;
    cursor.search = light_hybrid_cursor(path);
    cursor.start = path.start;
    cursor.is_known_lit = cursor.search.was_lit;
    cursor.found = light_dark();
    return cursor;
}

// Where a step begins; for the one behind the last, the end of all.
fn light_filtered_start(search: light_hybrid_Cursor, i: u32) -> f32 {
    if i >= light_hybrid.steps {
        return search.part.y;
    }
    let t = f32(i) / f32(light_hybrid.steps);
    return search.part.x + t * (search.part.y - search.part.x);
}

fn light_filtered_next_lit(
    cursor: ptr<function, light_filtered_Cursor>,
    path: light_Path,
) -> light_Lit {
    if !light_is_dark((*cursor).found) {
        let found = (*cursor).found;
        (*cursor).found = light_dark();
        return found;
    }
    var search = (*cursor).search;
    while search.next < search.last {
        let i = search.next;
        search.next = i + 1u;
        let start = light_filtered_start(search, i);
        let end = light_filtered_start(search, i + 1u);
        let share = light_step_visibility(
            path.origin + start * path.direction,
            path.origin + end * path.direction,
        );
        let step = light_Lit(start, end, share);
        let is_lit = all(share == vec3(1.0));
        if is_lit || light_is_dark(step) {
            search.alike = select(1u, search.alike + 1u, is_lit == search.was_lit);
            search.was_lit = is_lit;
        } else {
            search.alike = 0u;
        }
        if search.alike >= search.leap {
            light_hybrid_leap(&search, path, light_hybrid_middle(search, i));
        }
        let before = light_lit((*cursor).start, start, 1.0);
        let is_before = (*cursor).is_known_lit && before.start < start;
        (*cursor).start = end;
        (*cursor).is_known_lit = is_lit;
        if is_before {
            (*cursor).search = search;
            if start < end {
                (*cursor).found = step;
            }
            return before;
        }
        if start < end && !light_is_dark(step) {
            (*cursor).search = search;
            return step;
        }
    }
    (*cursor).search = search;
    // The steps that are left were not asked about: their visibility is known, and so is that
    // of what lies behind them.
    let end = light_filtered_start(search, search.last);
    if (*cursor).is_known_lit {
        let rest = light_lit((*cursor).start, end, 1.0);
        (*cursor).is_known_lit = false;
        (*cursor).start = max(rest.start, end);
        if rest.start < end {
            return rest;
        }
    }
    let behind = light_lit(max((*cursor).start, end), search.end, 1.0);
    if !(*cursor).is_over && search.is_lit_behind && behind.start < behind.end {
        (*cursor).is_over = true;
        return behind;
    }
    return light_dark();
}

// Visibility: a walk through precomputed voxelized shadows; the shader's side of
// `BakedShadow`.
//
// Needs the parts POINT, PACKED, SPACE and RAY of shadow-dag, grids.wgsl, and
//   fn light_baked_count() -> u32                           the number of the light's grids
//   fn light_baked_grid(grid: u32) -> light_BakedGrid       one of them, from 0 on

struct light_baked_Cursor {
    // The part of the path that is in each grid, and a bit for each grid that has been walked
    // or that the path does not meet.
    parts: array<vec2<f32>, light_MOST_GRIDS>,
    walked: u32,
    // The grid that is being walked; light_MOST_GRIDS for none.
    grid: u32,
    walk: dag_Cursor,
    // The distance up to which the path has been walked.
    reached: f32,
}

fn light_baked_cursor(path: light_Path) -> light_baked_Cursor {
    var cursor: light_baked_Cursor;
    cursor.walked = 0u;
    cursor.grid = light_MOST_GRIDS;
    cursor.reached = path.start;
    for (var grid = 0u; grid < light_baked_count(); grid += 1u) {
        let space = light_baked_grid(grid).space;
        let walk = dag_cursor(space, path.origin, path.direction, path.start, path.end);
        cursor.parts[grid] = vec2(walk.enter, walk.leave);
        cursor.walked |= select(1u, 0u, walk.enter < walk.leave) << grid;
    }
    return cursor;
}

// Grids lie side by side, so that a path runs through one after the other. Between them it is
// lit.
fn light_baked_next_lit(cursor: ptr<function, light_baked_Cursor>, path: light_Path) -> light_Lit {
    loop {
        let grid = (*cursor).grid;
        if grid < light_MOST_GRIDS {
            var walk = (*cursor).walk;
            let here = light_baked_grid(grid);
            let part = dag_next_lit(here.dag, here.space, &walk);
            (*cursor).walk = walk;
            if part.start < part.end {
                return light_lit(part.start, part.end, 1.0);
            }
            (*cursor).reached = max((*cursor).reached, (*cursor).parts[grid].y);
            (*cursor).grid = light_MOST_GRIDS;
        }
        var next = light_MOST_GRIDS;
        var enter = path.end;
        for (var i = 0u; i < light_baked_count(); i += 1u) {
            let waits = (((*cursor).walked >> i) & 1u) == 0u;
            if waits && ((*cursor).parts[i].x < enter) {
                next = i;
                enter = (*cursor).parts[i].x;
            }
        }
        let start = (*cursor).reached;
        (*cursor).reached = max(start, enter);
        if next < light_MOST_GRIDS {
            let space = light_baked_grid(next).space;
            let leave = (*cursor).parts[next].y;
            (*cursor).walked |= 1u << next;
            (*cursor).grid = next;
            (*cursor).walk = dag_cursor(space, path.origin, path.direction, (*cursor).reached, leave);
        }
        if start < enter {
            return light_lit(start, enter, 1.0);
        }
        if next == light_MOST_GRIDS {
            break;
        }
    }
    return light_dark();
}

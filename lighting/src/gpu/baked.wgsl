// Visibility: a walk through precomputed voxelized shadows; the shader's side of `BakedShadow`.
//
// Needs the parts POINT, PACKED, SPACE and RAY of shadow-dag, and
//   fn light_dag_grids() -> u32                       how many grids there are
//   fn light_dag_shadows(grid: u32) -> dag_Shadows    what is in one of them
//   fn light_dag_space(grid: u32) -> dag_Space        and where it is

const light_MOST_GRIDS: u32 = 6u;

struct light_Look {
    // The part of the path that is in each grid, and those that have been
    // walked or never are, a bit for each.
    parts: array<vec2<f32>, light_MOST_GRIDS>,
    walked: u32,
    // The one that is being walked; light_MOST_GRIDS for none.
    grid: u32,
    walk: dag_Look,
    // Where the path has been looked at up to.
    reached: f32,
}

fn light_look(path: light_Path) -> light_Look {
    var look: light_Look;
    look.walked = 0u;
    look.grid = light_MOST_GRIDS;
    look.reached = path.start;
    for (var grid = 0u; grid < light_dag_grids(); grid += 1u) {
        let space = light_dag_space(grid);
        let walk = dag_look(space, path.origin, path.direction, path.start, path.end);
        look.parts[grid] = vec2(walk.enter, walk.leave);
        look.walked |= select(1u, 0u, walk.enter < walk.leave) << grid;
    }
    return look;
}

// Grids lie side by side, so that a path is in one after the other. Between
// them it is lit.
fn light_next_lit(look: ptr<function, light_Look>, path: light_Path) -> light_Lit {
    loop {
        let grid = (*look).grid;
        if grid < light_MOST_GRIDS {
            var walk = (*look).walk;
            let part = dag_next_lit(light_dag_shadows(grid), light_dag_space(grid), &walk);
            (*look).walk = walk;
            if part.start < part.end {
                return light_Lit(part.start, part.end, 1.0);
            }
            (*look).reached = max((*look).reached, (*look).parts[grid].y);
            (*look).grid = light_MOST_GRIDS;
        }
        var next = light_MOST_GRIDS;
        var enter = path.end;
        for (var i = 0u; i < light_dag_grids(); i += 1u) {
            let waits = (((*look).walked >> i) & 1u) == 0u;
            if waits && ((*look).parts[i].x < enter) {
                next = i;
                enter = (*look).parts[i].x;
            }
        }
        let start = (*look).reached;
        (*look).reached = max(start, enter);
        if next < light_MOST_GRIDS {
            let space = light_dag_space(next);
            let leave = (*look).parts[next].y;
            (*look).walked |= 1u << next;
            (*look).grid = next;
            (*look).walk = dag_look(space, path.origin, path.direction, (*look).reached, leave);
        }
        if start < enter {
            return light_Lit(start, enter, 1.0);
        }
        if next == light_MOST_GRIDS {
            break;
        }
    }
    return light_Lit(0.0, 0.0, 0.0);
}

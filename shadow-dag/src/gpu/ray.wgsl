// Which parts of a ray are lit: the shader's side of
// `ShadowDag::lit_intervals`.
//
// The walk goes from one homogeneous volume to the next. The voxel is kept in
// integers: each step leaves the volume through the side that the ray meets
// first; along the other axes it takes the computed position, clamped to the volume. A step
// therefore always makes progress, whatever rounding does.
//
// Needs `POINT` and `SPACE` and what those need.

// A lit part; empty (start = end) for none.
struct dag_LitInterval {
    start: f32,
    end: f32,
}

// A ray, and how far it has been walked.
struct dag_Cursor {
    // Homogeneous coordinates at the parameter 0, and by how much they grow per unit of it.
    base: vec4<f32>,
    along: vec4<f32>,
    // Whether each coordinate of the grid grows (1), falls (−1) or stays.
    way: vec3<i32>,
    // The voxel at hand.
    cell: vec3<u32>,
    // The parameter up to which the ray has been walked, the part of it that is in the
    // grid, and its end.
    reached: f32,
    enter: f32,
    leave: f32,
    end: f32,
}

// The cell of a position along one axis.
fn dag_cell(space: dag_Space, position: f32) -> u32 {
    return u32(clamp(position, 0.0, space.side - 1.0));
}

// The voxel at a parameter of the ray, by rounding down the position of the point.
fn dag_cells(space: dag_Space, cursor: dag_Cursor, s: f32) -> vec3<u32> {
    let h = cursor.base + s * cursor.along;
    let position = dag_position(space, vec4(h.xyz, max(h.w, 1e-30)));
    return vec3(
        dag_cell(space, position.x),
        dag_cell(space, position.y),
        dag_cell(space, position.z),
    );
}

// The part of a ray that is within the four sides of the map and behind its first slice.
// Each of the bounds is linear along the ray and not negative inside.
fn dag_clip(space: dag_Space, cursor: dag_Cursor, start: f32, end: f32) -> vec2<f32> {
    var part = vec2(start, end);
    let base = cursor.base;
    let along = cursor.along;
    var bounds = array<vec2<f32>, 5>(
        vec2(base.x, along.x),
        vec2(base.w - base.x, along.w - along.x),
        vec2(base.y, along.y),
        vec2(base.w - base.y, along.w - along.y),
        vec2(base.z - space.near, along.z),
    );
    for (var i = 0u; i < 5u; i += 1u) {
        let bound = bounds[i];
        if bound.y > 0.0 {
            part.x = max(part.x, -bound.x / bound.y);
        } else if bound.y < 0.0 {
            part.y = min(part.y, -bound.x / bound.y);
        } else if !(bound.x >= 0.0) {
            part.y = -dag_FAR;
        }
    }
    return part;
}

// A walk along the points `origin + s · direction` with `s` from `start` ≥ 0 to `end`,
// which may be `dag_FAR`. Lengths are in units of the direction's length. The numbers must
// be finite and the direction not zero.
fn dag_cursor(
    space: dag_Space,
    origin: vec3<f32>,
    direction: vec3<f32>,
    start: f32,
    end: f32,
) -> dag_Cursor {
    var cursor: dag_Cursor;
    cursor.base = dag_homogeneous(space, vec4(origin, 1.0));
    cursor.along = dag_homogeneous(space, vec4(direction, 0.0));
    cursor.way = vec3<i32>(sign(vec3(
        cursor.along.xy * cursor.base.w - cursor.base.xy * cursor.along.w,
        cursor.along.z,
    )));
    cursor.reached = start;
    cursor.end = end;
    let part = dag_clip(space, cursor, start, end);
    cursor.enter = part.x;
    cursor.leave = part.y;
    if !(part.x < part.y) {
        // All of it is beside the grid.
        cursor.enter = end;
        cursor.leave = end;
    } else {
        cursor.cell = dag_cells(space, cursor, part.x);
    }
    return cursor;
}

// The parameter at which the ray crosses the plane between texels at `share` of the map's
// width. `base` are the coordinate and W at the parameter 0, `along` by how much they grow.
fn dag_texel_crossing(share: f32, base: vec2<f32>, along: vec2<f32>, way: i32) -> f32 {
    // The denominator has the other sign for planes beyond the ray's vanishing point. A ray
    // that goes away from the light never meets those; one that comes towards it has met
    // them before all others.
    let denominator = along.x - share * along.y;
    if denominator * f32(way) <= 0.0 {
        return select(dag_FAR, -dag_FAR, along.y < 0.0);
    }
    return (share * base.y - base.x) / denominator;
}

// The parameters at which the ray crosses one plane across each axis; `dag_FAR` for never,
// and for the rim of the grid, where `leave` ends the walk instead.
fn dag_crossings(space: dag_Space, cursor: dag_Cursor, planes: vec3<u32>) -> vec3<f32> {
    let plane = vec3<f32>(planes);
    let share = plane.xy / space.side;
    let crossings = vec3(
        dag_texel_crossing(share.x, cursor.base.xw, cursor.along.xw, cursor.way.x),
        dag_texel_crossing(share.y, cursor.base.yw, cursor.along.yw, cursor.way.y),
        (dag_depth_of_slice(space, plane.z) - cursor.base.z) / cursor.along.z,
    );
    let inner = (cursor.way != vec3(0)) & (plane > vec3(0.0)) & (plane < vec3(space.side));
    return select(vec3(dag_FAR), crossings, inner);
}

// Goes on to the voxel behind the volume of width `1 << shift` around the cell.
fn dag_leave(space: dag_Space, cursor: ptr<function, dag_Cursor>, shift: u32) {
    let cell = (*cursor).cell;
    let low = (cell >> vec3(shift)) << vec3(shift);
    let high = low + vec3((1u << shift) - 1u);
    let grows = (*cursor).way > vec3(0);
    let crossings = dag_crossings(space, *cursor, select(low, high + vec3(1u), grows));
    let first = min(min(crossings.x, crossings.y), crossings.z);
    if first >= (*cursor).leave {
        (*cursor).reached = (*cursor).leave;
        return;
    }
    (*cursor).reached = max((*cursor).reached, first);
    let seen = dag_cells(space, *cursor, (*cursor).reached);
    let falls = (*cursor).way < vec3(0);
    let within = select(
        select(cell, clamp(seen, low, cell), falls),
        clamp(seen, cell, high),
        grows,
    );
    // Two sides may be met at once; a step goes through one only.
    let x = crossings.x == first;
    let y = !x && crossings.y == first;
    let through = vec3(x, y, !x && !y);
    (*cursor).cell = select(within, select(low - vec3(1u), high + vec3(1u), grows), through);
}

// The next lit part of the ray, empty (start = end) behind the last one. Neighbouring lit
// volumes are joined. What is beside the grid or in front of it is lit, and behind the last
// slice it is as in the last.
fn dag_next_lit(dag: dag_Shadows, space: dag_Space, cursor: ptr<function, dag_Cursor>) -> dag_LitInterval {
    var found = dag_LitInterval(0.0, 0.0);
    while (*cursor).reached < (*cursor).end {
        let start = (*cursor).reached;
        var lit = true;
        if start < (*cursor).enter {
            (*cursor).reached = (*cursor).enter;
        } else if start < (*cursor).leave {
            let volume = dag_volume(dag, (*cursor).cell);
            lit = volume.lit;
            dag_leave(space, cursor, volume.shift);
        } else {
            (*cursor).reached = (*cursor).end;
        }
        if lit {
            if found.start == found.end {
                found.start = start;
            }
            found.end = (*cursor).reached;
        } else if found.start < found.end {
            break;
        }
    }
    return found;
}

// The length of all lit parts that are left, in units of the direction's length.
fn dag_lit_length(dag: dag_Shadows, space: dag_Space, cursor: ptr<function, dag_Cursor>) -> f32 {
    var sum = 0.0;
    loop {
        let part = dag_next_lit(dag, space, cursor);
        if part.start == part.end {
            break;
        }
        sum += part.end - part.start;
    }
    return sum;
}

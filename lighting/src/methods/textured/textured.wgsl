// Visibility: the colours of a spotlight's cookie, step by step, where a source of shadows
// says that it is lit; the shader's side of `Textured`.
//
// Needs lattice.wgsl, the slot of the shadows,
//   alias light_textured_Shadows
//   fn light_textured_shadows(path: light_Path) -> light_textured_Shadows
//   fn light_textured_next_shadows(cursor: ptr<function, light_textured_Shadows>, path: light_Path) -> light_Lit
// and the variables
//   light_textured: light_Textured
//   light_textured_texels: array<f32>, red, green and blue of each texel of the cookie,
//       row by row, level by level

struct light_Textured {
    axis: vec3<f32>,
    outer_versine: f32,
    right: vec3<f32>,
    rim: f32,
    up: vec3<f32>,
    tan_outer: f32,
    range: f32,
    fades: u32,
    // Whether it is a spotlight at all.
    is_spot: u32,
    // Whether there is light outside of the cone.
    is_open: u32,
    // By how many mip levels a lookup is finer than the step.
    finer: f32,
    level_count: u32,
    padding: vec2<u32>,
    steps: light_Steps,
    // Width, height and first texel of each level.
    levels: array<vec4<u32>, 32>,
}

// Where a run lies: in front of the cone, in it, or behind it.
const light_textured_BEFORE: u32 = 0u;
const light_textured_INSIDE: u32 = 1u;
const light_textured_BEHIND: u32 = 2u;
const light_textured_NOWHERE: u32 = 3u;

struct light_textured_Cursor {
    shadows: light_textured_Shadows,
    // The steps in the cone, and those of the whole ray.
    lattice: light_Lattice,
    whole_lattice: light_Lattice,
    // The whole ray, and its part in the cone.
    whole: vec2<f32>,
    inside: vec2<f32>,
    // Where the ray crosses the inner edge of the cone's rim.
    rim: vec2<f32>,
    // The run at hand, where in it the next step begins, and the index of the position
    // behind that.
    run: light_Lit,
    at: f32,
    number: f32,
    place: u32,
}

// The part of the path in the cone.
fn light_textured_path(path: light_Path, inside: vec2<f32>) -> light_Path {
    var part = path;
    part.start = inside.x;
    part.end = inside.y;
    return part;
}

fn light_textured_cursor(path: light_Path) -> light_textured_Cursor {
    var cursor: light_textured_Cursor;
    cursor.whole = vec2(path.start, min(path.end, path.start + light_medium().far_end));
    cursor.inside = cursor.whole;
    cursor.rim = vec2(light_FAR);
    if light_textured.is_spot != 0u {
        let cone = light_in_cone(path, light_textured.axis, light_textured.outer_versine);
        cursor.inside = vec2(max(cone.x, cursor.whole.x), min(cone.y, cursor.whole.y));
        if light_textured.outer_versine > light_textured.rim && light_textured.is_open == 0u {
            let full = light_in_cone(path, light_textured.axis, light_textured.outer_versine - light_textured.rim);
            cursor.rim = select(vec2(light_FAR), full, full.x < full.y);
        }
    }
    if !(cursor.inside.x < cursor.inside.y) {
        // The ray misses the cone: all of it counts as in front of it.
        cursor.inside = cursor.whole.yy;
    }
    cursor.whole_lattice = light_lattice(light_textured.steps, path, cursor.whole);
    cursor.lattice = light_lattice(light_textured.steps, path, cursor.inside);
    cursor.shadows = light_textured_shadows(light_textured_path(path, cursor.inside));
    cursor.place = light_textured_BEFORE;
    if light_textured.is_open != 0u && light_textured.is_spot != 0u {
        light_textured_begin(&cursor, path, light_lit(cursor.whole.x, cursor.inside.x, 1.0));
    }
    return cursor;
}

// Begins with a run at its first step.
fn light_textured_begin(
    cursor: ptr<function, light_textured_Cursor>,
    path: light_Path,
    run: light_Lit,
) {
    (*cursor).run = run;
    (*cursor).at = run.start;
    (*cursor).number = light_lattice_number(light_textured_lattice(cursor), path, run.start);
}

// The steps of the run at hand.
fn light_textured_lattice(cursor: ptr<function, light_textured_Cursor>) -> light_Lattice {
    if (*cursor).place == light_textured_INSIDE {
        return (*cursor).lattice;
    }
    return (*cursor).whole_lattice;
}

// Goes on to the next run; false if there is none.
fn light_textured_next_run(
    cursor: ptr<function, light_textured_Cursor>,
    path: light_Path,
) -> bool {
    let inside = (*cursor).inside;
    if (*cursor).place == light_textured_BEFORE {
        (*cursor).place = light_textured_INSIDE;
    }
    if (*cursor).place == light_textured_INSIDE {
        if inside.x < inside.y {
            var shadows = (*cursor).shadows;
            let run = light_textured_next_shadows(&shadows, light_textured_path(path, inside));
            (*cursor).shadows = shadows;
            if !light_is_dark(run) {
                light_textured_begin(cursor, path, run);
                return true;
            }
        }
        (*cursor).place = light_textured_BEHIND;
        if light_textured.is_open != 0u && light_textured.is_spot != 0u {
            light_textured_begin(cursor, path, light_lit(inside.y, (*cursor).whole.y, 1.0));
            return true;
        }
    }
    (*cursor).place = light_textured_NOWHERE;
    return false;
}

// Where the cookie is seen in a direction from the light, from (0, 0) to (1, 1).
fn light_textured_uv(v: vec3<f32>) -> vec2<f32> {
    let front = dot(light_textured.axis, v) * light_textured.tan_outer;
    // At the light itself there is no direction.
    if !(abs(front) > 1e-30) {
        return vec2(0.5);
    }
    return 0.5 + 0.5 * vec2(dot(light_textured.right, v), -dot(light_textured.up, v)) / front;
}

fn light_textured_texel(index: u32) -> vec3<f32> {
    let i = 3u * index;
    return vec3(light_textured_texels[i], light_textured_texels[i + 1u], light_textured_texels[i + 2u]);
}

// A level of the cookie at a place, bilinear between texels; beyond its border it is as there.
fn light_textured_bilinear(number: u32, uv: vec2<f32>) -> vec3<f32> {
    let level = light_textured.levels[number];
    let at = clamp(uv, vec2(0.0), vec2(1.0)) * vec2<f32>(level.xy) - 0.5;
    let base = floor(at);
    let f = at - base;
    let last = vec2<i32>(level.xy) - 1;
    let low = vec2<u32>(clamp(vec2<i32>(base), vec2(0), last));
    let high = vec2<u32>(clamp(vec2<i32>(base) + 1, vec2(0), last));
    let rows = level.z + vec2(low.y, high.y) * level.x;
    let above = mix(
        light_textured_texel(rows.x + low.x), light_textured_texel(rows.x + high.x), f.x);
    let below = mix(
        light_textured_texel(rows.y + low.x), light_textured_texel(rows.y + high.x), f.x);
    return mix(above, below, f.y);
}

// The mean share of the light that comes through the cone over a step, which is given by its
// start, its middle and its end.
fn light_textured_colour(path: light_Path, step: vec3<f32>, is_inside: bool) -> vec3<f32> {
    if light_textured.is_spot == 0u {
        return vec3(1.0);
    }
    let middle = light_from_light(path, step.y - path.foot);
    var share = 1.0;
    if light_textured.fades != 0u {
        let part = min(middle.w / light_textured.range, 1.0);
        share = (1.0 - part * part) * (1.0 + part * part);
    }
    if !is_inside {
        return vec3(share);
    }
    if light_textured.is_open == 0u {
        let off_axis = light_textured.axis - middle.xyz;
        let ramp = clamp((light_textured.outer_versine - 0.5 * dot(off_axis, off_axis)) / light_textured.rim, 0.0, 1.0);
        share *= ramp * ramp;
    }
    if light_textured.level_count == 0u || share <= 0.0 {
        return vec3(share);
    }
    let ends = vec2(step.x, step.z) - path.foot;
    let from_here = light_textured_uv(path.h * path.to_foot + ends.x * path.direction);
    let to = light_textured_uv(path.h * path.to_foot + ends.y * path.direction);
    let across = (to - from_here) * vec2<f32>(light_textured.levels[0].xy);
    let texels = max(length(across) * exp2(-light_textured.finer), 1.0);
    let level = clamp(log2(texels), 0.0, f32(light_textured.level_count - 1u));
    let finer = floor(level);
    let uv = light_textured_uv(middle.xyz);
    var colour = light_textured_bilinear(u32(finer), uv);
    if level > finer {
        colour = mix(colour, light_textured_bilinear(u32(finer) + 1u, uv), level - finer);
    }
    return share * colour;
}

fn light_textured_next_lit(
    cursor: ptr<function, light_textured_Cursor>,
    path: light_Path,
) -> light_Lit {
    loop {
        let run = (*cursor).run;
        let start = (*cursor).at;
        if !(start < run.end) {
            if light_textured_next_run(cursor, path) {
                continue;
            }
            return light_dark();
        }
        let lattice = light_textured_lattice(cursor);
        let mark = light_lattice_position(lattice, path, (*cursor).number);
        if !(mark > start) {
            (*cursor).number += 1.0;
            continue;
        }
        var end = min(mark, run.end);
        let is_inside = (*cursor).place == light_textured_INSIDE;
        if is_inside {
            let rim = select(vec2(light_FAR), (*cursor).rim, (*cursor).rim > vec2(start));
            end = min(end, min(rim.x, rim.y));
        }
        (*cursor).at = end;
        let middle = light_lattice_middle(lattice, path, start, end);
        let share = run.visibility * light_textured_colour(path, vec3(start, middle, end), is_inside);
        if any(share > vec3(0.0)) {
            return light_Lit(start, end, share);
        }
    }
    return light_dark();
}

// What there is in a box of voxels or a window of texels: the shader's side of
// `ShadowDag::visibility`, `ShadowDag::filter` and `ShadowDag::filter_bilinear`.
// All but the last division and the weights are integers, so that results are those of
// the CPU bit by bit.
//
// A walk goes through a box part by part. Parts that share nodes share the way down to
// them: each node above the masks of a window is read once.
//
// Needs `POINT` and what that needs.

// More levels than any grid has.
const dag_MOST_LEVELS: u32 = 18u;

struct dag_Walk {
    // The box, ends included.
    low: vec3<u32>,
    high: vec3<u32>,
    // Where the walk is: the node in cell `cell` of `level`, and on level 0 the next slice
    // of it. The walk ends when it would go above the level `start`.
    cell: vec3<u32>,
    level: u32,
    reference: u32,
    slice: u32,
    start: u32,
    done: bool,
    // The node on each level above, by which the walk came down.
    path: array<u32, dag_MOST_LEVELS>,
}

// Kinds of parts. There is no part left.
const dag_NO_PART: u32 = 0u;
// All voxels of it are lit, or all are shadowed.
const dag_UNIFORM_PART: u32 = 1u;
// Texels of one slice of one 8×8 tile; those whose bit of the mask is set are lit.
const dag_MASKED_PART: u32 = 2u;

struct dag_Part {
    kind: u32,
    low: vec3<u32>,
    high: vec3<u32>,
    // All ones for a uniform part that is lit, all zeros for one that is shadowed.
    mask: vec2<u32>,
}

// A walk through a box of the grid, ends included.
fn dag_walk(dag: dag_Shadows, low: vec3<u32>, high: vec3<u32>) -> dag_Walk {
    var walk: dag_Walk;
    walk.low = low;
    walk.high = high;
    walk.slice = low.z;
    walk.done = false;
    let shift = dag_top_level(dag) + 3u;
    let cell = low >> vec3(shift);
    if all(cell == high >> vec3(shift)) {
        walk.start = dag_top_level(dag);
        walk.reference = dag_top(dag, low);
        walk.cell = cell;
    } else {
        walk.start = dag_root_level(dag);
        walk.reference = dag.root;
        walk.cell = vec3(0u);
    }
    walk.level = walk.start;
    return walk;
}

// Goes on to the next sibling in the box, or to that of a node above.
fn dag_advance(dag: dag_Shadows, walk: ptr<function, dag_Walk>) {
    while (*walk).level < (*walk).start {
        let shift = vec3((*walk).level + 3u);
        let parent = (*walk).cell >> vec3(1u);
        let first = max((*walk).low >> shift, parent << vec3(1u));
        let last = min((*walk).high >> shift, (parent << vec3(1u)) + vec3(1u));
        var cell = (*walk).cell;
        if cell.x < last.x {
            cell.x += 1u;
        } else if cell.y < last.y {
            cell = vec3(first.x, cell.y + 1u, cell.z);
        } else if cell.z < last.z {
            cell = vec3(first.xy, cell.z + 1u);
        } else {
            (*walk).level += 1u;
            (*walk).cell = parent;
            continue;
        }
        let level = (*walk).level + 1u;
        let octant = (cell.z & 1u) << 2u | (cell.y & 1u) << 1u | (cell.x & 1u);
        (*walk).reference = dag_child(dag_node(dag, level, (*walk).path[level]), octant);
        (*walk).cell = cell;
        (*walk).slice = max((*walk).low.z, cell.z << shift.z);
        return;
    }
    (*walk).done = true;
}

// The next part; parts are met in no particular order.
fn dag_next_part(dag: dag_Shadows, walk: ptr<function, dag_Walk>) -> dag_Part {
    while !(*walk).done {
        let level = (*walk).level;
        let origin = (*walk).cell << vec3(level + 3u);
        let low = max((*walk).low, origin);
        let high = min((*walk).high, origin + vec3((8u << level) - 1u));
        let reference = (*walk).reference;
        if !dag_is_mixed(reference) {
            dag_advance(dag, walk);
            return dag_Part(dag_UNIFORM_PART, low, high, vec2(select(0u, 0xffffffffu, reference == dag_LIT)));
        }
        let node = dag_node(dag, level, reference);
        if level == 0u {
            let z = (*walk).slice;
            let slice = dag_child(node, z & 7u);
            if z < high.z {
                (*walk).slice = z + 1u;
            } else {
                dag_advance(dag, walk);
            }
            var part = dag_Part(dag_MASKED_PART, vec3(low.xy, z), vec3(high.xy, z), vec2(0u));
            if dag_is_mixed(slice) {
                part.mask = dag_mask(dag, slice);
            } else {
                part.kind = dag_UNIFORM_PART;
                part.mask = vec2(select(0u, 0xffffffffu, slice == dag_LIT));
            }
            return part;
        }
        (*walk).path[level] = reference;
        (*walk).reference = dag_child(node, dag_octant(level, low));
        (*walk).level = level - 1u;
        (*walk).cell = low >> vec3(level + 2u);
        (*walk).slice = low.z;
    }
    return dag_Part(dag_NO_PART, vec3(0u), vec3(0u), vec2(0u));
}

// The bits of rows `first` to `last` of four rows of a mask.
fn dag_rows(first: u32, last: u32) -> u32 {
    return (0xffffffffu >> (8u * (3u - (last - first)))) << (8u * first);
}

// The bits of a mask in the columns and rows from `low` to `high`, both 0…7,
// ends included.
fn dag_window(low: vec2<u32>, high: vec2<u32>) -> vec2<u32> {
    let row = ((0xffu >> (7u - (high.x - low.x))) << low.x) * 0x01010101u;
    var rows = vec2(0u);
    if low.y < 4u {
        rows.x = dag_rows(low.y, min(high.y, 3u));
    }
    if high.y >= 4u {
        rows.y = dag_rows(max(low.y, 4u) - 4u, high.y - 4u);
    }
    return vec2(row) & rows;
}

// The lit texels of a part of one slice in the window from `low` to `high`.
fn dag_lit_of_part(part: dag_Part, low: vec2<u32>, high: vec2<u32>) -> u32 {
    let first = max(low, part.low.xy);
    let last = min(high, part.high.xy);
    if any(first > last) {
        return 0u;
    }
    if part.kind == dag_UNIFORM_PART {
        let size = last - first + vec2(1u);
        return select(0u, size.x * size.y, part.mask.x != 0u);
    }
    let lit = countOneBits(part.mask & dag_window(first & vec2(7u), last & vec2(7u)));
    return lit.x + lit.y;
}

// What there is in a box, ends included: bit 0 for lit voxels, bit 1 for
// shadowed ones; outside of the grid as on the CPU.
fn dag_visibility(dag: dag_Shadows, first: vec3<i32>, last: vec3<i32>) -> u32 {
    if any(first > last) {
        return 1u;
    }
    let end = i32(dag_side(dag)) - 1;
    var seen = select(0u, 1u, any(first < vec3(0)) || any(last.xy > vec2(end)));
    let low = vec3(max(first.xy, vec2(0)), clamp(first.z, 0, end));
    let high = min(last, vec3(end));
    if any(low > high) {
        return seen;
    }
    var walk = dag_walk(dag, vec3<u32>(low), vec3<u32>(high));
    while seen != 3u {
        let part = dag_next_part(dag, &walk);
        if part.kind == dag_NO_PART {
            break;
        }
        var window = vec2(0xffffffffu);
        if part.kind == dag_MASKED_PART {
            window = dag_window(part.low.xy & vec2(7u), part.high.xy & vec2(7u));
        }
        seen |= select(0u, 1u, any((part.mask & window) != vec2(0u)));
        seen |= select(0u, 2u, any((~part.mask & window) != vec2(0u)));
    }
    return seen;
}

// A rectangle of the map: columns and rows, ends included. It is empty if an end lies
// before its beginning.
struct dag_Rect {
    low: vec2<i32>,
    high: vec2<i32>,
}

// 2^22: farther than any window that touches the map reaches, and small enough that sums of
// such texels are in range.
const dag_FAR_TEXEL: i32 = 4194304;

// The part of the window of `width` texels around a texel that is on the map.
fn dag_rect(dag: dag_Shadows, texel: vec2<i32>, width: u32) -> dag_Rect {
    let half = vec2(i32(width / 2u));
    let near = clamp(texel, vec2(-dag_FAR_TEXEL), vec2(dag_FAR_TEXEL));
    return dag_Rect(max(near - half, vec2(0)), min(near + half, vec2(i32(dag_side(dag)) - 1)));
}

fn dag_is_empty(rect: dag_Rect) -> bool {
    return any(rect.low > rect.high);
}

// How many of the `width × width` voxels around a voxel, in its slice, are lit.
// `width` is odd and at most 65535.
fn dag_count_lit(dag: dag_Shadows, voxel: vec3<i32>, width: u32) -> u32 {
    let rect = dag_rect(dag, voxel.xy, width);
    if voxel.z < 0 || dag_is_empty(rect) {
        return width * width;
    }
    let low = vec2<u32>(rect.low);
    let high = vec2<u32>(rect.high);
    let size = high - low + vec2(1u);
    // Texels beside the map count as lit.
    var lit = width * width - size.x * size.y;
    let z = min(u32(voxel.z), dag_side(dag) - 1u);
    var walk = dag_walk(dag, vec3(low, z), vec3(high, z));
    loop {
        let part = dag_next_part(dag, &walk);
        if part.kind == dag_NO_PART {
            break;
        }
        lit += dag_lit_of_part(part, low, high);
    }
    return lit;
}

// The lit share of the `width × width` voxels around a voxel, in its slice.
fn dag_filter(dag: dag_Shadows, voxel: vec3<i32>, width: u32) -> f32 {
    return f32(dag_count_lit(dag, voxel, width)) / f32(width * width);
}

// The numbers of lit texels in the windows of `width` around four neighbours: (x, y),
// (x + 1, y), (x, y + 1) and (x + 1, y + 1). One walk counts all four.
fn dag_count_four(dag: dag_Shadows, voxel: vec3<i32>, width: u32) -> vec4<u32> {
    var rects: array<dag_Rect, 4>;
    var lit: vec4<u32>;
    var low = vec2(dag_FAR_TEXEL);
    var high = vec2(-1);
    for (var i = 0u; i < 4u; i += 1u) {
        let rect = dag_rect(dag, voxel.xy + vec2(i32(i & 1u), i32(i >> 1u)), width);
        rects[i] = rect;
        lit[i] = width * width;
        if !dag_is_empty(rect) {
            let size = vec2<u32>(rect.high - rect.low) + vec2(1u);
            lit[i] -= size.x * size.y;
            low = min(low, rect.low);
            high = max(high, rect.high);
        }
    }
    if any(low > high) {
        return lit;
    }
    let z = min(u32(voxel.z), dag_side(dag) - 1u);
    var walk = dag_walk(dag, vec3(vec2<u32>(low), z), vec3(vec2<u32>(high), z));
    loop {
        let part = dag_next_part(dag, &walk);
        if part.kind == dag_NO_PART {
            break;
        }
        for (var i = 0u; i < 4u; i += 1u) {
            if !dag_is_empty(rects[i]) {
                lit[i] += dag_lit_of_part(part, vec2<u32>(rects[i].low), vec2<u32>(rects[i].high));
            }
        }
    }
    return lit;
}

// The lit share of a window that is `width` texels wide and centred at a position exactly,
// in its slice: bilinear between the windows around the four nearest texels. A position
// that is infinite or NaN is lit.
fn dag_filter_bilinear(dag: dag_Shadows, position: vec3<f32>, width: u32) -> f32 {
    if any((bitcast<vec3<u32>>(position) & vec3(0x7f800000u)) == vec3(0x7f800000u)) {
        return 1.0;
    }
    let corner = floor(position.xy - vec2(0.5));
    let weight = position.xy - vec2(0.5) - corner;
    let far = f32(dag_FAR_TEXEL);
    let voxel = clamp(vec3(corner, floor(position.z)), vec3(-far), vec3(far));
    if voxel.z < 0.0 {
        return 1.0;
    }
    let share = vec4<f32>(dag_count_four(dag, vec3<i32>(voxel), width)) / f32(width * width);
    let rows = share.xz * (1.0 - weight.x) + share.yw * weight.x;
    return rows.x * (1.0 - weight.y) + rows.y * weight.y;
}

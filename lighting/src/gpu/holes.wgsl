// Fills the holes of shadow maps by pull-push: entry points. One invocation per
// texel of a level of the pyramids, each of which belongs to one picture.
//
// Needs the part face.wgsl.

// Two levels, one above the other.
struct Levels {
    pictures: u32,
    fine_side: u32,
    coarse_side: u32,
    // Where they begin in `pyramid`.
    fine_first: u32,
    coarse_first: u32,
    // Not 0 if the fine level is that of the pictures themselves.
    is_picture: u32,
    padding_a: u32,
    padding_b: u32,
}

// See `shadow_map/holes.rs`.
const TOGETHER: f32 = 1.25;

@group(0) @binding(0) var<uniform> levels: Levels;
@group(0) @binding(1) var<storage, read_write> depths: array<f32>;
@group(0) @binding(2) var<storage, read_write> pyramid: array<f32>;

fn belong_together(a: f32, b: f32) -> bool {
    return max(a, b) < light_EMPTY && max(a, b) <= TOGETHER * min(a, b);
}

// The mean of two depths if they belong together, else the nearer one.
fn together(a: f32, b: f32) -> f32 {
    return select(min(a, b), 0.5 * (a + b), belong_together(a, b));
}

// Three quarters of `here` plus a quarter of `beside` if they belong together, else `here`.
fn nearer(here: f32, beside: f32) -> f32 {
    return select(here, 0.5 * (here + 0.5 * (here + beside)), belong_together(here, beside));
}

fn fine_at(picture: u32, column: u32, row: u32) -> f32 {
    let side = levels.fine_side;
    let i = (picture * side + row) * side + column;
    if levels.is_picture != 0u {
        return depths[i];
    }
    return pyramid[levels.fine_first + i];
}

fn coarse_at(picture: u32, column: u32, row: u32) -> f32 {
    let side = levels.coarse_side;
    return pyramid[levels.coarse_first + (picture * side + row) * side + column];
}

// Makes a texel of the coarser level from the square of up to four below it. It is filled if
// at least half of them are.
@compute @workgroup_size(64)
fn pull(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    let side = levels.coarse_side;
    if i >= levels.pictures * side * side {
        return;
    }
    let picture = i / (side * side);
    let first = 2u * vec2(i % side, i / side % side);
    var found = array(light_EMPTY, light_EMPTY, light_EMPTY, light_EMPTY);
    var there = 0u;
    var filled = 0u;
    for (var k = 0u; k < 4u; k += 1u) {
        let at = first + vec2(k % 2u, k / 2u);
        if all(at < vec2(levels.fine_side)) {
            found[k] = fine_at(picture, at.x, at.y);
            there += 1u;
            filled += select(0u, 1u, found[k] < light_EMPTY);
        }
    }
    var depth = light_EMPTY;
    if 2u * filled >= there {
        depth = together(together(found[0], found[1]), together(found[2], found[3]));
    }
    pyramid[levels.coarse_first + i] = depth;
}

// Fills an empty texel of the finer level from the coarser one above it and from those of
// its neighbours that are closest to the texel.
@compute @workgroup_size(64)
fn push(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    let side = levels.fine_side;
    if i >= levels.pictures * side * side {
        return;
    }
    let picture = i / (side * side);
    let at = vec2(i % side, i / side % side);
    if fine_at(picture, at.x, at.y) < light_EMPTY {
        return;
    }
    let above = at / 2u;
    let before = max(above, vec2(1u)) - 1u;
    let behind = min(above + 1u, vec2(levels.coarse_side - 1u));
    let beside = select(behind, before, at % 2u == vec2(0u));
    let here = coarse_at(picture, above.x, above.y);
    if !(here < light_EMPTY) {
        return;
    }
    let across = nearer(here, coarse_at(picture, beside.x, above.y));
    let other = coarse_at(picture, above.x, beside.y);
    let corner = coarse_at(picture, beside.x, beside.y);
    let depth = nearer(across, nearer(other, corner));
    if levels.is_picture != 0u {
        depths[i] = depth;
    } else {
        pyramid[levels.fine_first + i] = depth;
    }
}

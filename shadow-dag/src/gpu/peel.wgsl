// Where the rays of a tile of texels enter and leave solids: entry point, one
// invocation per texel.
//
// The surfaces under a texel are peeled off from near to far, LAYERS of them in each
// pass over the triangles of its block, until the ray is outside of all solids
// again. Whether a triangle covers the centre of a texel is decided on the grid to which
// corners are snapped, in integers of 64 bits, as on the CPU.

struct Parameters {
    // The centre of the first texel of the tile, on the grid, and the distance from one
    // texel to the next.
    first: vec2<i32>,
    step: i32,
    // Texels along each side of the tile, and of a block.
    side: u32,
    block: u32,
    // The number of slices.
    slices: f32,
    // For logarithmic slices, the depth at which they begin and ln(far/near); 0 for linear
    // ones.
    near: f32,
    stretch: f32,
}

// Kinds of triangles, in the order in which they come at the same depth: the ray enters a
// solid, meets a surface that encloses nothing, leaves a solid.
const FRONT: u32 = 0u;
const OPEN: u32 = 1u;
const BACK: u32 = 2u;

struct Triangle {
    a: vec2<i32>,
    b: vec2<i32>,
    c: vec2<i32>,
    kind: u32,
    // By how much nearer a front face is sorted than it is.
    nearer: f32,
    // Depth of the first corner, and how much deeper the other two are.
    depth: f32,
    deeper_b: f32,
    deeper_c: f32,
    // The inverse of twice the area.
    inverse_area: f32,
    // The least and the greatest depth of the corners.
    least: f32,
    most: f32,
    padding_a: f32,
    padding_b: f32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> triangles: array<Triangle>;
// Where the list of triangles of each block begins, and where the last one ends.
@group(0) @binding(2) var<storage> starts: array<u32>;
@group(0) @binding(3) var<storage> lists: array<u32>;
// The slices at which a ray enters solids and at which it leaves them. Voxels between the two
// may be lit or shadowed; those behind are shadowed.
@group(0) @binding(4) var<storage, read_write> texels: array<vec2<u32>>;

// A number of 64 bits, two's complement.
struct Wide {
    low: u32,
    high: u32,
}

fn negative(a: Wide) -> Wide {
    let low = ~a.low + 1u;
    return Wide(low, ~a.high + select(0u, 1u, low == 0u));
}

fn difference(a: Wide, b: Wide) -> Wide {
    return Wide(a.low - b.low, a.high - b.high - select(0u, 1u, a.low < b.low));
}

// From products of halves with 16 bits, as WGSL has no product of 64 bits.
fn product(a: i32, b: i32) -> Wide {
    let x = u32(abs(a));
    let y = u32(abs(b));
    let low = (x & 0xffffu) * (y & 0xffffu);
    // Factors below 2³⁰ leave room for the carries.
    let middle = (x >> 16u) * (y & 0xffffu) + (low >> 16u);
    let other = (x & 0xffffu) * (y >> 16u) + (middle & 0xffffu);
    let high = (x >> 16u) * (y >> 16u) + (middle >> 16u) + (other >> 16u);
    let wide = Wide(other << 16u | (low & 0xffffu), high);
    if (a < 0) != (b < 0) {
        return negative(wide);
    }
    return wide;
}

// The edge function of the edge between two corners at a point: positive at
// its left side.
fn edge(start: vec2<i32>, end: vec2<i32>, at: vec2<i32>) -> Wide {
    let along = end - start;
    let to = at - start;
    return difference(product(to.y, along.x), product(to.x, along.y));
}

// Whether a point with this value of an edge's function is inside of the edge. A point on
// the edge is inside of top and left ones, so that neighbours do not share it.
fn is_inside(value: Wide, start: vec2<i32>, end: vec2<i32>) -> bool {
    let along = end - start;
    if (value.low | value.high) == 0u {
        return along.y < 0 || (along.y == 0 && along.x > 0);
    }
    return (value.high >> 31u) == 0u;
}

// The nearest f32 or so, of a number that is not negative.
fn rounded(a: Wide) -> f32 {
    return f32(a.high) * 4294967296.0 + f32(a.low);
}

// A surface under a texel. Surfaces come in the order of their ranks, at the same rank in
// that of their kinds, and those of one kind in that of the list.
struct Hit {
    rank: f32,
    depth: f32,
    kind: u32,
    number: u32,
}

fn comes_before(a: Hit, b: Hit) -> bool {
    if a.rank != b.rank {
        return a.rank < b.rank;
    }
    if a.kind != b.kind {
        return a.kind < b.kind;
    }
    return a.number < b.number;
}

// How many surfaces one pass peels off.
const LAYERS: u32 = 8u;
// A depth behind everything.
const NOTHING: f32 = 3.40282346e38;

// Depths are off by at most (|depth| + 5 range) · 2⁻²⁴, where the range is that of the
// triangle's depths, so that surfaces that touch may seem to be twice that apart.
const ROUNDING: f32 = 2.0 / 16777216.0;

// Whether a triangle covers a point of the grid, and its depth there.
fn is_over(triangle: Triangle, at: vec2<i32>, depth: ptr<function, f32>) -> bool {
    let ab = edge(triangle.a, triangle.b, at);
    let bc = edge(triangle.b, triangle.c, at);
    let ca = edge(triangle.c, triangle.a, at);
    let over = is_inside(ab, triangle.a, triangle.b)
        && is_inside(bc, triangle.b, triangle.c)
        && is_inside(ca, triangle.c, triangle.a);
    if over {
        // No weight is negative, so nothing cancels.
        let b = rounded(ca) * triangle.inverse_area;
        let c = rounded(ab) * triangle.inverse_area;
        let plane = triangle.depth + (b * triangle.deeper_b + c * triangle.deeper_c);
        *depth = clamp(plane, triangle.least, triangle.most);
    }
    return over;
}

// What a surface adds to the number of solids that the ray is in.
fn sign_of(kind: u32) -> i32 {
    return 1 - i32(kind);
}

// The first slice whose middle is not in front of a depth.
fn slice(depth: f32) -> u32 {
    var position = depth;
    if parameters.stretch > 0.0 {
        // Depths are −1/distance here; 0 is infinitely far away.
        if depth >= 0.0 {
            return u32(parameters.slices);
        }
        // near/distance, at most 1.
        let nearness = min(-depth, 1.0 / parameters.near) * parameters.near;
        position = -log(max(nearness, 1e-37)) / parameters.stretch;
    }
    let boundary = parameters.slices * clamp(position, 0.0, 1.0) - 0.5;
    return u32(max(ceil(boundary), 0.0));
}

@compute @workgroup_size(64)
fn peel(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    let side = parameters.side;
    if i >= side * side {
        return;
    }
    // Invocations go block by block, so that neighbours share a list.
    let size = parameters.block;
    let block = i / (size * size);
    let within = i % (size * size);
    let across = side / size;
    let texel = vec2(block % across, block / across) * size + vec2(within % size, within / size);
    let at = parameters.first + vec2<i32>(texel) * parameters.step;
    let out = texel.y * side + texel.x;
    let start = starts[block];
    let end = starts[block + 1u];

    let none = u32(parameters.slices);
    var enter = NOTHING;
    var inside = 0;
    // The last surface that has been peeled off.
    var last = Hit(-NOTHING, 0.0, 0u, 0u);
    for (var pass_number = 0u; ; pass_number += 1u) {
        var layers: array<Hit, LAYERS>;
        var count = 0u;
        var more = false;
        for (var k = start; k < end; k += 1u) {
            let triangle = triangles[lists[k]];
            var depth = 0.0;
            if !is_over(triangle, at, &depth) {
                continue;
            }
            var hit = Hit(depth, depth, triangle.kind, k);
            if triangle.kind == FRONT {
                let range = triangle.most - triangle.least;
                hit.rank -= triangle.nearer + ROUNDING * (abs(depth) + 5.0 * range);
            }
            if pass_number == 0u {
                enter = min(enter, depth);
                // A ray that leaves more often than it enters began inside.
                inside -= sign_of(triangle.kind);
            } else if !comes_before(last, hit) {
                continue;
            }
            var place = count;
            if count == LAYERS {
                more = true;
                if !comes_before(hit, layers[LAYERS - 1u]) {
                    continue;
                }
                place = LAYERS - 1u;
            } else {
                count += 1u;
            }
            while place > 0u && comes_before(hit, layers[place - 1u]) {
                layers[place] = layers[place - 1u];
                place -= 1u;
            }
            layers[place] = hit;
        }
        if pass_number == 0u {
            if count == 0u {
                texels[out] = vec2(none);
                return;
            }
            if inside > 0 {
                enter = -NOTHING;
            }
        }
        for (var k = 0u; k < count; k += 1u) {
            last = layers[k];
            inside += sign_of(last.kind);
            if inside <= 0 || last.kind == OPEN {
                let first = slice(enter);
                texels[out] = vec2(first, max(slice(last.depth), first));
                return;
            }
        }
        if !more {
            texels[out] = vec2(slice(enter), none);
            return;
        }
    }
}

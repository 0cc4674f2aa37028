// Makes the min–max trees of the slices of a fan: entry point. One workgroup per slice.
//
// Needs the parts face.wgsl and fan.wgsl.

struct Build {
    fan: light_Fan,
    // Its number: 4 × picture + 2 × (cells are rows) + (the fan's side is at the last cell).
    index: u32,
    resolution: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> build: Build;
@group(0) @binding(1) var<storage> bounds: array<vec2<f32>>;
@group(0) @binding(2) var<storage, read_write> nodes: array<vec2<f32>>;

// How many texels a slice is wider than its lines, on either side, for rounding.
const MARGIN: f32 = 0.0625;

// The range, across the cells, in which the lines of a slice cross the border in front of a
// cell; in texels.
fn across(slice: u32, border: i32) -> vec2<f32> {
    let fan = build.fan;
    let n = f32(build.resolution);
    let is_last = (build.index & 1u) != 0u;
    let side = select(-1.0, 1.0, is_last);
    let scale = 1.0 / (fan.eye.x - side * fan.eye.z);
    var range = vec2(light_EMPTY, -light_EMPTY);
    var x = 2.0 * f32(border) / n - 1.0;
    // Lines begin at the eye.
    if fan.eye.z != 0.0 {
        let begin = fan.eye.x / fan.eye.z;
        x = select(min(x, begin), max(x, begin), is_last);
    }
    for (var j = 0u; j < 2u; j++) {
        let meets = fan.first + f32(slice + j) / fan.density;
        let y = (meets * (fan.eye.x - x * fan.eye.z) + fan.eye.y * (x - side)) * scale;
        let texel = 0.5 * n * (1.0 + y);
        range = vec2(min(range.x, texel), max(range.y, texel));
    }
    return range;
}

// The least and the greatest depth that rays of a slice may meet in a leaf.
fn leaf_node(slice: u32, leaf: u32) -> vec2<f32> {
    let n = build.resolution;
    let last = f32(n - 1u);
    var node = vec2(light_EMPTY, 0.0);
    let number = build.fan.first_cell + (leaf << light_LEAF);
    if number >= n {
        return node;
    }
    let ends = vec2(number, min(number + (1u << light_LEAF), n) - 1u);
    let one = light_from_side(build.index, i32(ends.x), n);
    let two = light_from_side(build.index, i32(ends.y), n);
    let cells = vec2(min(one, two), max(one, two));
    let near = across(slice, cells.x);
    let far = across(slice, cells.y + 1);
    let low = u32(clamp(floor(min(near.x, far.x) - MARGIN), 0.0, last));
    let high = u32(clamp(floor(max(near.y, far.y) + MARGIN), 0.0, last));
    let per_side = (n + (1u << light_BLOCK) - 1u) >> light_BLOCK;
    let kind = build.index / 2u * per_side * n;
    for (var block = u32(cells.x) >> light_BLOCK; block <= u32(cells.y) >> light_BLOCK; block++) {
        for (var k = low; k <= high; k++) {
            let own = bounds[kind + block * n + k];
            node = vec2(min(node.x, own.x), max(node.y, own.y));
        }
    }
    return node;
}

@compute @workgroup_size(64)
fn build_trees(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let slice = workgroup.y * workgroups.x + workgroup.x;
    let is_one = slice < build.fan.slices;
    let leaves = 1u << build.fan.height;
    let root = build.fan.nodes + min(slice, build.fan.slices - 1u) * 2u * leaves;
    if is_one {
        for (var leaf = local; leaf < leaves; leaf += 64u) {
            nodes[root + leaves + leaf] = leaf_node(slice, leaf);
        }
    }
    for (var count = leaves / 2u; count > 0u; count /= 2u) {
        storageBarrier();
        if is_one {
            for (var i = count + local; i < 2u * count; i += 64u) {
                let a = nodes[root + 2u * i];
                let b = nodes[root + 2u * i + 1u];
                nodes[root + i] = vec2(min(a.x, b.x), max(a.y, b.y));
            }
        }
    }
}

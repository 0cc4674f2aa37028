// Makes a level of the quadtree of a light volume: entry point. One invocation per node.
//
// Needs the parts face.wgsl and mesh.wgsl.

struct Level {
    mesh: light_volume_Layout,
    level: u32,
    // The number of nodes of the level, of all pictures.
    nodes: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> record: Level;
@group(0) @binding(1) var<storage> heights: array<f32>;
// The least and the greatest height of a node; in the opposite order for a patch, which two
// triangles approximate.
@group(0) @binding(2) var<storage, read_write> nodes: array<vec2<f32>>;

fn first_node(level: u32) -> u32 {
    return record.mesh.first[level / 4u][level % 4u];
}

fn height(face: u32, cell: vec2<i32>) -> f32 {
    return heights[light_volume_vertex(record.mesh.resolution, face, cell)];
}

// Whether all vertices of a square of cells are within the tolerance of two triangles.
fn is_flat(face: u32, cell: vec2<i32>, size: i32) -> bool {
    let corners = vec4(
        height(face, cell),
        height(face, cell + vec2(size, 0)),
        height(face, cell + vec2(0, size)),
        height(face, cell + size),
    );
    let kind = light_volume_triangles(corners);
    for (var j = 0; j <= size; j++) {
        for (var i = 0; i <= size; i++) {
            let at = vec2(f32(i), f32(j)) / f32(size);
            let vertex = height(face, cell + vec2(i, j));
            let plane = light_volume_plane(kind, corners, at);
            let off = abs(plane.x + plane.y * at.x + plane.z * at.y - vertex);
            let width = light_volume_width(record.mesh.width, vertex);
            if !(off <= record.mesh.tolerance * width) {
                return false;
            }
        }
    }
    return true;
}

@compute @workgroup_size(64)
fn find_nodes(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = gpu_index(workgroup, workgroups, local, 64u);
    if index >= record.nodes {
        return;
    }
    let level = record.level;
    let side = light_volume_side(record.mesh.resolution, level);
    let face = index / side / side;
    let at = vec2(index % side, index / side % side);
    var least = light_EMPTY;
    var greatest = -light_EMPTY;
    var flat = level <= light_volume_LARGEST_PATCH;
    if level == 1u {
        for (var k = 0u; k < 9u; k++) {
            let vertex = height(face, vec2<i32>(2u * at + vec2(k % 3u, k / 3u)));
            least = min(least, vertex);
            greatest = max(greatest, vertex);
        }
    } else {
        let finer = light_volume_side(record.mesh.resolution, level - 1u);
        for (var k = 0u; k < 4u; k++) {
            let child = 2u * at + vec2(k & 1u, k >> 1u);
            if all(child < vec2(finer)) {
                let node = nodes[first_node(level - 1u) + (face * finer + child.y) * finer + child.x];
                least = min(least, min(node.x, node.y));
                greatest = max(greatest, max(node.x, node.y));
                flat = flat && node.x >= node.y;
            }
        }
    }
    if flat && greatest < light_EMPTY && is_flat(face, vec2<i32>(at << vec2(level)), 1i << level) {
        nodes[first_node(level) + index] = vec2(greatest, least);
    } else {
        nodes[first_node(level) + index] = vec2(least, greatest);
    }
}

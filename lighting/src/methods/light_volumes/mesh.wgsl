// The mesh of a light volume: the shader's side of `mesh.rs`.

const light_volume_LARGEST_PATCH: u32 = 6u;
const light_volume_NEAREST: f32 = 1e-15;
const light_volume_STEEP: f32 = 16.0;

// Kinds of patches, see `Kind`.
const light_volume_NOTHING: u32 = 0u;
const light_volume_FALLING: u32 = 1u;
const light_volume_RISING: u32 = 2u;
const light_volume_WALL: u32 = 3u;

// How the vertices and nodes of a mesh lie in memory; see `Layout`.
struct light_volume_Layout {
    width: vec2<f32>,
    tolerance: f32,
    resolution: u32,
    pictures: u32,
    levels: u32,
    padding_a: u32,
    padding_b: u32,
    // The first node of each level.
    first: array<vec4<u32>, 5>,
}

// The width of a texel at the distance of a vertex, in the unit of heights.
fn light_volume_width(width: vec2<f32>, height: f32) -> f32 {
    return width.x + width.y * abs(height);
}

// The number of nodes of a level along a side.
fn light_volume_side(resolution: u32, level: u32) -> u32 {
    return (resolution >> level) + 1u;
}

// The index of the vertex at the lower corner of a cell; beyond the border that of the
// nearest vertex.
fn light_volume_vertex(resolution: u32, face: u32, cell: vec2<i32>) -> u32 {
    let at = vec2<u32>(clamp(cell - 1, vec2(0), vec2(i32(resolution) - 1)));
    return (face * resolution + at.y) * resolution + at.x;
}

// Which of the two ways to divide a square joins the corners that are more alike.
fn light_volume_triangles(corners: vec4<f32>) -> u32 {
    let is_falling = abs(corners.x - corners.w) <= abs(corners.y - corners.z);
    return select(light_volume_RISING, light_volume_FALLING, is_falling);
}

// The height at the first corner of a square and the slopes of the surface at a place of the
// square, from (0, 0) to (1, 1).
fn light_volume_plane(kind: u32, corners: vec4<f32>, at: vec2<f32>) -> vec3<f32> {
    let a = corners.x;
    let b = corners.y;
    let c = corners.z;
    let d = corners.w;
    switch kind {
        case light_volume_FALLING: {
            if at.x >= at.y {
                return vec3(a, b - a, d - b);
            }
            return vec3(a, d - c, c - a);
        }
        case light_volume_RISING: {
            if at.x + at.y <= 1.0 {
                return vec3(a, b - a, c - a);
            }
            return vec3(b + (c - d), d - c, d - b);
        }
        case light_volume_WALL: {
            let row = select(corners.xy, corners.zw, at.y >= 0.5);
            return vec3(select(row.x, row.y, at.x >= 0.5), 0.0, 0.0);
        }
        default: {
            return vec3(light_EMPTY, 0.0, 0.0);
        }
    }
}

// Between the depths of a renderer's shadow map and distances along light rays; see
// `DepthViews`. Needs no other part.

// Where a view with this matrix shows a light ray: x and y from (0, 0) in the upper left
// corner of the texture to (1, 1) in the lower right, and 1. The third number is 0 for rays
// beside the view and behind it.
fn vsv_depth_place(matrix: mat4x4<f32>, origin: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let at = matrix * vec4(origin, 1.0) + matrix * vec4(direction, 0.0);
    if !(at.w > 0.0 && abs(at.x) <= at.w && abs(at.y) <= at.w) {
        return vec3(0.0);
    }
    return vec3(0.5 + 0.5 * at.x / at.w, 0.5 - 0.5 * at.y / at.w, 1.0);
}

// The distance along a light ray at which a view with this matrix sees the depth `depth`, in
// lengths of the direction.
fn vsv_depth_distance(matrix: mat4x4<f32>, origin: vec3<f32>, direction: vec3<f32>, depth: f32) -> f32 {
    let base = (matrix * vec4(origin, 1.0)).zw;
    let along = (matrix * vec4(direction, 0.0)).zw;
    return (depth * base.y - base.x) / (along.x - depth * along.y);
}

// The layer of a cube map that a direction from its middle points at; layers are in the order
// +x, −x, +y, −y, +z, −z.
fn vsv_cube_face(direction: vec3<f32>) -> u32 {
    let size = abs(direction);
    if size.x >= size.y && size.x >= size.z {
        return select(0u, 1u, direction.x < 0.0);
    }
    if size.y >= size.z {
        return select(2u, 3u, direction.y < 0.0);
    }
    return select(4u, 5u, direction.z < 0.0);
}

// Lookup in a shadow map: the shader's side of `ShadowMap`.
//
// Needs
//   fn light_map_faces() -> u32
//   fn light_map_resolution() -> u32
//   fn light_map_face(index: u32) -> light_Face
//   fn light_map_depth(index: u32) -> f32

// Depth of a texel in which the light sees nothing: f32::MAX.
const light_EMPTY: f32 = 0x1.fffffep+127;

// Which of six faces a direction points at, in the order +X −X +Y −Y +Z −Z.
fn light_cube_face(v: vec3<f32>) -> u32 {
    let a = abs(v);
    if a.x >= a.y && a.x >= a.z {
        return select(0u, 1u, v.x < 0.0);
    }
    if a.y >= a.z {
        return select(2u, 3u, v.y < 0.0);
    }
    return select(4u, 5u, v.z < 0.0);
}

// The face that shows what lies along v from the light.
fn light_face_along(v: vec3<f32>) -> u32 {
    if light_map_faces() > 1u {
        return light_cube_face(v);
    }
    return 0u;
}

// The depth of the texel in which a face shows its origin plus `v`; light_EMPTY
// outside of the picture.
fn light_depth_along(index: u32, face: light_Face, v: vec3<f32>) -> f32 {
    var plane = vec2(dot(v, face.right), dot(v, face.up));
    if face.tan > 0.0 {
        let z = dot(v, face.forward);
        if z <= 0.0 {
            return light_EMPTY;
        }
        plane *= 1.0 / (z * face.tan);
    } else {
        plane /= vec2(face.half_width, face.half_height);
    }
    let side = light_map_resolution();
    let texel = 0.5 * f32(side) * vec2(1.0 + plane.x, 1.0 - plane.y);
    let n = f32(side);
    if !(texel.x >= 0.0 && texel.x <= n && texel.y >= 0.0 && texel.y <= n) {
        return light_EMPTY;
    }
    // The far border belongs to the last texel.
    let at = min(vec2<u32>(texel), vec2(side - 1u));
    return light_map_depth((index * side + at.y) * side + at.x);
}

fn light_is_lit(point: vec3<f32>) -> bool {
    // One origin for all faces.
    let v = point - light_map_face(0u).origin;
    let index = light_face_along(v);
    let face = light_map_face(index);
    let depth = select(dot(v, face.forward), length(v), face.tan > 0.0);
    return depth <= light_depth_along(index, face, v);
}

// The distance along a ray of the light to the first blocker; light_EMPTY if there
// is none.
fn light_first_blocker(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let first = light_map_face(0u);
    if first.tan > 0.0 {
        let index = light_face_along(direction);
        return light_depth_along(index, light_map_face(index), direction);
    }
    let v = origin - first.origin;
    let depth = light_depth_along(0u, first, v);
    return select(light_EMPTY, depth - dot(v, first.forward), depth < light_EMPTY);
}

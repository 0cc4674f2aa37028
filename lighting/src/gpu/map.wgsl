// Lookup in a shadow map: the shader's side of `ShadowMap::is_lit`.
//
// Needs
//   fn light_map_faces() -> u32
//   fn light_map_resolution() -> u32
//   fn light_map_face(index: u32) -> light_Face
//   fn light_map_depth(index: u32) -> f32

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

fn light_is_lit(point: vec3<f32>) -> bool {
    var index = 0u;
    if light_map_faces() > 1u {
        index = light_cube_face(point - light_map_face(0u).origin);
    }
    let face = light_map_face(index);
    let v = point - face.origin;
    let z = dot(v, face.forward);
    var plane = vec2(dot(v, face.right), dot(v, face.up));
    var depth = z;
    if face.tan > 0.0 {
        if z <= 0.0 {
            return true;
        }
        plane *= 1.0 / (z * face.tan);
        depth = length(v);
    } else {
        plane /= vec2(face.half_width, face.half_height);
    }
    let side = light_map_resolution();
    let texel = 0.5 * f32(side) * vec2(1.0 + plane.x, 1.0 - plane.y);
    let n = f32(side);
    if !(texel.x >= 0.0 && texel.x <= n && texel.y >= 0.0 && texel.y <= n) {
        return true;
    }
    // The far border belongs to the last texel.
    let at = min(vec2<u32>(texel), vec2(side - 1u));
    return depth <= light_map_depth((index * side + at.y) * side + at.x);
}

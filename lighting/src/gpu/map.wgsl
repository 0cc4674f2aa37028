// Lookup in a shadow map: the shader's side of `ShadowMap`.
//
// Needs the parts face.wgsl and place.wgsl and the variables
//   light_map: light_Pictures
//   light_map_depths: array<f32>, face by face, row by row

// The depth of the texel in which a face shows its origin plus `v`; light_EMPTY
// outside of the picture.
fn light_depth_along(index: u32, face: light_Face, v: vec3<f32>) -> f32 {
    let side = light_map.resolution;
    let texel = light_texel_along(face, side, v);
    if texel.x < 0.0 {
        return light_EMPTY;
    }
    // The far border belongs to the last texel.
    let at = min(vec2<u32>(texel), vec2(side - 1u));
    return light_map_depths[(index * side + at.y) * side + at.x];
}

fn light_map_visibility(point: vec3<f32>) -> vec3<f32> {
    // One origin for all faces.
    let v = point - light_map.faces[0].origin;
    let index = light_face_along(light_map.face_count, v);
    let face = light_map.faces[index];
    return vec3(select(0.0, 1.0, light_depth_of(face, v) <= light_depth_along(index, face, v)));
}

// The distance along a light ray to its first blocker, m; light_EMPTY if there is none.
fn light_map_first_blocker(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let first = light_map.faces[0];
    if first.tan > 0.0 {
        let index = light_face_along(light_map.face_count, direction);
        return light_depth_along(index, light_map.faces[index], direction);
    }
    let v = origin - first.origin;
    let depth = light_depth_along(0u, first, v);
    return select(light_EMPTY, depth - dot(v, first.forward), depth < light_EMPTY);
}

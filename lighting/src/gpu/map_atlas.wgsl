// Lookup in the shadow maps of many lights: the shader's side of `TileMaps`.
//
// Needs the parts face.wgsl, place.wgsl and octahedron.wgsl, and the variables
//   light_maps_side: u32                          texels per side of a picture
//   light_maps_faces: array<light_AtlasFace>
//   light_maps_tiles: array<vec2<u32>>            the first face, and the number of faces or
//                                                 the kind of picture
//   light_maps_depths: array<f32>                 picture by picture, row by row

// Stands for the picture of a face that has none.
const light_NO_PICTURE: u32 = 0xffffffffu;

struct light_AtlasFace {
    face: light_Face,
    picture: u32,
}

// The depth of the texel in which a face shows its origin plus `v`.
fn light_maps_depth_along(at: u32, v: vec3<f32>) -> f32 {
    return light_maps_depth_at(at, light_texel_along(light_maps_faces[at].face, light_maps_side, v));
}

// The depth of a texel of a face.
fn light_maps_depth_at(at: u32, texel: vec2<f32>) -> f32 {
    let picture = light_maps_faces[at].picture;
    let side = light_maps_side;
    if picture == light_NO_PICTURE || texel.x < 0.0 {
        return light_EMPTY;
    }
    // The far border belongs to the last texel.
    let inside = min(vec2<u32>(texel), vec2(side - 1u));
    return light_maps_depths[(picture * side + inside.y) * side + inside.x];
}

// The distance along a ray of a tile's light to its first blocker, m; light_EMPTY if there is
// none.
fn light_maps_first_blocker_of(tile: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let faces = light_maps_tiles[tile];
    let first = light_maps_faces[faces.x].face;
    if faces.y == light_HEMISPHERE || faces.y == light_SPHERE {
        let texel = light_octahedral(first, faces.y, light_maps_side, direction);
        return light_maps_depth_at(faces.x, texel);
    }
    if first.tan > 0.0 {
        return light_maps_depth_along(faces.x + light_face_along(faces.y, direction), direction);
    }
    let v = origin - first.origin;
    let depth = light_maps_depth_along(faces.x, v);
    return select(light_EMPTY, depth - dot(v, first.forward), depth < light_EMPTY);
}

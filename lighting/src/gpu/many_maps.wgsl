// Shadow maps of several lights, filtered on surfaces: the shader's side of
// `FilteredMapsOfMany`.
//
// Needs the parts face.wgsl and place.wgsl, light_number() for the number of the light, and
// the variables
//   light_many_maps: array<light_MapOfMany>
//   light_many_maps_depths: array<f32>    picture after picture, each row by row
//   light_many_maps_half: u32             texels on either side of the filter's middle

struct light_MapOfMany {
    pictures: light_Pictures,
    // The number of its first picture among those of all lights.
    first: u32,
    // How much farther than half a filter's width points are lifted along their normal, in
    // texels.
    bias: f32,
    padding_a: u32,
    padding_b: u32,
}

// How wide a texel is at the light's origin plus v, m; 0 behind the light.
fn light_many_maps_texel(face: light_Face, side: u32, v: vec3<f32>) -> f32 {
    var half = max(face.half_width, face.half_height);
    if face.tan > 0.0 {
        half = face.tan * max(dot(v, face.forward), 0.0);
    }
    return 2.0 * half / f32(side);
}

fn light_many_maps_on_surface(point: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let light = light_number();
    let face_count = light_many_maps[light].pictures.face_count;
    if face_count == 0u {
        return vec3(1.0);
    }
    let side = light_many_maps[light].pictures.resolution;
    let half = i32(light_many_maps_half);
    let width = 2.0 * f32(half) + 1.0;
    var v = point - light_many_maps[light].pictures.faces[0].origin;
    let near = light_many_maps[light].pictures.faces[light_face_along(face_count, v)];
    v += light_many_maps_texel(near, side, v) * (0.5 * width + light_many_maps[light].bias) * normal;
    let index = light_face_along(face_count, v);
    let face = light_many_maps[light].pictures.faces[index];
    let texel = light_texel_along(face, side, v);
    if texel.x < 0.0 {
        return vec3(1.0);
    }
    let depth = light_depth_of(face, v);
    let picture = light_many_maps[light].first + index;
    let last = i32(side) - 1;
    let middle = vec2<i32>(texel);
    var lit = 0u;
    for (var y = middle.y - half; y <= middle.y + half; y++) {
        let row = (picture * side + u32(clamp(y, 0, last))) * side;
        for (var x = middle.x - half; x <= middle.x + half; x++) {
            lit += select(0u, 1u, depth <= light_many_maps_depths[row + u32(clamp(x, 0, last))]);
        }
    }
    return vec3(f32(lit) / (width * width));
}

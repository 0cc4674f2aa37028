// The mean share of light along a short interval: the shader's side of `MomentPyramid`.
//
// Needs the part lookup.wgsl, whose level is the finest one, and the variable
//   light_pyramid: light_Pyramid

struct light_Pyramid {
    // Where the moments of each level begin, the finest first.
    firsts: array<vec4<u32>, 5>,
    count: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// The length, in texels of the picture, of an interval `along` whose middle is at the origin
// of a face plus `v`.
fn light_pyramid_texels(face: light_Face, v: vec3<f32>, along: vec3<f32>) -> f32 {
    var way = vec2(dot(along, face.right), dot(along, face.up));
    if face.tan > 0.0 {
        let depth = dot(v, face.forward);
        let towards = dot(along, face.forward) / depth;
        let at = vec2(dot(v, face.right), dot(v, face.up));
        way = (way - at * towards) * (1.0 / (depth * face.tan));
    } else {
        way /= vec2(face.half_width, face.half_height);
    }
    return 0.5 * f32(light_moments.pictures.resolution) * length(way);
}

fn light_moments_between(start: vec3<f32>, end: vec3<f32>) -> vec3<f32> {
    // One origin for all faces.
    let v = 0.5 * (start + end) - light_moments.pictures.faces[0].origin;
    let index = light_face_along(light_moments.pictures.face_count, v);
    let face = light_moments.pictures.faces[index];
    let texel = light_texel_along(face, light_moments.pictures.resolution, v);
    if texel.x < 0.0 {
        return vec3(1.0);
    }
    // One level finer than the interval is long: the exponent of its length, less one.
    let texels = light_pyramid_texels(face, v, end - start);
    let exponent = i32(bitcast<u32>(texels) >> 23u) - 127;
    let finest = i32(light_moments.level);
    let number = u32(clamp(exponent - 1 - finest, 0, i32(light_pyramid.count) - 1));
    let level = light_moments.level + number;
    let side = (light_moments.pictures.resolution + (1u << level) - 1u) >> level;
    let first = light_pyramid.firsts[number / 4u][number % 4u];
    let z = light_level_depth(light_moments, light_depth_of(face, v));
    return vec3(light_moments_in(light_MomentTexels(first, level, side), index, texel, z));
}

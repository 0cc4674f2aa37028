// Lookup in a map of transmittance: the shader's side of `TransmittanceMap`.
//
// Needs the parts place.wgsl and those of `transmittance::gpu::lookup_parts`, and
// the variables
//   light_curves: light_Pictures
//   light_curve_words: array<u32>, the curves face by face; with curves for each colour, all
//   faces of red first, then those of green and of blue

// Texels per side of the filter; 0 for the nearest texel.
override SIDE: u32 = 1u;
// Words of the curves of a face.
override FACE_WORDS: u32 = 0u;
// Whether red, green and blue have curves of their own.
override COLOURS: bool = false;

// The first word of the face that is asked.
var<private> light_curve_face: u32;

fn avsm_word(index: u32) -> u32 {
    return light_curve_words[light_curve_face + index];
}

fn light_curves_visibility(point: vec3<f32>) -> vec3<f32> {
    if light_curves.face_count == 0u {
        return vec3(1.0);
    }
    // One origin for all faces.
    let v = point - light_curves.faces[0].origin;
    let index = light_face_along(light_curves.face_count, v);
    let face = light_curves.faces[index];
    let texel = light_texel_along(face, light_curves.resolution, v);
    if texel.x < 0.0 {
        return vec3(1.0);
    }
    light_curve_face = index * FACE_WORDS;
    let extent = vec2(light_curves.resolution);
    let depth = light_depth_of(face, v);
    let red = avsm_filtered(extent, texel, depth, SIDE)[0];
    if !COLOURS {
        return vec3(red);
    }
    let words = light_curves.face_count * FACE_WORDS;
    light_curve_face += words;
    let green = avsm_filtered(extent, texel, depth, SIDE)[0];
    light_curve_face += words;
    return vec3(red, green, avsm_filtered(extent, texel, depth, SIDE)[0]);
}

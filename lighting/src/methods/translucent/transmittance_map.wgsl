// Lookup in a map of transmittance: the shader's side of `TransmittanceMap`.
//
// Needs the parts place.wgsl and those of `transmittance::gpu::lookup_parts`, and
// the variables
//   light_curves: light_CurveMap
//   light_curve_words: array<u32>, the curves face by face; with curves for each colour, all
//   faces of red first, then those of green and of blue

struct light_CurveMap {
    // As if each face had a single texel.
    pictures: light_Pictures,
    // Texels per side of a face, and the first word of its curves.
    places: array<vec4<u32>, 6>,
}

// Texels per side of the filter; 0 for the nearest texel.
override SIDE: u32 = 1u;
// Words of the curves of all faces in one colour.
override COLOUR_WORDS: u32 = 0u;
// Whether red, green and blue have curves of their own.
override COLOURS: bool = false;

// The first word of the face that is asked.
var<private> light_curve_face: u32;

fn avsm_word(index: u32) -> u32 {
    return light_curve_words[light_curve_face + index];
}

fn light_curves_visibility(point: vec3<f32>) -> vec3<f32> {
    if light_curves.pictures.face_count == 0u {
        return vec3(1.0);
    }
    // One origin for all faces.
    let v = point - light_curves.pictures.faces[0].origin;
    let index = light_face_along(light_curves.pictures.face_count, v);
    let face = light_curves.pictures.faces[index];
    let share = light_texel_along(face, light_curves.pictures.resolution, v);
    if share.x < 0.0 {
        return vec3(1.0);
    }
    let place = light_curves.places[index];
    let extent = vec2(place.x);
    let texel = share * f32(place.x);
    light_curve_face = place.y;
    let depth = light_depth_of(face, v);
    let red = avsm_filtered(extent, texel, depth, SIDE)[0];
    if !COLOURS {
        return vec3(red);
    }
    light_curve_face += COLOUR_WORDS;
    let green = avsm_filtered(extent, texel, depth, SIDE)[0];
    light_curve_face += COLOUR_WORDS;
    return vec3(red, green, avsm_filtered(extent, texel, depth, SIDE)[0]);
}

// The approximate width of a texel at a point that the light sees, m; 0 without casters.
fn light_curves_texel_size(point: vec3<f32>) -> f32 {
    if light_curves.pictures.face_count == 0u {
        return 0.0;
    }
    let v = point - light_curves.pictures.faces[0].origin;
    let index = light_face_along(light_curves.pictures.face_count, v);
    let face = light_curves.pictures.faces[index];
    let parallel = max(face.half_width, face.half_height);
    let half = 0.5 * f32(light_curves.places[index].x);
    return select(parallel, face.tan * length(v), face.tan > 0.0) / half;
}

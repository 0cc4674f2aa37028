// Where the curves of a map of transmittance are found when this crate assembles
// the shader: face after face. Needs map_faces.wgsl.

override BILINEAR: bool = true;
// Words of the curves of a face.
override FACE_WORDS: u32 = 0u;

@group(1) @binding(1) var<storage> curves: array<u32>;

// The first word of the face that is looked at.
var<private> first_word: u32;

fn light_veil_face(index: u32) {
    first_word = index * FACE_WORDS;
}

fn light_veil_is_bilinear() -> bool {
    return BILINEAR;
}

fn avsm_word(index: u32) -> u32 {
    return curves[first_word + index];
}

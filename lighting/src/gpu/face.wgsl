// A picture plane of a light, with its view: the shader's side of `Face`.

// The depth of a texel in which the light sees nothing: f32::MAX.
const light_EMPTY: f32 = 0x1.fffffep+127;

struct light_Face {
    origin: vec3<f32>,
    // 0 for parallel rays, else the tangent of half the opening angle.
    tan: f32,
    right: vec3<f32>,
    half_width: f32,
    up: vec3<f32>,
    half_height: f32,
    forward: vec3<f32>,
    padding: f32,
}

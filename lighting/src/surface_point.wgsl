// A point of a surface: the shader's side of `SurfacePoint`.

struct light_SurfacePoint {
    position: vec3<f32>,
    // The share of the sky over it that is not covered.
    openness: f32,
    normal: vec3<f32>,
    padding_a: f32,
    // The radiance at the eye per unit of irradiance, 1/sr.
    response: vec3<f32>,
    padding_b: f32,
}

// A point of a surface: the shader's side of `SurfacePoint`.

struct light_SurfacePoint {
    position: vec3<f32>,
    // Share of the sky over it that is not covered.
    openness: f32,
    normal: vec3<f32>,
    padding_a: f32,
    // Radiance at the eye per unit of irradiance.
    response: vec3<f32>,
    padding_b: f32,
}

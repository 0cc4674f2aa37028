// The quadrature as the evaluator.

fn light_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    return light_quadrature(path, start, end);
}

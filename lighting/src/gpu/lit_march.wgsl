// A march through a shadow map: steps are lit or not. Needs map.wgsl.

fn light_march_visibility(point: vec3<f32>) -> f32 {
    return select(0.0, 1.0, light_is_lit(point));
}

// Visibility at a point: nothing is in the way of the light.

fn light_unshadowed_visibility(point: vec3<f32>) -> vec3<f32> {
    return vec3(1.0);
}

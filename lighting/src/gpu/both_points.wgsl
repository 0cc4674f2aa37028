// The share of the light that gets to a point past the blockers of two sources; the shader's
// side of `Both` asked at points.
//
// Needs the slots of the two,
//   fn light_both_first_visibility(point: vec3<f32>) -> vec3<f32>
//   fn light_both_second_visibility(point: vec3<f32>) -> vec3<f32>

fn light_both_points_visibility(point: vec3<f32>) -> vec3<f32> {
    return light_both_first_visibility(point) * light_both_second_visibility(point);
}

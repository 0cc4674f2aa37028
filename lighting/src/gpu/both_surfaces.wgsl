// The share of the light that gets to a point of a surface past the blockers of two sources;
// the shader's side of `Both` asked about surfaces.
//
// Needs the slots of the two,
//   fn light_both_first_on_surface(point: vec3<f32>, normal: vec3<f32>) -> vec3<f32>
//   fn light_both_second_on_surface(point: vec3<f32>, normal: vec3<f32>) -> vec3<f32>

fn light_both_surfaces_on_surface(point: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let first = light_both_first_on_surface(point, normal);
    if !any(first > vec3(0.0)) {
        return first;
    }
    return first * light_both_second_on_surface(point, normal);
}

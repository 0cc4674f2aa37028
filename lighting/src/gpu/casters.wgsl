// Where the triangles of a light's casters have holes. The solid ones, which have none, come
// first, those with a mask after them.
//
// Needs the part mask.wgsl and the variable
//   light_solid_casters: u32, the number of solid triangles

fn light_casters_is_hole(triangle: u32, at: vec2<f32>) -> bool {
    if triangle < light_solid_casters {
        return false;
    }
    return light_mask_is_hole(triangle - light_solid_casters, at);
}

// Lookup in a map of transmittance: the shader's side of `TransmittanceMap`.
//
// Needs the parts place.wgsl and those of `transmittance::gpu::lookup_parts`, and
//   fn light_veil_face(index: u32)          chooses the face that avsm_word reads
//   fn light_veil_is_bilinear() -> bool

fn light_march_visibility(point: vec3<f32>) -> f32 {
    if light_map_faces() == 0u {
        return 1.0;
    }
    // One origin for all faces.
    let v = point - light_map_face(0u).origin;
    let index = light_face_along(v);
    let face = light_map_face(index);
    let texel = light_texel_along(face, v);
    if texel.x < 0.0 {
        return 1.0;
    }
    light_veil_face(index);
    let extent = vec2(light_map_resolution());
    return avsm_filtered(extent, texel, light_depth_of(face, v), light_veil_is_bilinear())[0];
}

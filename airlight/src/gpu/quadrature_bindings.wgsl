// A quadrature that is bound by itself. Needs the variables
//   air_quadrature: air_Quadrature
//   air_entries: array<vec4<f32>>

fn air_quadrature_uniforms() -> air_Quadrature {
    return air_quadrature;
}

fn air_quadrature_entry(index: u32) -> vec4<f32> {
    return air_entries[index];
}

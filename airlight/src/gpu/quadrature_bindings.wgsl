// A quadrature in a group of its own.

@group(1) @binding(0) var<uniform> air_quadrature: air_Quadrature;
@group(1) @binding(1) var<storage> air_entries: array<vec4<f32>>;

fn air_quadrature_uniforms() -> air_Quadrature {
    return air_quadrature;
}

fn air_quadrature_entry(index: u32) -> vec4<f32> {
    return air_entries[index];
}

fn air_airlight(sigma_t: f32, segment: air_Segment) -> f32 {
    return air_quadrature_airlight(sigma_t, segment);
}

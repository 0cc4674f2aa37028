// Where the quadrature finds its rules when this crate assembles the shader.

@group(2) @binding(0) var<uniform> quadrature: air_Quadrature;
@group(2) @binding(1) var<storage> quadrature_entries: array<vec4<f32>>;

fn air_quadrature_uniforms() -> air_Quadrature {
    return quadrature;
}

fn air_quadrature_entry(index: u32) -> vec4<f32> {
    return quadrature_entries[index];
}

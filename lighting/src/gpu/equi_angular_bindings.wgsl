// Where the quadrature finds its nodes when this crate assembles the shader.

@group(2) @binding(0) var<uniform> node_count: u32;
@group(2) @binding(1) var<storage> nodes: array<vec2<f32>>;

fn light_node_count() -> u32 {
    return node_count;
}

fn light_node(index: u32) -> vec2<f32> {
    return nodes[index];
}

// Where the depths of a shadow map are found when this crate assembles the
// shader. Needs map_faces.wgsl.

@group(1) @binding(1) var<storage> depth: array<f32>;

fn light_map_depth(index: u32) -> f32 {
    return depth[index];
}

// The triangles of a scene and their hierarchy: the shader's side of `UploadedTracer`.
//
// Needs the variables
//   light_exact: light_Exact
//   light_exact_nodes: array<light_exact_Node>, in the order of a walk
//   light_exact_corners: array<f32>, nine coordinates for each triangle

struct light_Exact {
    nodes: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

struct light_exact_Node {
    low: vec3<f32>,
    // Of an inner node, the node after its last descendant; of a leaf, its first triangle.
    link: u32,
    high: vec3<f32>,
    // Triangles of a leaf; 0 for an inner node.
    count: u32,
}

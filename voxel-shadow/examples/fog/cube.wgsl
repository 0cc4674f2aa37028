// The renderer's own shadow map: the boxes of the scene, drawn into a face of a cube.

struct Box {
    low: vec4<f32>,
    high: vec4<f32>,
}

@group(0) @binding(0) var<uniform> boxes: array<Box, 16>;
@group(0) @binding(1) var<uniform> face: mat4x4<f32>;

@vertex
fn vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> @builtin(position) vec4<f32> {
    // Two triangles of each of six sides.
    var corners = array<vec2<f32>, 6>(
        vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, 1.0), vec2(1.0, 0.0), vec2(1.0, 1.0),
    );
    let side = vertex / 6u;
    let corner = vec3(corners[vertex % 6u], f32(side & 1u));
    var share = corner;
    if side >= 4u {
        share = corner.zxy;
    } else if side >= 2u {
        share = corner.yzx;
    }
    let corners_of = boxes[instance];
    return face * vec4(mix(corners_of.low.xyz, corners_of.high.xyz, share), 1.0);
}

// The renderer's own shader of its surfaces: boxes lit by two lamps, one with a shadow map.

struct Box {
    low: vec4<f32>,
    high: vec4<f32>,
}

struct Lights {
    // The views of the faces of the first lamp's shadow map.
    faces: array<mat4x4<f32>, 6>,
    positions: array<vec4<f32>, 2>,
    // Radiant intensities, W/sr; the fourth number is the extinction of the fog, 1/m.
    intensities: array<vec4<f32>, 2>,
}

struct Vertex {
    @builtin(position) position: vec4<f32>,
    @location(0) point: vec3<f32>,
    @location(1) normal: vec3<f32>,
}

@group(0) @binding(0) var<uniform> boxes: array<Box, 16>;
@group(0) @binding(1) var<uniform> view: mat4x4<f32>;
@group(1) @binding(0) var<uniform> lights: Lights;
@group(1) @binding(1) var shadow_map: texture_depth_2d_array;

@vertex
fn vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Vertex {
    // Two triangles of each of six sides.
    var corners = array<vec2<f32>, 6>(
        vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, 1.0), vec2(1.0, 0.0), vec2(1.0, 1.0),
    );
    let side = vertex / 6u;
    var share = vec3(corners[vertex % 6u], f32(side & 1u));
    var normal = vec3(0.0, 0.0, 2.0 * share.z - 1.0);
    if side >= 4u {
        share = share.zxy;
        normal = normal.zxy;
    } else if side >= 2u {
        share = share.yzx;
        normal = normal.yzx;
    }
    let point = mix(boxes[instance].low.xyz, boxes[instance].high.xyz, share);
    return Vertex(view * vec4(point, 1.0), point, normal);
}

// Whether a point is lit by the first lamp. Depths are reversed.
fn is_lit(point: vec3<f32>) -> bool {
    for (var face = 0u; face < 6u; face++) {
        let clip = lights.faces[face] * vec4(point, 1.0);
        if clip.w > 0.0 && all(abs(clip.xy) <= vec2(clip.w)) {
            let at = vec2(0.5, -0.5) * clip.xy / clip.w + 0.5;
            let texels = vec2<f32>(textureDimensions(shadow_map));
            let depth = textureLoad(shadow_map, vec2<u32>(min(at * texels, texels - 1.0)), face, 0);
            return clip.z / clip.w > 0.98 * depth;
        }
    }
    return true;
}

@fragment
fn fragment(vertex: Vertex) -> @location(0) vec4<f32> {
    var radiance = vec3(0.0);
    for (var i = 0u; i < 2u; i++) {
        let to_light = lights.positions[i].xyz - vertex.point;
        let d = length(to_light);
        let cosine = max(dot(vertex.normal, to_light) / d, 0.0);
        if cosine > 0.0 && (i > 0u || is_lit(vertex.point)) {
            let light = lights.intensities[i];
            radiance += 0.1 * light.xyz * cosine / (d * d) * exp(-light.w * d);
        }
    }
    return vec4(radiance, 1.0);
}

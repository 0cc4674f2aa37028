// A lamp in a cage, in fog: for each pixel the lit parts of its ray, and how much light
// arrives from them.

struct Frame {
    eye: vec3<f32>,
    sigma_t: f32,
    lamp: vec3<f32>,
    sigma_s: f32,
    // The lamp's radiant intensity, W/sr.
    intensity: vec3<f32>,
    // The near plane of the shadow map, whose depths are `near` over the distance along an
    // axis.
    near: f32,
}

struct Box {
    low: vec4<f32>,
    high: vec4<f32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> boxes: array<Box, 16>;
@group(0) @binding(2) var<uniform> lattice: epi_Lattice;
@group(0) @binding(3) var<storage> bounds: array<vec2<f32>>;
@group(0) @binding(4) var<uniform> sampling: vsv_Sampling;
@group(0) @binding(5) var<storage> words: array<u32>;
@group(0) @binding(6) var<uniform> table: air_Table;
@group(0) @binding(7) var<storage> cells: array<vec4<u32>>;
@group(0) @binding(8) var shadow_map: texture_depth_2d_array;

// What the parts ask for: where their data is.
fn epi_bound(index: u32) -> vec2<f32> {
    return bounds[index];
}

fn vsv_word(index: u32) -> u32 {
    return words[index];
}

fn air_table_uniforms() -> air_Table {
    return table;
}

fn air_table_cell(index: u32) -> vec4<u32> {
    return cells[index];
}

// The distance to the nearest box along a ray, and the normal there.
fn surface(origin: vec3<f32>, direction: vec3<f32>) -> vec4<f32> {
    var nearest = vec4(vec3(0.0), air_FAR);
    for (var i = 0u; i < 16u; i += 1u) {
        let a = (boxes[i].low.xyz - origin) / direction;
        let b = (boxes[i].high.xyz - origin) / direction;
        let enter = min(a, b);
        let leave = max(a, b);
        let distance = max(enter.x, max(enter.y, enter.z));
        if distance > 0.0 && distance < min(leave.x, min(leave.y, leave.z)) && distance < nearest.w {
            nearest = vec4(-sign(direction) * vec3<f32>(enter >= vec3(distance)), distance);
        }
    }
    return nearest;
}

// Whether a point on a surface is lit, by the renderer's own map: the cube of its
// volumetric shadows, with the bias that the renderer has.
fn is_lit(from_lamp: vec3<f32>) -> bool {
    let face = vsv_cube_face(from_lamp);
    let size = abs(from_lamp);
    let along = max(size.x, max(size.y, size.z));
    // How the faces of cubes are turned: see `DepthViews::cube`.
    let across = array<vec2<f32>, 6>(
        vec2(-from_lamp.z, from_lamp.y), vec2(from_lamp.z, from_lamp.y), vec2(from_lamp.x, -from_lamp.z),
        vec2(from_lamp.x, from_lamp.z), vec2(from_lamp.x, from_lamp.y), vec2(-from_lamp.x, from_lamp.y),
    );
    var turned = across;
    let at = vec2(0.5, 0.5) + vec2(0.5, -0.5) * turned[face] / along;
    let texels = vec2<f32>(textureDimensions(shadow_map));
    let depth = textureLoad(shadow_map, vec2<u32>(min(at * texels, texels - 1.0)), face, 0);
    return frame.near / along > 0.98 * depth;
}

struct Pixel {
    @builtin(position) position: vec4<f32>,
    @location(0) screen: vec2<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Pixel {
    let corner = vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return Pixel(vec4(corner, 0.0, 1.0), corner);
}

@fragment
fn fragment(pixel: Pixel) -> @location(0) vec4<f32> {
    // A camera that looks along −z, as wide as it is high.
    let direction = normalize(vec3(0.7 * pixel.screen, -1.0));
    let hit = surface(frame.eye, direction);
    var radiance = vec3(0.0);
    if hit.w < air_FAR {
        let from_lamp = frame.eye + hit.w * direction - frame.lamp;
        let d = length(from_lamp);
        let cosine = max(-dot(hit.xyz, from_lamp) / d, 0.0);
        if cosine > 0.0 && is_lit(from_lamp) {
            radiance = 0.1 * frame.intensity * cosine / (d * d) * exp(-frame.sigma_t * (d + hit.w));
        }
    }
    let ray = air_segment(frame.eye, direction, frame.lamp, hit.w);
    var airlight = 0.0;
    var cursor = vsv_cursor(lattice, sampling, direction, hit.w);
    loop {
        let lit = vsv_next_lit(lattice, sampling, &cursor);
        if lit.visibility <= 0.0 {
            break;
        }
        airlight += lit.visibility * air_table_airlight(frame.sigma_t, air_part(ray, lit.start, lit.end));
    }
    radiance += frame.sigma_s * frame.intensity * airlight;
    return vec4(radiance, airlight);
}

// Draws the fog of a picture, pixel by pixel.

@group(0) @binding(0) var<uniform> size: vec2<u32>;
@group(0) @binding(1) var<storage> fog: array<vec4<f32>>;

// One triangle over all of the picture.
@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn draw(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = min(vec2<u32>(position.xy), size - 1u);
    return fog[pixel.y * size.x + pixel.x];
}

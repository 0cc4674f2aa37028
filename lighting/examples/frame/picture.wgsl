// The renderer's last pass: its surfaces through the fog.

@group(0) @binding(0) var surfaces: texture_2d<f32>;
// Radiance, and the transmittance as the fourth channel.
@group(0) @binding(1) var fog: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(position.xy);
    let air = textureLoad(fog, pixel, 0);
    let surface = textureLoad(surfaces, pixel, 0).rgb;
    // The green of the fog alone, for whoever wants to check it.
    return vec4(surface * air.a + air.rgb, air.g);
}

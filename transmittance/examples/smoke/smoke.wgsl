// Ground and a wall below smoke and within it: how much of the light from above gets to
// each of their points.

struct Light {
    low: vec2<f32>,
    size: f32,
    top: f32,
    texels: u32,
    room: u32,
    sigma_t: f32,
    padding: f32,
}

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<storage> words: array<u32>;

// What the parts ask for: where their data is.
fn avsm_word(index: u32) -> u32 {
    return words[index];
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
    // A camera at (0, 1.5, 4) that looks along −z: the ground is y = 0, the wall z = −0.2.
    let eye = vec3(0.0, 1.5, 4.0);
    let direction = vec3(0.5 * pixel.screen, -1.0);
    var point = eye + (eye.z + 0.2) * direction;
    var albedo = 0.9;
    if point.y < 0.0 {
        point = eye - eye.y / direction.y * direction;
        albedo = 0.6;
    }
    let position = (point.xz - light.low) / light.size * f32(light.texels);
    let share = avsm_filtered(vec2(light.texels), position, light.top - point.y, 1u)[0];
    return vec4(vec3(albedo * share), share);
}

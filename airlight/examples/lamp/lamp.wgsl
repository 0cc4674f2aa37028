// A lamp in fog over a floor, in one pass over the picture: what the floor sends and
// the fog lets through, and what the fog itself scatters towards the eye.

struct Frame {
    eye: vec3<f32>,
    sigma_t: f32,
    lamp: vec3<f32>,
    sigma_s: f32,
    // The lamp's radiant intensity, W/sr.
    intensity: vec3<f32>,
    padding: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> table: air_Table;
@group(0) @binding(2) var<storage> cells: array<vec4<u32>>;

// What the part TABLE asks for: where its data is.
fn air_table_uniforms() -> air_Table {
    return table;
}

fn air_table_cell(index: u32) -> vec4<u32> {
    return cells[index];
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
    var radiance = vec3(0.0);
    // The floor y = 0; above the horizon the ray never ends.
    var distance = air_FAR;
    if direction.y < 0.0 {
        distance = -frame.eye.y / direction.y;
        let to_lamp = frame.lamp - (frame.eye + distance * direction);
        let d = length(to_lamp);
        let irradiance = frame.intensity * (to_lamp.y / d) / (d * d);
        let albedo = 0.5;
        radiance = albedo / air_PI * irradiance * exp(-frame.sigma_t * (d + distance));
    }
    let segment = air_segment(frame.eye, direction, frame.lamp, distance);
    radiance += frame.sigma_s * frame.intensity * air_table_airlight(frame.sigma_t, segment);
    return vec4(radiance, 1.0);
}

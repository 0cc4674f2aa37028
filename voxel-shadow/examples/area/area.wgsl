// A lamp with a surface, in fog: its points have a grid each, and a pixel asks all of them.

struct Frame {
    eye: vec3<f32>,
    sigma_t: f32,
    // The radiant intensity of each point, W/sr.
    intensity: vec3<f32>,
    sigma_s: f32,
    // Points of the lamp, and the words and the bounds along φ of the tile of each.
    tiles: u32,
    words: u32,
    bounds: u32,
    padding: u32,
}

struct Box {
    low: vec4<f32>,
    high: vec4<f32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> boxes: array<Box, 16>;
@group(0) @binding(2) var<storage> lattices: array<epi_Lattice>;
@group(0) @binding(3) var<storage> bounds: array<vec2<f32>>;
@group(0) @binding(4) var<uniform> sampling: vsv_Sampling;
@group(0) @binding(5) var<storage> words: array<u32>;
@group(0) @binding(6) var<uniform> table: air_Table;
@group(0) @binding(7) var<storage> cells: array<vec4<u32>>;

// The tile that is asked now.
var<private> tile: u32;

// What the parts ask for: where their data is.
fn epi_bound(index: u32) -> vec2<f32> {
    return bounds[tile * frame.bounds + index];
}

fn vsv_word(index: u32) -> u32 {
    return words[tile * frame.words + index];
}

fn air_table_uniforms() -> air_Table {
    return table;
}

fn air_table_cell(index: u32) -> vec4<u32> {
    return cells[index];
}

// The distance to the nearest box along a ray.
fn surface(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    var nearest = air_FAR;
    for (var i = 0u; i < 16u; i += 1u) {
        let a = (boxes[i].low.xyz - origin) / direction;
        let b = (boxes[i].high.xyz - origin) / direction;
        let enter = min(a, b);
        let leave = max(a, b);
        let distance = max(enter.x, max(enter.y, enter.z));
        if distance > 0.0 && distance < min(leave.x, min(leave.y, leave.z)) {
            nearest = min(nearest, distance);
        }
    }
    return nearest;
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
    let distance = surface(frame.eye, direction);
    var airlight = 0.0;
    for (tile = 0u; tile < frame.tiles; tile += 1u) {
        let lattice = lattices[tile];
        let ray = air_segment(frame.eye, direction, lattice.light, distance);
        var cursor = vsv_cursor(lattice, sampling, direction, distance);
        loop {
            let lit = vsv_next_lit(lattice, sampling, &cursor);
            if lit.visibility <= 0.0 {
                break;
            }
            airlight += lit.visibility * air_table_airlight(frame.sigma_t, air_part(ray, lit.start, lit.end));
        }
    }
    return vec4(frame.sigma_s * frame.intensity * airlight, airlight / f32(frame.tiles));
}

// The block of lights that an entry point goes through, with their voxels, and the medium.

struct Block {
    medium: light_Medium,
    // How many rays or points there are.
    count: u32,
    lights: u32,
    // The first ray, and the factor on the light of all of them.
    first: u32,
    weight: f32,
}

struct Light {
    emitter: light_Emitter,
    voxels: light_Voxels,
    // Where the texels of its cookie, the bounds of its voxels along φ and the words of its
    // grid begin.
    first_texel: u32,
    first_bound: u32,
    first_word: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> block: Block;
@group(0) @binding(1) var<storage> lights: array<Light>;
@group(0) @binding(2) var<storage> cookies: array<vec4<f32>>;
@group(0) @binding(3) var<storage> bounds: array<vec2<f32>>;
@group(0) @binding(4) var<storage> words: array<u32>;

// The light that the functions below answer for.
var<private> current: u32;

fn light_emitter() -> light_Emitter {
    return lights[current].emitter;
}

fn light_medium() -> light_Medium {
    return block.medium;
}

fn light_cookie(index: u32) -> vec3<f32> {
    return cookies[lights[current].first_texel + index].xyz;
}

fn light_voxels() -> light_Voxels {
    return lights[current].voxels;
}

fn epi_bound(index: u32) -> vec2<f32> {
    return bounds[lights[current].first_bound + index];
}

fn vsv_word(index: u32) -> u32 {
    return words[lights[current].first_word + index];
}

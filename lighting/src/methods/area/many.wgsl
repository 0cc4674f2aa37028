// The airlight of a bundle of rays due to a block of lights: entry point. One
// invocation per ray goes through the lights.

struct Many {
    medium: light_Medium,
    rays: u32,
    lights: u32,
    // The first ray, and the factor on the light.
    first: u32,
    weight: f32,
}

struct Light {
    emitter: light_Emitter,
    voxels: light_Voxels,
    // Where the texels of its cookie, the bounds of its voxels along φ and its words
    // begin.
    first_texel: u32,
    first_bound: u32,
    first_word: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> many: Many;
@group(0) @binding(1) var<storage> rays: array<light_Ray>;
@group(0) @binding(2) var<storage> lights: array<Light>;
@group(0) @binding(3) var<storage> cookies: array<vec4<f32>>;
@group(0) @binding(4) var<storage> bounds: array<vec2<f32>>;
@group(0) @binding(5) var<storage> words: array<u32>;
@group(0) @binding(6) var<storage, read_write> radiance: array<vec4<f32>>;

// The light that all questions are about.
var<private> current: u32;

fn light_emitter() -> light_Emitter {
    return lights[current].emitter;
}

fn light_medium() -> light_Medium {
    return many.medium;
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

@compute @workgroup_size(64)
fn gather_many(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let number = gpu_index(workgroup, workgroups, local, 64u);
    if number >= many.rays {
        return;
    }
    let i = many.first + number;
    var sum = vec3(0.0);
    for (var light = 0u; light < many.lights; light += 1u) {
        current = light;
        let unmoved = light_path(rays[i], i);
        if !(unmoved.start < unmoved.end) {
            continue;
        }
        let path = light_off_the_light(unmoved);
        var cursor = light_cursor(path);
        loop {
            let part = light_next_lit(&cursor, path);
            if light_is_dark(part) {
                break;
            }
            sum += part.visibility * light_airlight(path, part.start, part.end);
        }
    }
    radiance[i] = vec4(radiance[i].xyz + many.weight * sum, radiance[i].w);
}

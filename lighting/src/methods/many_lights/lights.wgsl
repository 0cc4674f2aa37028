// Many lights in a table, and the current one, for which the functions below answer.
//
// Needs, from the entry point,
//   table: array<vec4<u32>>    the lights, MANY_LIGHT entries each; then the texels of
//                              their cookies
//   scene                      with the medium, and in `cookies` where the texels begin

// A light, and where its cookie begins among the texels of all cookies.
struct ManyLight {
    emitter: light_Emitter,
    cookie: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// Entries of the table for a ManyLight.
const MANY_LIGHT = 7u;

// The current light, and its number in the visibility source.
var<private> many_light: ManyLight;
var<private> many_number: u32;

fn light_emitter() -> light_Emitter {
    return many_light.emitter;
}

fn light_number() -> u32 {
    return many_number;
}

fn light_medium() -> light_Medium {
    return scene.medium;
}

fn light_cookie(index: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(table[scene.cookies + many_light.cookie + index].xyz);
}

fn many_light_at(light: u32) -> ManyLight {
    let at = MANY_LIGHT * light;
    let position = table[at];
    let intensity = table[at + 1u];
    let axis = table[at + 2u];
    let right = table[at + 3u];
    let up = table[at + 4u];
    let cookie = table[at + 5u];
    return ManyLight(
        light_Emitter(
            bitcast<vec3<f32>>(position.xyz),
            position.w,
            bitcast<vec3<f32>>(intensity.xyz),
            bitcast<f32>(intensity.w),
            bitcast<vec3<f32>>(axis.xyz),
            axis.w,
            bitcast<vec3<f32>>(right.xyz),
            bitcast<f32>(right.w),
            bitcast<vec3<f32>>(up.xyz),
            bitcast<f32>(up.w),
            cookie.x,
            cookie.y,
            bitcast<f32>(cookie.z),
            cookie.w,
        ),
        table[at + 6u].x,
        0u,
        0u,
        0u,
    );
}

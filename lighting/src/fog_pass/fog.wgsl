// The fog between the eye and the surfaces of a picture: entry point. One invocation per
// pixel.
//
// Needs a part with the depths, and the parts lights.wgsl and lit_parts.wgsl.

struct Scene {
    medium: light_Medium,
    eye: vec3<f32>,
    // The clip coordinate z of the eye.
    depth: f32,
    // The direction through a point of the picture is forward + x right + y up, with x and y
    // from −1 to 1. Its length is such that its clip coordinate w is 1. The fourth component
    // of these vectors gives its clip coordinate z in the same way.
    right: vec4<f32>,
    up: vec4<f32>,
    forward: vec4<f32>,
    size: vec2<u32>,
    // The depth of pixels in which nothing was drawn.
    empty: f32,
    // Where the fog ends, m from the eye.
    reach: f32,
    // The first light of this pass, and how many there are.
    first: u32,
    lights: u32,
    // Where the texels of cookies begin in the table.
    cookies: u32,
    // Whether earlier passes have left light here.
    adds: u32,
}

@group(0) @binding(0) var<uniform> scene: Scene;
// The lights, MANY_LIGHT entries each; then the texels of their cookies.
@group(0) @binding(2) var<storage> table: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> fog: array<vec4<f32>>;

// The distances of the surfaces in the pixel, one for each sample.
var<private> ends: array<f32, SAMPLES>;

// The distance of the surface with this depth, m, in the direction v, which has the length
// that `Scene` says.
//
// A point eye + w v has the depth (z₀ + w z₁) / w, where z₀ is the clip coordinate z of the
// eye and z₁ that of v.
fn distance_of(depth: f32, v: vec4<f32>) -> f32 {
    let distance = scene.depth / (depth - v.w) * length(v.xyz);
    let is_surface = depth != scene.empty && distance >= 0.0;
    return min(select(light_FAR, distance, is_surface), scene.reach);
}

// The airlight of a lit part of a ray: the mean over the samples, each of which sees the part
// only as far as its surface.
fn airlight_before(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    var sum = vec3(0.0);
    var begin = start;
    while begin < end {
        var to = end;
        var share = 0.0;
        for (var s = 0u; s < SAMPLES; s++) {
            if begin < ends[s] {
                share += 1.0 / f32(SAMPLES);
                to = min(to, ends[s]);
            }
        }
        if share <= 0.0 {
            break;
        }
        sum += share * light_airlight(path, begin, to);
        begin = to;
    }
    return sum;
}

fn light_of_part(path: light_Path, part: light_Lit) -> vec3<f32> {
    return part.visibility * airlight_before(path, part.start, part.end);
}

@compute @workgroup_size(8, 8)
fn gather_fog(@builtin(global_invocation_id) at: vec3<u32>) {
    let pixel = at.xy;
    if any(pixel >= scene.size) {
        return;
    }
    let i = pixel.y * scene.size.x + pixel.x;
    let share = (vec2<f32>(pixel) + 0.5) / vec2<f32>(scene.size);
    let v = scene.forward + (2.0 * share.x - 1.0) * scene.right + (1.0 - 2.0 * share.y) * scene.up;
    let direction = normalize(v.xyz);
    var farthest = 0.0;
    var transmittance = 0.0;
    for (var s = 0u; s < SAMPLES; s++) {
        ends[s] = distance_of(depth_of(pixel, s), v);
        farthest = max(farthest, ends[s]);
        let inside = light_length_inside(scene.eye, direction, ends[s]);
        // At an optical depth of 100 nothing is left.
        let depth = min(scene.medium.sigma_t.x * inside, 100.0);
        transmittance += exp(-depth) / f32(SAMPLES);
    }
    var sum = vec4(0.0, 0.0, 0.0, transmittance);
    if scene.adds != 0u {
        sum = fog[i];
    }
    let ray = light_Ray(scene.eye, farthest, direction, 0.0);
    for (var light = scene.first; light < scene.first + scene.lights; light++) {
        many_light = many_light_at(light);
        many_number = light;
        let path = light_path(ray, i);
        if path.start < path.end {
            sum += vec4(light_of_parts(light_off_the_light(path), true), 0.0);
        }
    }
    fog[i] = sum;
}

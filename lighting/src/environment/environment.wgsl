// An environment behind fog: what both entry points share.

struct Scene {
    medium: light_Medium,
    sky_width: u32,
    sky_height: u32,
    halo_width: u32,
    halo_height: u32,
    levels: u32,
    // The number of rays, or of surfaces.
    count: u32,
    // The way through fog for which the last level was made, m.
    longest: f32,
    // The way through fog without bounds, m; below 0 where a box of fog decides it.
    distance: f32,
}

@group(0) @binding(0) var<uniform> scene: Scene;

fn light_medium() -> light_Medium {
    return scene.medium;
}

// The part PATH needs a light; none is asked about here.
fn light_emitter() -> light_Emitter {
    return light_Emitter();
}

fn light_cookie(index: u32) -> vec3<f32> {
    return vec3(0.0);
}

// The four texels around a direction, and the bilinear weights of the right and lower ones.
struct Around {
    texels: vec4<u32>,
    part: vec2<f32>,
}

// Those of a map by longitude and latitude. Columns wrap, rows end at the poles.
fn around(width: u32, height: u32, direction: vec3<f32>) -> Around {
    let flat = length(direction.xz);
    let angle = light_angle(abs(direction.x), -direction.z);
    let longitude = select(angle, -angle, direction.x < 0.0);
    let latitude = light_angle(flat, direction.y);
    let size = vec2(f32(width), f32(height));
    let at = vec2(longitude / (2.0 * light_PI) + 0.5, latitude / light_PI) * size - 0.5;
    let base = floor(at);
    let w = i32(width);
    let left = u32((i32(base.x) + w) % w);
    let right = u32((i32(base.x) + 1 + w) % w);
    let top = u32(clamp(i32(base.y), 0, i32(height) - 1)) * width;
    let bottom = u32(clamp(i32(base.y) + 1, 0, i32(height) - 1)) * width;
    return Around(vec4(top + left, top + right, bottom + left, bottom + right), at - base);
}

// The way through fog from a point into a direction, m.
fn way_through(start: vec3<f32>, direction: vec3<f32>) -> f32 {
    if scene.distance >= 0.0 {
        return scene.distance;
    }
    return light_length_inside(start, direction, light_FAR);
}

// The two levels around a way through fog, and the share of the second. Levels are even in
// the root of the way.
fn level_of(way: f32) -> vec3<f32> {
    if scene.levels == 1u {
        return vec3(0.0);
    }
    let last = f32(scene.levels - 1u);
    let x = sqrt(min(way / scene.longest, 1.0)) * last;
    let first = min(floor(x), last - 1.0);
    return vec3(first, first + 1.0, x - first);
}

// The radiance that gets through fog: the environment dimmed, plus the halo that single
// scattering makes of it.
fn through(way: f32, clear: vec3<f32>, halo: vec3<f32>) -> vec3<f32> {
    let depth = scene.medium.sigma_t * way;
    return exp(-depth) * (clear + depth * halo);
}

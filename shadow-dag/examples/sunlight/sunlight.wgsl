// Ground and boxes in sunlight: how much of a 9 × 9 window of the sun's grid is lit around
// each of their points.

struct Box {
    low: vec4<f32>,
    high: vec4<f32>,
}

struct Sun {
    // Towards the sun, a unit vector.
    direction: vec3<f32>,
    // Texels along the side of the filter's window, odd.
    width: u32,
}

// What the eye sees in a pixel.
struct Surface {
    // Where to ask for its light.
    voxel: vec3<i32>,
    // Of the angle between its normal and the sun; below −1 for the sky.
    cosine: f32,
}

@group(0) @binding(0) var<storage, read_write> surfaces: array<Surface>;
@group(0) @binding(1) var<uniform> sun: Sun;
@group(0) @binding(2) var<uniform> shadows: dag_Shadows;
@group(0) @binding(3) var<storage> words: array<u32>;
@group(1) @binding(0) var<uniform> boxes: array<Box, 16>;
@group(1) @binding(1) var<uniform> space: dag_Space;

// What the parts ask for: where their data is.
fn dag_word(index: u32) -> u32 {
    return words[index];
}

// The voxel at which to ask for the light on a surface.
fn voxel_of(point: vec3<f32>, normal: vec3<f32>) -> vec3<i32> {
    let h = dag_homogeneous(space, vec4(point, 1.0));
    return dag_bias(dag_position(space, h), dag_normal(space, h, normal), sun.width);
}

// The distance to the nearest box along a ray, and the normal there.
fn surface(origin: vec3<f32>, direction: vec3<f32>) -> vec4<f32> {
    var nearest = vec4(vec3(0.0), dag_FAR);
    for (var i = 0u; i < 16u; i += 1u) {
        let a = (boxes[i].low.xyz - origin) / direction;
        let b = (boxes[i].high.xyz - origin) / direction;
        let enter = min(a, b);
        let leave = max(a, b);
        let distance = max(enter.x, max(enter.y, enter.z));
        if distance > 0.0 && distance < min(leave.x, min(leave.y, leave.z)) && distance < nearest.w {
            nearest = vec4(-sign(direction) * vec3<f32>(enter >= vec3(distance)), distance);
        }
    }
    return nearest;
}

// The renderer's geometry pass.
@compute @workgroup_size(8, 8)
fn find(@builtin(global_invocation_id) pixel: vec3<u32>) {
    let screen = (vec2<f32>(pixel.xy) + 0.5) / 256.0 * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    // A camera at (0, 5, 9) that looks down along (0, −0.5, −1).
    let eye = vec3(0.0, 5.0, 9.0);
    let direction = normalize(vec3(0.6 * screen.x, 0.6 * screen.y - 0.5, -1.0));
    let hit = surface(eye, direction);
    var found = Surface(vec3(0), -2.0);
    if hit.w < dag_FAR {
        found = Surface(voxel_of(eye + hit.w * direction, hit.xyz), dot(hit.xyz, sun.direction));
    }
    surfaces[pixel.y * 256u + pixel.x] = found;
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

// The lighting pass.
@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(position.xy);
    let seen = surfaces[pixel.y * 256u + pixel.x];
    if seen.cosine < -1.0 {
        return vec4(0.5, 0.6, 0.8, -1.0);
    }
    var share = 0.0;
    if seen.cosine > 0.0 {
        share = dag_filter(shadows, seen.voxel, sun.width);
    }
    return vec4(vec3(0.05) + 0.8 * max(seen.cosine, 0.0) * share, share);
}

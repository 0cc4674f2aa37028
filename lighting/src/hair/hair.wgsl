// The light of one lamp that points of strands send to the eye: entry point. One invocation
// per point.
//
// Needs the parts ARRIVING, HEIGHT_FOG of `scene` and fibre.wgsl, and the slots
//   fn light_hair_share(point: vec3<f32>) -> vec3<f32>          of strands and smoke
//   fn light_hair_texel_size(point: vec3<f32>) -> f32           of their map
//   fn light_shadow_ray_is_open(origin: vec3<f32>, direction: vec3<f32>, length: f32) -> bool

struct Scene {
    emitter: light_Emitter,
    medium: light_Medium,
    height: scn_HeightFog,
    points: u32,
    fibre: u32,
    // Whether there is fog that thins out with altitude.
    has_height: u32,
    // How far from the axis of a strand its map is asked, in texels.
    texels: f32,
}

// A point of a strand; the record `HairPoint`.
struct light_HairPoint {
    position: vec3<f32>,
    radius: f32,
    tangent: vec3<f32>,
    padding_a: u32,
    to_eye: vec3<f32>,
    padding_b: u32,
    colour: vec3<f32>,
    padding_c: u32,
    // The share of its light that reaches the eye.
    response: vec3<f32>,
    padding_d: u32,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var<storage> points: array<light_HairPoint>;
// The texels of the cookie.
@group(0) @binding(2) var<storage> table: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> scattered: array<vec4<f32>>;

fn light_emitter() -> light_Emitter {
    return scene.emitter;
}

fn light_medium() -> light_Medium {
    return scene.medium;
}

fn light_cookie(index: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(table[index].xyz);
}

fn scattered_by(point: light_HairPoint) -> vec3<f32> {
    let light = light_arriving_at(point.position);
    if !any(light.irradiance > vec3(0.0)) {
        return vec3(0.0);
    }
    let sent = light_fibre_radiance(
        scene.fibre,
        point.colour,
        point.tangent,
        light.to_light,
        point.to_eye,
    );
    if !any(sent > vec3(0.0)) {
        return vec3(0.0);
    }
    // The point must not lie beyond the light.
    let nearer = min(
        point.radius + scene.texels * light_hair_texel_size(point.position),
        0.5 * light.distance,
    );
    let share = light_hair_share(point.position + nearer * light.to_light);
    if !any(share > vec3(0.0)) {
        return vec3(0.0);
    }
    if !light_shadow_ray_is_open(point.position, light.to_light, light.distance) {
        return vec3(0.0);
    }
    var through = light.through;
    if scene.has_height != 0u {
        let y = point.position.y;
        let column = scn_height_column(scene.height, y, light.to_light.y, light.distance);
        // Shaders may assume that infinities do not occur.
        through *= exp(-min(scene.height.sigma_t * min(column, 1e18), vec3(scn_STEEP)));
    }
    return light.irradiance * sent * share * through;
}

@compute @workgroup_size(64)
fn scatter(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= scene.points {
        return;
    }
    let light = points[i].response * scattered_by(points[i]);
    scattered[i] += vec4(light, 0.0);
}

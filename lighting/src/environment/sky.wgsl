// The environment where rays meet no surface: entry point. One invocation per ray.

@group(0) @binding(1) var<storage> rays: array<light_Ray>;
@group(0) @binding(2) var<storage> sky: array<vec4<f32>>;
@group(0) @binding(3) var<storage> halos: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> radiance: array<vec4<f32>>;

fn halo_at(level: u32, at: Around) -> vec3<f32> {
    let start = level * scene.halo_width * scene.halo_height;
    let texels = at.texels + start;
    let top = mix(halos[texels.x].xyz, halos[texels.y].xyz, at.part.x);
    let bottom = mix(halos[texels.z].xyz, halos[texels.w].xyz, at.part.x);
    return mix(top, bottom, at.part.y);
}

@compute @workgroup_size(64)
fn add_sky(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= scene.count {
        return;
    }
    let ray = rays[i];
    if ray.length < light_FAR {
        return;
    }
    let here = around(scene.sky_width, scene.sky_height, ray.direction);
    let top = mix(sky[here.texels.x].xyz, sky[here.texels.y].xyz, here.part.x);
    let bottom = mix(sky[here.texels.z].xyz, sky[here.texels.w].xyz, here.part.x);
    let clear = mix(top, bottom, here.part.y);
    let way = way_through(ray.origin, ray.direction);
    let level = level_of(way);
    let at = around(scene.halo_width, scene.halo_height, ray.direction);
    let halo = mix(halo_at(u32(level.x), at), halo_at(u32(level.y), at), level.z);
    radiance[i] = vec4(radiance[i].xyz + through(way, clear, halo), radiance[i].w);
}

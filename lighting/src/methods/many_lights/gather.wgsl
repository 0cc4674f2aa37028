// The airlight of a bundle of rays due to many lights: entry point. One invocation per
// ray, tile by tile.
//
// Needs the parts lights.wgsl and lit_parts.wgsl.

struct Scene {
    medium: light_Medium,
    rays: u32,
    tiles: u32,
    // Whether lit parts that touch are joined before they are evaluated.
    joined: u32,
    // The number of the first light in the visibility source.
    first: u32,
    // The entries of each list that this dispatch gathers: the first, and how many at most.
    entry: u32,
    most: u32,
    // Where the texels of cookies begin in the table.
    cookies: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var<storage> rays: array<light_Ray>;
// The lights, MANY_LIGHT entries each; then the texels of their cookies.
@group(0) @binding(2) var<storage> table: array<vec4<u32>>;
// First where the list of each tile begins, and where the last one ends; then the number of
// each ray and its tile, tile by tile; then the lists.
@group(0) @binding(3) var<storage> lists: array<u32>;
@group(0) @binding(4) var<storage, read_write> radiance: array<vec4<f32>>;

fn light_of_part(path: light_Path, part: light_Lit) -> vec3<f32> {
    return part.visibility * light_airlight(path, part.start, part.end);
}

@compute @workgroup_size(64)
fn gather_many(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let place = gpu_index(workgroup, workgroups, local, 64u);
    if place >= scene.rays {
        return;
    }
    let i = lists[scene.tiles + 1u + 2u * place];
    let tile = lists[scene.tiles + 2u + 2u * place];
    let lights = scene.tiles + 1u + 2u * scene.rays;
    let begin = lists[tile];
    let count = lists[tile + 1u] - begin;
    let entry = min(scene.entry, count);
    let end = entry + min(scene.most, count - entry);
    var sum = radiance[i].xyz;
    for (var e = entry; e < end; e++) {
        let light = lists[lights + begin + e];
        many_light = many_light_at(light);
        many_number = scene.first + light;
        let path = light_path(rays[i], i);
        if path.start < path.end {
            sum += light_of_parts(light_off_the_light(path), scene.joined != 0u);
        }
    }
    radiance[i] = vec4(sum, radiance[i].w);
}

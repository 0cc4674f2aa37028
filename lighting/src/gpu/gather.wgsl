// The airlight of a bundle of rays: entry point. One invocation per ray.
//
// Needs the parts panes.wgsl and lit_parts.wgsl.

struct Scene {
    emitter: light_Emitter,
    medium: light_Medium,
    rays: u32,
    // The number in the frame of the first ray.
    first: u32,
    // Whether lit parts that touch are joined before they are evaluated.
    joined: u32,
    // Where in the table the panes in front of the eye begin; NO_PANES if there are none.
    panes: u32,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var<storage> rays: array<light_Ray>;
// The texels of the cookie, then the panes.
@group(0) @binding(2) var<storage> table: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4<f32>>;

fn light_emitter() -> light_Emitter {
    return scene.emitter;
}

fn light_medium() -> light_Medium {
    return scene.medium;
}

fn light_cookie(index: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(table[index].xyz);
}

// The next pane of the ray, the one after its last, and the share of light that the panes
// passed so far let through.
var<private> pane: u32;
var<private> panes_end: u32;
var<private> seen: vec3<f32>;

// The light of a lit part as it is seen through the panes, which cut it into pieces.
fn light_of_part(path: light_Path, part: light_Lit) -> vec3<f32> {
    var sum = vec3(0.0);
    var start = part.start;
    loop {
        var end = part.end;
        while pane < panes_end {
            let behind = pane_behind(pane);
            if behind.w > start {
                end = min(end, behind.w);
                break;
            }
            seen = behind.xyz;
            pane += 1u;
        }
        sum += seen * (part.visibility * light_airlight(path, start, end));
        start = end;
        if !(start < part.end) {
            return sum;
        }
    }
    return sum;
}

@compute @workgroup_size(64)
fn gather(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= scene.rays {
        return;
    }
    let unmoved = light_path(rays[i], scene.first + i);
    if !(unmoved.start < unmoved.end) {
        return;
    }
    let panes = panes_of(i);
    pane = panes.x;
    panes_end = panes.y;
    seen = vec3(1.0);
    let sum = light_of_parts(light_off_the_light(unmoved), scene.joined != 0u);
    radiance[i] = vec4(radiance[i].xyz + sum, radiance[i].w);
}

// The airlight of a bundle of rays: entry point. One invocation per ray.

struct Scene {
    emitter: light_Emitter,
    medium: light_Medium,
    rays: u32,
    // Number of the first ray in its frame.
    first: u32,
    // Whether lit parts that touch are joined before they are evaluated.
    joined: u32,
    // Where in the table the panes before the eye are; NO_PANES without any.
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
    let path = light_off_the_light(unmoved);
    var cursor = light_cursor(path);
    // The next pane, the one after the last, and what those before let through.
    let panes = panes_of(i);
    var pane = panes.x;
    var seen = vec3(1.0);
    // The last interval that was found and has not been evaluated yet.
    var part = light_dark();
    var sum = vec3(0.0);
    loop {
        let next = light_next_lit(&cursor, path);
        let is_last = light_is_dark(next);
        let is_same = all(next.visibility == part.visibility);
        if scene.joined != 0u && !is_last && is_same && next.start == part.end {
            part.end = next.end;
            continue;
        }
        if !light_is_dark(part) {
            var start = part.start;
            loop {
                var end = part.end;
                while pane < panes.y {
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
                    break;
                }
            }
        }
        if is_last {
            break;
        }
        part = next;
    }
    radiance[i] = vec4(radiance[i].xyz + sum, radiance[i].w);
}

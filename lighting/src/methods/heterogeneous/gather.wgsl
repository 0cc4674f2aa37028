// The light of one lamp that media scatter along a bundle of rays: entry point. One
// invocation per ray.

struct Scene {
    emitter: light_Emitter,
    // A medium without bounds, which the part PATH needs: the light may be anywhere.
    medium: light_Medium,
    rays: u32,
    steps: u32,
    // Where in the table the panes in front of the eye begin; NO_PANES if there are none.
    panes: u32,
    // Whether stretches of even fog may be wide, see `is_gentle`.
    is_gentle: u32,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var<uniform> light_media: light_Media;
@group(0) @binding(2) var<storage> rays: array<light_Ray>;
// The texels of the cookie, then the panes.
@group(0) @binding(3) var<storage> table: array<vec4<u32>>;
@group(0) @binding(4) var<storage> light_media_records: array<vec4<u32>>;
@group(0) @binding(5) var<storage> light_media_densities: array<f32>;
@group(0) @binding(6) var<storage> light_media_colours: array<f32>;
@group(0) @binding(7) var<storage, read_write> radiance: array<vec4<f32>>;

fn light_emitter() -> light_Emitter {
    return scene.emitter;
}

fn light_medium() -> light_Medium {
    return scene.medium;
}

fn light_cookie(index: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(table[index].xyz);
}

fn light_media_is_gentle() -> bool {
    return scene.is_gentle != 0u;
}

@compute @workgroup_size(64)
fn gather_media(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= scene.rays {
        return;
    }
    let unmoved = light_path(rays[i], i);
    if !(unmoved.start < unmoved.end) {
        return;
    }
    let path = light_off_the_light(unmoved);
    let last = min(path.end, light_media_END);
    let base = light_media_base(path.origin, path.direction, last);
    var walk = light_media_walk(path.origin, path.direction, base, last);
    let first = path.start - base;
    var steps = light_media_steps(path, &walk, base, first, walk.end, scene.steps);
    if all(steps.limits.lengths == vec2(0.0)) {
        return;
    }
    let panes = panes_of(i);
    var pane = panes.x;
    var goes_on = true;
    while goes_on && light_media_advance(&walk) {
        if walk.is_empty {
            continue;
        }
        var start = max(walk.start, first);
        while goes_on && start < walk.stop {
            var end = walk.stop;
            while pane < panes.y {
                let behind = pane_behind(pane);
                if behind.w - base > start {
                    end = min(end, behind.w - base);
                    break;
                }
                light_media_finish_part(path, &walk, &steps);
                light_media_finish_step(&walk, &steps);
                steps.seen = behind.xyz;
                pane += 1u;
            }
            if any(steps.seen > vec3(0.0)) {
                goes_on = light_media_add(path, &walk, &steps, start, end);
            } else {
                goes_on = pane < panes.y;
            }
            start = end;
        }
    }
    light_media_finish_part(path, &walk, &steps);
    light_media_finish_step(&walk, &steps);
    radiance[i] = vec4(radiance[i].xyz + steps.sum, radiance[i].w);
}

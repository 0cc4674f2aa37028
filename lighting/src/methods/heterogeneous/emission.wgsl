// The light that media emit along a bundle of rays: entry point. One invocation per
// ray. The shader's side of `emission.rs`, with fewer and longer parts, because some drivers
// end loops after 65,535 rounds per ray.

struct Scene {
    rays: u32,
    // Where in the table the panes in front of the eye begin; NO_PANES if there are none.
    panes: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var<uniform> light_media: light_Media;
@group(0) @binding(2) var<storage> rays: array<light_Ray>;
// The panes.
@group(0) @binding(3) var<storage> table: array<vec4<u32>>;
@group(0) @binding(4) var<storage> light_media_records: array<vec4<u32>>;
@group(0) @binding(5) var<storage> light_media_densities: array<f32>;
@group(0) @binding(6) var<storage> light_media_colours: array<f32>;
@group(0) @binding(7) var<storage, read_write> radiance: array<vec4<f32>>;

// The part PATH needs a light and a medium; none is asked about here.
fn light_emitter() -> light_Emitter {
    return light_Emitter();
}

fn light_medium() -> light_Medium {
    return light_Medium();
}

fn light_cookie(index: u32) -> vec3<f32> {
    return vec3(0.0);
}

// Behind this optical depth less than 1e-11 of the light is left, which counts as nothing.
const OPAQUE: f32 = 26.0;

// The largest growth of the optical depth over a part, and its largest deviation from a
// straight line in the middle of the part.
const PART_DEPTH: f32 = 1.0;
const PART_BEND: f32 = 0.1;

// Whether a medium on the piece emits, and whether emission and extinction are constant along
// the piece.
struct Emitting {
    emits: bool,
    is_even: bool,
}

fn emitting(walk: ptr<function, light_MediaWalk>) -> Emitting {
    let sigma = (*walk).sigma;
    let is_even = all(sigma[0] == sigma[1]) && all(sigma[0] == sigma[2]) && all(sigma[0] == sigma[3]);
    var found = Emitting(false, is_even && all(light_media.height.sigma_t == vec3(0.0)));
    for (var i = 0u; i < light_media.grids; i++) {
        if light_media_is_in((*walk).cells[i], (*walk).start) {
            let grid = light_media_grid(i);
            if grid.first_emission != light_media_NONE {
                found.emits = true;
                found.is_even = found.is_even && grid.grid.is_linear == 0u;
            }
        }
    }
    return found;
}

// The emission of all grids at a distance on the piece: radiance per metre.
fn emission(walk: ptr<function, light_MediaWalk>, length: f32) -> vec3<f32> {
    let x = (*walk).start + length;
    var sum = vec3(0.0);
    for (var i = 0u; i < light_media.grids; i++) {
        if light_media_is_in((*walk).cells[i], (*walk).start) {
            let grid = light_media_grid(i);
            if grid.first_emission != light_media_NONE {
                sum += light_media_colour(walk, grid.grid, i, grid.first_emission, x);
            }
        }
    }
    return sum;
}

// The light that a part of the piece emits, as seen from the start of that part. `start` and
// `to` are distances on the piece.
fn emitted(
    walk: ptr<function, light_MediaWalk>,
    is_even: bool,
    start: f32,
    to: f32,
) -> vec3<f32> {
    let before = light_media_own_depth(walk, start);
    let depth = light_media_own_depth(walk, to) - before;
    if is_even {
        let tau = clamp(depth, vec3(0.0), vec3(1e30));
        let mean = vec3(
            light_mean_exponential(tau.x),
            light_mean_exponential(tau.y),
            light_mean_exponential(tau.z),
        );
        return emission(walk, start) * ((to - start) * mean);
    }
    let first = emitted_through(walk, 0u, start, to);
    if all(depth == vec3(depth.x)) {
        return first;
    }
    return vec3(
        first.x,
        emitted_through(walk, 1u, start, to).y,
        emitted_through(walk, 2u, start, to).z,
    );
}

// ∫ exp(−τ(x)) j(x) dx with the optical depth of one channel, as a sum over parts.
fn emitted_through(
    walk: ptr<function, light_MediaWalk>,
    channel: u32,
    begin: f32,
    to: f32,
) -> vec3<f32> {
    let first = light_media_own_depth(walk, begin)[channel];
    var sum = vec3(0.0);
    var start = begin;
    var length = to - begin;
    while start < to {
        let before = light_media_own_depth(walk, start)[channel];
        if before - first > OPAQUE {
            break;
        }
        var end = min(start + length, to);
        loop {
            let middle = 0.5 * (start + end);
            let own = light_media_own_depth(walk, end)[channel] - before;
            let bend = light_media_own_depth(walk, middle)[channel] - before - 0.5 * own;
            let is_short = own <= PART_DEPTH && abs(bend) <= PART_BEND;
            // No float lies between the ends.
            if is_short || !(start < middle && middle < end) {
                break;
            }
            end = middle;
        }
        let middle = 0.5 * (start + end);
        let half = 0.5 * (end - start);
        // Gauss's rule of four nodes.
        for (var i = 0u; i < 4u; i++) {
            let is_outer = i >= 2u;
            let node = select(0.33998104, 0.86113631, is_outer);
            let weight = select(0.65214515, 0.34785485, is_outer);
            let x = middle + half * select(node, -node, (i & 1u) == 0u);
            let depth = light_media_own_depth(walk, x)[channel] - first;
            sum += (half * weight * exp(-clamp(depth, 0.0, 80.0))) * emission(walk, x);
        }
        length = 2.0 * (end - start);
        start = end;
    }
    return sum;
}

@compute @workgroup_size(64)
fn add_emission(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= scene.rays {
        return;
    }
    let ray = rays[i];
    let direction = normalize(ray.direction);
    let last = min(ray.length, light_media_END);
    let base = light_media_base(ray.origin, direction, last);
    var walk = light_media_walk(ray.origin, direction, base, last);
    let panes = panes_of(i);
    var pane = panes.x;
    var seen = vec3(1.0);
    var sum = vec3(0.0);
    while light_media_advance(&walk) {
        if min(walk.depth.x, min(walk.depth.y, walk.depth.z)) > OPAQUE {
            break;
        }
        let what = emitting(&walk);
        if !what.emits {
            continue;
        }
        var start = walk.start;
        let piece = start;
        while start < walk.stop {
            var end = walk.stop;
            while pane < panes.y {
                let behind = pane_behind(pane);
                if behind.w - base > start {
                    end = min(end, behind.w - base);
                    break;
                }
                seen = behind.xyz;
                pane += 1u;
            }
            let own = light_media_own_depth(&walk, start - piece);
            let before = light_media_exp(walk.depth + own);
            sum += seen * (before * emitted(&walk, what.is_even, start - piece, end - piece));
            start = end;
        }
    }
    radiance[i] = vec4(radiance[i].xyz + sum, radiance[i].w);
}

// The steps of a ray through media: the shader's side of `steps.rs`, with the same
// constants. The light is evaluated once on each part, in even fog at the nodes of Gauss's
// rule, and visibility is asked once for each step, which is a run of these.
//
// Needs walk.wgsl, the parts NUMERIC, PHASE and PATH, and the slot of the point visibility,
//   fn light_point_visibility(point: vec3<f32>) -> vec3<f32>
// and
//   fn light_media_is_gentle() -> bool
// which tells whether stretches of even fog may be wide.

// A piece of more steps than this is entered where it begins to be visible.
const light_media_LONG: f32 = 8.0;

// A share of the light below this is not followed any farther.
const light_media_NOTHING: f32 = 1e-7;

// The largest length of a part as a share of the light's distance, and the largest growth of
// the optical depth over it.
const light_media_PART_LENGTH: f32 = 0.15;
const light_media_PART_DEPTH: f32 = 0.4;

// The largest angle at the light, and the largest optical depth, of a stretch of even fog with
// two nodes, and of one with one node; the angle of two nodes is the wide one where the light is
// gentle.
const light_media_STRETCH_TURN: vec2<f32> = vec2(7.0, 24.0) / 25.0;
const light_media_WIDE_TURN: vec2<f32> = vec2(28.0, 45.0) / 53.0;
const light_media_STRETCH_DEPTH: f32 = 0.6;
const light_media_SHORT_TURN: vec2<f32> = vec2(33.0, 544.0) / 545.0;
const light_media_SHORT_DEPTH: f32 = 0.05;

// The largest optical depth of any stretch with two nodes.
const light_media_LAST_DEPTH: f32 = 2.0;

// Colours of which less than this share is left, beside the one of which most is left, do not
// shorten stretches.
const light_media_SEEN: f32 = 1e-3;

// The first node of Gauss's rule with two, as a share of the interval.
const light_media_NODE: f32 = 0.21132487;

// A piece counts as homogeneous unless its optical depth is more than this many times that
// which is left to a part.
const light_media_UNEVEN: f32 = 4.0;

// Behind this optical depth nothing is left.
const light_media_OPAQUE: f32 = 16.2;

// Where a step ends, see `Limits`.
struct light_media_Limits {
    // Its length on pieces with smoke, and on others, m.
    lengths: vec2<f32>,
    // Sine and cosine of the angle at the light, at most a half turn; `has_angle` is false where
    // it is no limit.
    turn: vec2<f32>,
    has_angle: bool,
    // The share of the light that its media take.
    transmittance: f32,
    // The relative growth of its length per metre from the first step.
    growth: f32,
}

// A run of pieces: the current part or step, see `Run`.
struct light_media_Run {
    is_open: bool,
    start: f32,
    end: f32,
    // The position, and the optical depth, at which it has to end; at the depth `full` only a
    // sliver would be left.
    last: f32,
    deepest: f32,
    full: f32,
    // Sums of weights, and of weights times positions.
    weight: f32,
    moment: f32,
}

struct light_media_Steps {
    limits: light_media_Limits,
    // Where the line comes nearest to a light at a point.
    foot: f32,
    has_lamp: bool,
    // Where the full cone of a spotlight begins and ends.
    rims: vec2<f32>,
    part: light_media_Run,
    step: light_media_Run,
    // Where the first step began, if there was one.
    has_first: bool,
    first: f32,
    // For the current part: what each phase function scatters, as a share of the light along
    // the ray.
    scattered: array<vec3<f32>, light_media_MAX_GRIDS>,
    // For the current step: the light that reaches the eye if nothing blocks the lamp.
    radiance: vec3<f32>,
    // What the panes in front of the step let through, and the light of all steps so far.
    seen: vec3<f32>,
    sum: vec3<f32>,
}

fn light_media_most(v: vec3<f32>) -> f32 {
    return max(v.x, max(v.y, v.z));
}

fn light_media_least(v: vec3<f32>) -> f32 {
    return min(v.x, min(v.y, v.z));
}

// The angle at a lamp, at the distance h from the line, between two positions that are
// measured from its foot point.
fn light_media_angle(h: f32, a: f32, b: f32) -> f32 {
    if b >= light_media_END {
        return light_angle(h, a);
    }
    return light_angle(h * (b - a), h * h + a * b);
}

// The mean of 1/d² between two distances; 1 for a sun.
fn light_media_falloff(
    path: light_Path,
    steps: ptr<function, light_media_Steps>,
    start: f32,
    end: f32,
) -> f32 {
    if !(*steps).has_lamp {
        return 1.0;
    }
    let a = start - (*steps).foot;
    let b = end - (*steps).foot;
    let rise = path.h * (end - start);
    let run = path.h * path.h + a * b;
    if run > 0.0 && rise < 0.05 * run {
        let square = (rise / run) * (rise / run);
        return (1.0 - square * (1.0 / 3.0 - 0.2 * square)) / run;
    }
    return light_angle(rise, run) / rise;
}

// The position at which the angle at a lamp, measured from `start`, has had this turn, by its
// sine and cosine.
fn light_media_turned(
    path: light_Path,
    steps: ptr<function, light_media_Steps>,
    start: f32,
    turn: vec2<f32>,
) -> f32 {
    let a = start - (*steps).foot;
    let below = path.h * turn.y - a * turn.x;
    if !(*steps).has_lamp || below <= 0.0 {
        return light_media_END;
    }
    let ahead = (*steps).foot + path.h * ((a * turn.y + path.h * turn.x) / below);
    return min(ahead, light_media_END);
}

// About how far the line runs within smoke (x), and how far through fog (y), m; see
// `lengths_within`.
fn light_media_lengths(
    walk: ptr<function, light_MediaWalk>,
    start: f32,
    end: f32,
) -> vec2<f32> {
    // How far fog is seen, in mean free paths.
    let seen = 10.0;
    let origin = (*walk).origin;
    let direction = (*walk).direction;
    var smoke = 0.0;
    var even = 0.0;
    for (var i = 0u; i < light_media.boxes; i++) {
        let at = light_media.first_box + 2u * i;
        let inside = light_media_inside(
            bitcast<vec3<f32>>(light_media_records[at].xyz),
            bitcast<vec3<f32>>(light_media_records[at + 1u].xyz),
            origin,
            direction,
            vec2(start, end),
        );
        let length = max(inside.y - inside.x, 0.0);
        // The box of bounded fog is the first.
        if i == 0u && light_media.even.bounded != 0u {
            even = length;
        } else {
            smoke += length;
        }
    }
    let sigma = light_media_most(light_media.even.sigma_t);
    if light_media.even.bounded == 0u && sigma > 0.0 {
        even = min(end - start, seen / sigma);
    }
    let height = light_media.height;
    let most = light_media_most(height.sigma_t);
    var thinning = 0.0;
    if most > 0.0 {
        let density = scn_height_density(height, origin.y + start * direction.y);
        let rise = seen * height.scale_height / max(abs(direction.y), 1e-18);
        thinning = min(end - start, min(rise, seen / max(most * max(density, 1e-18), 1e-18)));
    }
    let both = even > 0.0 && thinning > 0.0;
    return vec2(smoke, select(even + thinning, min(even, thinning), both));
}

// The state for about `count` steps of a ray from `start` to `end`.
fn light_media_steps(
    path: light_Path,
    walk: ptr<function, light_MediaWalk>,
    base: f32,
    start: f32,
    end: f32,
    count: u32,
) -> light_media_Steps {
    var steps: light_media_Steps;
    steps.has_lamp = light_emitter().kind == light_POINT;
    steps.foot = path.foot - base;
    steps.rims = vec2(path.kinks[0], path.kinks[1]) - base;
    steps.seen = vec3(1.0);
    var angle = 0.0;
    if steps.has_lamp {
        angle = light_media_angle(path.h, start - steps.foot, end - steps.foot);
    }
    let share = max(f32(count) / select(2.0, 3.0, angle > 0.0), 1.0);
    let lengths = light_media_lengths(walk, start, end);
    var each = vec2(max(lengths.x, lengths.y));
    if all(lengths > vec2(0.0)) {
        // Smoke and fog have half of the steps each.
        each = 2.0 * lengths;
    }
    steps.limits.lengths = each / share;
    steps.limits.transmittance = 1.0 / share;
    steps.limits.growth = 1.0 / share;
    angle /= share;
    steps.limits.has_angle = angle > 0.0 && angle < light_PI;
    let sin = light_sin(0.5 * angle);
    let cos = light_sin(0.5 * light_PI - 0.5 * angle);
    steps.limits.turn = vec2(2.0 * sin * cos, 1.0 - 2.0 * sin * sin);
    return steps;
}

// A run that begins at a position and an optical depth.
fn light_media_run(start: f32, last: f32, depth: f32, deepest: f32) -> light_media_Run {
    let full = depth + 0.95 * (deepest - depth);
    return light_media_Run(true, start, start, last, deepest, full, 0.0, 0.0);
}

// The length of a step at a distance, which grows with the distance.
fn light_media_grown(steps: ptr<function, light_media_Steps>, length: f32, at: f32) -> f32 {
    let first = select(at, (*steps).first, (*steps).has_first);
    return max(length, (at - first) * (*steps).limits.growth);
}

// Begins a step if there is none.
fn light_media_begin_step(
    path: light_Path,
    steps: ptr<function, light_media_Steps>,
    start: f32,
    depth: vec3<f32>,
    before: vec3<f32>,
    step_length: f32,
) {
    let limits = (*steps).limits;
    if !(*steps).has_first {
        (*steps).has_first = true;
        (*steps).first = start;
    }
    if !(*steps).step.is_open {
        let length = light_media_grown(steps, step_length, start);
        let left = light_media_most(before) - limits.transmittance;
        var deepest = light_media_END;
        if left > 0.0 {
            deepest = -log(left);
        }
        var last = start + length;
        if limits.has_angle {
            last = min(last, light_media_turned(path, steps, start, limits.turn));
        }
        (*steps).step = light_media_run(start, last, light_media_least(depth), deepest);
    }
}

// Begins a step and a part if there are none.
fn light_media_begin(
    path: light_Path,
    steps: ptr<function, light_media_Steps>,
    start: f32,
    depth: vec3<f32>,
    before: vec3<f32>,
    step_length: f32,
) {
    light_media_begin_step(path, steps, start, depth, before, step_length);
    if !(*steps).part.is_open {
        let least = light_media_least(depth);
        var last = light_media_END;
        if (*steps).has_lamp {
            let away = length(vec2(start - (*steps).foot, path.h));
            last = start + light_media_PART_LENGTH * away;
        }
        let deepest = least + light_media_PART_DEPTH;
        (*steps).part = light_media_run(start, last, least, deepest);
    }
}

// Where the portion of the piece from `start` to `to` ends that fits into the part and the
// step. Distances are on the piece, whose optical depth up to `start` is `own`.
fn light_media_end_of_part(
    walk: ptr<function, light_MediaWalk>,
    steps: ptr<function, light_media_Steps>,
    start: f32,
    to: f32,
    own: vec3<f32>,
) -> f32 {
    let last = min((*steps).part.last, (*steps).step.last);
    var end = min(to, last - (*walk).start);
    if last >= light_media_END && to >= light_media_END {
        end = start + light_media_OPAQUE / light_media_most(light_media_extinction(walk, start));
    }
    let before = (*walk).depth;
    let least = light_media_least(before + own);
    let most = min((*steps).part.deepest, (*steps).step.deepest) - least;
    let grown = light_media_least(before + light_media_own_depth(walk, end)) - least;
    if grown > light_media_UNEVEN * most {
        // The optical depth may all be at the end, or a mean free path may be tiny beside the
        // piece: the interval is halved.
        var beyond = end;
        end = start;
        for (var i = 0; i < 64; i++) {
            let middle = 0.5 * (end + beyond);
            let reached = light_media_least(before + light_media_own_depth(walk, middle)) - least;
            if reached > most {
                beyond = middle;
            } else {
                end = middle;
                if reached > 0.5 * most {
                    break;
                }
            }
        }
        end = select(beyond, end, end > start);
    } else if grown > most {
        // The piece counts as homogeneous.
        end = start + (end - start) * (most / grown);
    }
    return light_media_next(start, end);
}

// `end`, but at least the next float after `start`.
fn light_media_next(start: f32, end: f32) -> f32 {
    return max(end, start + max(1.2e-7 * abs(start), 1e-30));
}

// 1/τ − 1/(e^τ − 1): the mean position at which a homogeneous piece of this optical depth
// scatters, as a share of its length. It is 1/2 for a thin piece and tends to 0.
fn light_media_front(depth: f32) -> f32 {
    if depth < 1.0 {
        // The series, to 2e-8.
        let square = depth * depth;
        return 0.5 - depth / 12.0
            * (1.0 - square / 60.0 * (1.0 - square / 42.0 * (1.0 - square / 40.0)));
    }
    return 1.0 / depth - 1.0 / (exp(min(depth, 80.0)) - 1.0);
}

// Adds what a medium scatters of the light that the part loses; returns the largest channel.
fn light_media_add_scattered(
    steps: ptr<function, light_media_Steps>,
    phase: u32,
    share: vec3<f32>,
    lost: vec3<f32>,
) -> f32 {
    let scattered = share * lost;
    (*steps).scattered[phase] += scattered;
    return light_media_most(scattered);
}

// Adds what is scattered between two distances on the piece, between which the ray loses the
// share `lost` of its light to the optical depth `own`.
fn light_media_scatter(
    walk: ptr<function, light_MediaWalk>,
    steps: ptr<function, light_media_Steps>,
    start: f32,
    end: f32,
    lost: vec3<f32>,
    own: vec3<f32>,
) {
    // Dense media scatter at their front: this is the mean of x weighted by T.
    let middle = start + (end - start) * light_media_front(light_media_most(own));
    let centroid = (*walk).start + middle;
    let sigma = light_media_extinction(walk, middle);
    // Each medium scatters its share of the extinction. A colour without extinction loses
    // nothing.
    let whole = select(vec3(1.0), sigma, sigma > vec3(0.0));
    let per = select(vec3(0.0), lost / whole, sigma > vec3(0.0));
    var weight = 0.0;
    if (*walk).even.x <= (*walk).start && (*walk).start < (*walk).even.y {
        let even = light_media.even;
        weight += light_media_add_scattered(steps, light_media.even_phase, even.sigma_s, per);
    }
    let height = light_media.height;
    if any(height.sigma_t > vec3(0.0)) {
        let y = (*walk).origin.y + centroid * (*walk).direction.y;
        let sigma_s = height.sigma_s * min(scn_height_density(height, y), light_media_END);
        weight += light_media_add_scattered(steps, light_media.height_phase, sigma_s, per);
    }
    let u = light_media_share(walk, middle);
    for (var i = 0u; i < light_media.grids; i++) {
        let cubic = (*walk).cubics[i];
        if all(cubic == vec4(0.0)) {
            continue;
        }
        let found = light_media_grid(i);
        var albedo = found.grid.albedo;
        if found.first_albedo != light_media_NONE {
            albedo = light_media_colour(walk, found.grid, i, found.first_albedo, centroid);
        }
        let extinction = scn_up_to(cubic, u).w * found.grid.tint;
        weight += light_media_add_scattered(steps, found.phase, albedo * (extinction / whole), lost);
    }
    if light_media.balls > 0u {
        let count = light_media_met_count(walk);
        for (var i = 0u; i < count; i++) {
            let met = light_media_met(walk, i);
            if !light_media_is_open(met, (*walk).start) {
                continue;
            }
            let ball = met.ball;
            let kind = light_media_kind(ball.kind);
            let cubic = scn_ball_cubic(
                ball.sigma_t,
                ball.radius,
                kind.is_soft,
                met.chord,
                (*walk).start,
                (*walk).stop,
            );
            let extinction = scn_up_to(cubic, u).w;
            let share = kind.albedo * (extinction / whole);
            weight += light_media_add_scattered(steps, kind.phase, share, lost);
        }
    }
    (*steps).part.weight += weight;
    (*steps).part.moment += weight * centroid;
}

// The optical depth of homogeneous fog and of fog that thins out, from a point to the light.
fn light_media_even_depth(at: vec3<f32>, to_light: vec3<f32>, distance: f32) -> vec3<f32> {
    var depth = vec3(0.0);
    let even = light_media.even;
    let is_near = distance < light_media_END;
    if even.bounded != 0u {
        let part = vec2(0.0, distance);
        let inside = light_media_inside(even.low, even.high, at, to_light, part);
        depth += even.sigma_t * max(inside.y - inside.x, 0.0);
    } else if is_near {
        // In fog without bounds the irradiance of a sun is that at the point.
        depth += even.sigma_t * distance;
    }
    let height = light_media.height;
    if any(height.sigma_t > vec3(0.0)) && (is_near || to_light.y > 0.0) {
        let column = scn_height_column(height, at.y, to_light.y, distance);
        depth += height.sigma_t * min(column, light_media_END);
    }
    return depth;
}

// Light that arrives at a point of the line, after the extinction by fog on the way.
struct light_media_Arriving {
    light: vec3<f32>,
    to_light: vec3<f32>,
    // The position as measured from the point nearest to a lamp.
    s: f32,
}

fn light_media_arriving(
    path: light_Path,
    walk: ptr<function, light_MediaWalk>,
    steps: ptr<function, light_media_Steps>,
    x: f32,
) -> light_media_Arriving {
    let emitter = light_emitter();
    var light = emitter.intensity;
    var to_light = -emitter.position;
    var distance = light_media_END;
    var s = 0.0;
    if (*steps).has_lamp {
        s = x - (*steps).foot;
        let from_light = light_from_light(path, s);
        distance = from_light.w;
        to_light = -from_light.xyz;
        light *= light_factor(emitter, from_light.xyz) * light_window_at(emitter, distance);
    }
    let at = (*walk).origin + x * (*walk).direction;
    light *= light_media_exp(light_media_even_depth(at, to_light, distance));
    return light_media_Arriving(light, to_light, s);
}

// The value of a phase function for arriving light.
fn light_media_phase_of(
    path: light_Path,
    steps: ptr<function, light_media_Steps>,
    number: u32,
    arriving: light_media_Arriving,
) -> f32 {
    let record = light_media.first_phase + 2u * number;
    let kind = light_media_records[record].x;
    let parameters = bitcast<vec4<f32>>(light_media_records[record + 1u]);
    if (*steps).has_lamp {
        return air_phase_from_foot(kind, parameters, arriving.s, path.h);
    }
    let cos = dot(path.direction, arriving.to_light);
    return air_phase(kind, parameters, 1.0 - cos, 1.0 + cos);
}

// Adds light to the step that is scattered at a distance.
fn light_media_add_radiance(
    steps: ptr<function, light_media_Steps>,
    radiance: vec3<f32>,
    x: f32,
) {
    let weight = light_media_most(radiance);
    if weight > 0.0 {
        (*steps).radiance += radiance;
        (*steps).step.weight += weight;
        (*steps).step.moment += weight * x;
    }
}

// Evaluates the light on the part, adds it to the step and closes the part.
fn light_media_finish_part(
    path: light_Path,
    walk: ptr<function, light_MediaWalk>,
    steps: ptr<function, light_media_Steps>,
) {
    let part = (*steps).part;
    (*steps).part = light_media_Run();
    if part.weight > 0.0 {
        var x = part.moment / part.weight;
        if (*steps).has_lamp {
            // The centroid shifts by the variance of x times the slope of log(1/d²).
            let length = part.end - part.start;
            let s = x - (*steps).foot;
            x -= length * length / 6.0 * s / (s * s + path.h * path.h);
        }
        let arriving = light_media_arriving(path, walk, steps, x);
        var scattered = vec3(0.0);
        for (var i = 0u; i < light_media.phases; i++) {
            scattered += light_media_phase_of(path, steps, i, arriving) * (*steps).scattered[i];
        }
        let falloff = light_media_falloff(path, steps, part.start, part.end);
        light_media_add_radiance(steps, falloff * arriving.light * scattered, x);
    }
    for (var i = 0u; i < light_media.phases; i++) {
        (*steps).scattered[i] = vec3(0.0);
    }
}

// Asks for the visibility at the centroid of the step, adds the step's light and closes it.
fn light_media_finish_step(
    walk: ptr<function, light_MediaWalk>,
    steps: ptr<function, light_media_Steps>,
) {
    let step = (*steps).step;
    (*steps).step = light_media_Run();
    if step.weight > 0.0 {
        let x = step.moment / step.weight;
        let share = light_point_visibility((*walk).origin + x * (*walk).direction);
        (*steps).sum += (*steps).seen * (share * (*steps).radiance);
    }
    (*steps).radiance = vec3(0.0);
}

// The distance on a long piece at which it begins to be visible: fog may begin far below the
// eye.
fn light_media_first_seen(
    walk: ptr<function, light_MediaWalk>,
    start: f32,
    to: f32,
    own: vec3<f32>,
    before: vec3<f32>,
    step_length: f32,
) -> f32 {
    var unseen = start;
    var step = step_length;
    var seen = start + step;
    while seen < to && !light_media_is_seen(walk, seen, own, before) {
        unseen = seen;
        step *= 2.0;
        seen = start + step;
    }
    if unseen == start {
        return start;
    }
    seen = min(seen, to);
    // To a thousandth of its distance.
    while seen < light_media_END && seen - unseen > 1e-3 * (seen - start) {
        let middle = 0.5 * (unseen + seen);
        if light_media_is_seen(walk, middle, own, before) {
            seen = middle;
        } else {
            unseen = middle;
        }
    }
    return unseen;
}

// Whether the piece up to a distance takes enough of the light to be visible.
fn light_media_is_seen(
    walk: ptr<function, light_MediaWalk>,
    length: f32,
    own: vec3<f32>,
    before: vec3<f32>,
) -> bool {
    let depth = max(light_media_own_depth(walk, length) - own, vec3(0.0));
    return light_media_most(before * light_media_taken(depth)) >= light_media_NOTHING;
}

// Whether even fog alone is on the piece.
fn light_media_is_even(walk: ptr<function, light_MediaWalk>) -> bool {
    return !(*walk).has_smoke && all(light_media.height.sigma_t == vec3(0.0));
}

// Adds to the step what even fog scatters between two distances. `left` is the share of light
// that is left at the first; returns the share at the second.
fn light_media_scatter_along(
    path: light_Path,
    walk: ptr<function, light_MediaWalk>,
    steps: ptr<function, light_media_Steps>,
    begin: f32,
    end: f32,
    left_at_begin: vec3<f32>,
) -> vec3<f32> {
    let even = light_media.even;
    let turn = select(
        light_media_STRETCH_TURN,
        light_media_WIDE_TURN,
        light_media_is_gentle(),
    );
    var start = begin;
    var left = left_at_begin;
    while start < end && light_media_most(left) >= light_media_NOTHING {
        let is_seen = left >= vec3(light_media_SEEN * light_media_most(left));
        let sigma = light_media_most(select(vec3(0.0), even.sigma_t, is_seen));
        var limit = light_media_turned(path, steps, start, turn);
        let share = sqrt(sqrt(light_media_most(left)));
        let deepest = min(light_media_STRETCH_DEPTH / share, light_media_LAST_DEPTH);
        // The depth could be 0.
        if sigma * (limit - start) > deepest {
            limit = start + deepest / sigma;
        }
        let rims = select(vec2(end), (*steps).rims, (*steps).rims > vec2(start));
        let rim = min(end, min(rims.x, rims.y));
        // A sliver would have nodes of its own.
        let stop = select(light_media_next(start, limit), rim, rim - start < 1.1 * (limit - start));
        let span = stop - start;
        let is_short = stop <= light_media_turned(path, steps, start, light_media_SHORT_TURN)
            && sigma * span < light_media_SHORT_DEPTH;
        // The nodes are those of the angle at the light, as `nodes` says.
        var near = 1.0;
        var far = 1.0;
        var bend = 1.0;
        if (*steps).has_lamp {
            let a = start - (*steps).foot;
            let b = stop - (*steps).foot;
            let tangent = path.h * span / (path.h * path.h + a * b);
            bend += (1.0 - 2.0 * light_media_NODE) / 6.0 * tangent * tangent;
            near = length(vec2(a, path.h));
            far = length(vec2(b, path.h));
        }
        var nodes = vec2(span * near / (near + far));
        if !is_short {
            let less = light_media_NODE * bend;
            let more = 1.0 - light_media_NODE;
            nodes = span * vec2(
                less * near / (less * near + more * far),
                more * near / (more * near + less * far),
            );
        }
        let falloff = light_media_falloff(path, steps, start, stop);
        // No float may be near enough.
        let is_opaque = sigma * span > 2.0 * deepest;
        for (var i = 0u; i < select(2u, 1u, is_short || is_opaque); i++) {
            let x = start + select(nodes[i], 0.0, is_opaque);
            let arriving = light_media_arriving(path, walk, steps, x);
            let phase = light_media_phase_of(path, steps, light_media.even_phase, arriving);
            var scattered = select(0.5, 1.0, is_short) * span * even.sigma_s
                * light_media_exp(nodes[i] * even.sigma_t);
            if is_opaque {
                let whole = select(vec3(1.0), even.sigma_t, even.sigma_t > vec3(0.0));
                scattered = even.sigma_s / whole * light_media_taken(span * even.sigma_t);
            }
            let radiance = falloff * phase * left * scattered * arriving.light;
            light_media_add_radiance(steps, radiance, x);
        }
        left *= light_media_exp(span * even.sigma_t);
        start = stop;
    }
    return left;
}

// The same as `light_media_add` for even fog alone.
fn light_media_add_even(
    path: light_Path,
    walk: ptr<function, light_MediaWalk>,
    steps: ptr<function, light_media_Steps>,
    begin: f32,
    stop: f32,
    step_length: f32,
) -> bool {
    light_media_finish_part(path, walk, steps);
    let sigma = light_media.even.sigma_t;
    let has_fog = sigma > vec3(0.0);
    var start = begin;
    var own = sigma * (start - (*walk).start);
    var before = light_media_exp((*walk).depth + own);
    while start < stop {
        if light_media_most(before) < light_media_NOTHING {
            return false;
        }
        // In no colour is anything left to be seen of the piece.
        let taken = select(vec3(0.0), min(sigma * (stop - start), vec3(1.0)), has_fog);
        if light_media_most(before * taken) < light_media_NOTHING {
            return stop < light_media_END;
        }
        let depth = (*walk).depth + own;
        light_media_begin_step(path, steps, start, depth, before, step_length);
        let step = (*steps).step;
        // The channel in which most is left has the least depth, and comes last.
        let room = light_media_most(select(
            vec3(light_media_END),
            (vec3(step.deepest) - depth) / sigma,
            has_fog,
        ));
        var end = min(min(stop, step.last), start + room);
        if end >= light_media_END {
            end = start + light_media_OPAQUE / light_media_most(sigma);
        }
        end = light_media_next(start, end);
        before = light_media_scatter_along(path, walk, steps, start, end, before);
        own = sigma * (end - (*walk).start);
        if end >= step.last || light_media_least((*walk).depth + own) >= step.full {
            light_media_finish_step(walk, steps);
        }
        start = end;
    }
    return true;
}

// Adds the part of the piece between two distances on the line. False once nothing behind can
// be seen.
fn light_media_add(
    path: light_Path,
    walk: ptr<function, light_MediaWalk>,
    steps: ptr<function, light_media_Steps>,
    begin: f32,
    stop: f32,
) -> bool {
    if (*steps).part.is_open && (*steps).part.end < begin {
        // This is a gap; the falloff must not be averaged over it.
        light_media_finish_part(path, walk, steps);
    }
    let length = select((*steps).limits.lengths.y, (*steps).limits.lengths.x, (*walk).has_smoke);
    // Smoke may need shorter steps than the fog in front of it.
    (*steps).step.last = min((*steps).step.last, begin + light_media_grown(steps, length, begin));
    if light_media_is_even(walk) {
        return light_media_add_even(path, walk, steps, begin, stop, length);
    }
    // From here on distances are on the piece.
    var start = begin - (*walk).start;
    let to = select(stop - (*walk).start, light_media_END, stop >= light_media_END);
    // The optical depth of the piece up to the start, and the share of light that is left.
    var own = light_media_own_depth(walk, start);
    var before = light_media_exp((*walk).depth + own);
    let whole = light_media_own_depth(walk, to);
    if to - start > light_media_LONG * length {
        start = light_media_first_seen(walk, start, to, own, before, length);
        own = light_media_own_depth(walk, start);
        before = light_media_exp((*walk).depth + own);
    }
    while start < to {
        if light_media_most(before) < light_media_NOTHING {
            return false;
        }
        // In no colour is anything left to be seen of the piece.
        let rest = light_media_taken(max(whole - own, vec3(0.0)));
        if light_media_most(before * rest) < light_media_NOTHING {
            return to < light_media_END;
        }
        light_media_begin(path, steps, (*walk).start + start, (*walk).depth + own, before, length);
        let end = light_media_end_of_part(walk, steps, start, to, own);
        let behind = light_media_own_depth(walk, end);
        let grown = max(behind - own, vec3(0.0));
        let lost = before * light_media_taken(grown);
        light_media_scatter(walk, steps, start, end, lost, grown);
        // At the end of the piece this is exactly where the next one begins, so that rounding
        // makes no gap.
        (*steps).part.end = select((*walk).start + end, stop, end >= to);
        // The channel in which most is left.
        let least = light_media_least((*walk).depth + behind);
        let step = (*steps).step;
        let part = (*steps).part;
        let is_step_full = end >= step.last - (*walk).start || least >= step.full;
        if is_step_full || end >= part.last - (*walk).start || least >= part.full {
            light_media_finish_part(path, walk, steps);
        }
        if is_step_full {
            light_media_finish_step(walk, steps);
        }
        own = behind;
        before -= lost;
        start = end;
    }
    return true;
}

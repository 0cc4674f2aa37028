// The steps of a ray through media: the shader's side of `steps.rs`, with the same
// constants.
//
// Needs walk.wgsl, the parts NUMERIC, PHASE and PATH, and the slot of what is asked,
//   fn light_point_visibility(point: vec3<f32>) -> vec3<f32>

// Pieces of more steps than this are looked at from where they begin to be seen.
const light_media_LONG: f32 = 8.0;

// Less than this of the light is not followed any further.
const light_media_NOTHING: f32 = 1e-7;

// The most that a part is as long as the light is away, and that the optical depth grows
// over it.
const light_media_PART_LENGTH: f32 = 0.15;
const light_media_PART_DEPTH: f32 = 0.4;

// Depth beside that of a part from which a piece is not taken for an even one.
const light_media_UNEVEN: f32 = 4.0;

// Optical depth at which nothing is left.
const light_media_OPAQUE: f32 = 16.2;

// How far a step goes, see `Limits`. The angle is at most a half turn;
// `has_angle` is false where it is no limit.
struct light_media_Limits {
    // On pieces with smoke, and on others.
    lengths: vec2<f32>,
    sin: f32,
    cos: f32,
    has_angle: bool,
    transmittance: f32,
    growth: f32,
}

// A run of pieces, see `Run`.
struct light_media_Run {
    is_open: bool,
    start: f32,
    end: f32,
    last: f32,
    deepest: f32,
    full: f32,
    weight: f32,
    moment: f32,
}

struct light_media_Steps {
    limits: light_media_Limits,
    // Where the line comes nearest to a light at a point.
    foot: f32,
    has_lamp: bool,
    part: light_media_Run,
    step: light_media_Run,
    has_first: bool,
    first: f32,
    // Of the part: what each phase function scatters, as a share of all light.
    scattered: array<vec3<f32>, light_media_MAX_GRIDS>,
    // Of the step: what comes to the eye, all of the light arriving.
    radiance: vec3<f32>,
    // What the panes before the step let through, and the light of all steps.
    seen: vec3<f32>,
    sum: vec3<f32>,
}

fn light_media_most(v: vec3<f32>) -> f32 {
    return max(v.x, max(v.y, v.z));
}

fn light_media_least(v: vec3<f32>) -> f32 {
    return min(v.x, min(v.y, v.z));
}

// The angle at a lamp h from the line between two positions behind its foot point.
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

// The distance at which a step that begins here has had its share of the angle.
fn light_media_turned(path: light_Path, steps: ptr<function, light_media_Steps>, start: f32) -> f32 {
    let limits = (*steps).limits;
    if !limits.has_angle {
        return light_media_END;
    }
    let a = start - (*steps).foot;
    let below = path.h * limits.cos - a * limits.sin;
    if below <= 0.0 {
        return light_media_END;
    }
    let ahead = (*steps).foot + path.h * ((a * limits.cos + path.h * limits.sin) / below);
    return min(ahead, light_media_END);
}

// About how far the line runs within smoke, and how far through fog, see `lengths_within`.
fn light_media_lengths(
    walk: ptr<function, light_MediaWalk>,
    start: f32,
    end: f32,
) -> vec2<f32> {
    // In mean free paths.
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

// The steps of a ray from `start` to `end`; `count` of them.
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
    steps.seen = vec3(1.0);
    var angle = 0.0;
    if steps.has_lamp {
        angle = light_media_angle(path.h, start - steps.foot, end - steps.foot);
    }
    let share = max(f32(count) / select(2.0, 3.0, angle > 0.0), 1.0);
    let lengths = light_media_lengths(walk, start, end);
    var each = vec2(max(lengths.x, lengths.y));
    if all(lengths > vec2(0.0)) {
        // Half of the steps for each.
        each = 2.0 * lengths;
    }
    steps.limits.lengths = each / share;
    steps.limits.transmittance = 1.0 / share;
    steps.limits.growth = 1.0 / share;
    angle /= share;
    steps.limits.has_angle = angle > 0.0 && angle < light_PI;
    let sin = light_sin(0.5 * angle);
    steps.limits.sin = 2.0 * sin * light_sin(0.5 * light_PI - 0.5 * angle);
    steps.limits.cos = 1.0 - 2.0 * sin * sin;
    return steps;
}

fn light_media_run(start: f32, last: f32, depth: f32, deepest: f32) -> light_media_Run {
    let full = depth + 0.95 * (deepest - depth);
    return light_media_Run(true, start, start, last, deepest, full, 0.0, 0.0);
}

// A length of a step as it is at a distance.
fn light_media_grown(steps: ptr<function, light_media_Steps>, length: f32, at: f32) -> f32 {
    let first = select(at, (*steps).first, (*steps).has_first);
    return max(length, (at - first) * (*steps).limits.growth);
}

// Begins a step and a part where there are none.
fn light_media_begin(
    path: light_Path,
    steps: ptr<function, light_media_Steps>,
    start: f32,
    depth: vec3<f32>,
    before: vec3<f32>,
    step_length: f32,
) {
    let limits = (*steps).limits;
    let least = light_media_least(depth);
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
        let last = min(light_media_turned(path, steps, start), start + length);
        (*steps).step = light_media_run(start, last, least, deepest);
    }
    if !(*steps).part.is_open {
        var last = light_media_END;
        if (*steps).has_lamp {
            let away = length(vec2(start - (*steps).foot, path.h));
            last = start + light_media_PART_LENGTH * away;
        }
        let deepest = least + light_media_PART_DEPTH;
        (*steps).part = light_media_run(start, last, least, deepest);
    }
}

// Where what of the piece ends that fits into the part and the step: distances on the
// piece, whose depth up to `start` is `own`.
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
        // It may all be at the end, or a mean free path be nothing beside the piece.
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
        // As if it were even.
        end = start + (end - start) * (most / grown);
    }
    // The next float, if that is too far.
    return max(end, start + max(1.2e-7 * start, 1e-30));
}

// Where on an even piece of this optical depth light is scattered in the mean, from 1/2
// for thin ones to 0: 1/τ − 1/(e^τ − 1).
fn light_media_front(depth: f32) -> f32 {
    if depth < 1.0 {
        // To 2e-8.
        let square = depth * depth;
        return 0.5 - depth / 12.0
            * (1.0 - square / 60.0 * (1.0 - square / 42.0 * (1.0 - square / 40.0)));
    }
    return 1.0 / depth - 1.0 / (exp(min(depth, 80.0)) - 1.0);
}

// Adds what a medium scatters of the light that the part loses.
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

// Adds what is scattered between two distances on the piece, of which the ray loses
// `lost`.
fn light_media_scatter(
    walk: ptr<function, light_MediaWalk>,
    steps: ptr<function, light_media_Steps>,
    start: f32,
    end: f32,
    lost: vec3<f32>,
    own: vec3<f32>,
) {
    // Dense media scatter at their front: the mean of x weighted by T.
    let middle = start + (end - start) * light_media_front(light_media_most(own));
    let centroid = (*walk).start + middle;
    let sigma = light_media_extinction(walk, middle);
    // Of what is extinguished; none of a colour that is not.
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

// The optical depth of the fogs from a point towards the light.
fn light_media_even_depth(at: vec3<f32>, to_light: vec3<f32>, distance: f32) -> vec3<f32> {
    var depth = vec3(0.0);
    let even = light_media.even;
    let is_near = distance < light_media_END;
    if even.bounded != 0u {
        let part = vec2(0.0, distance);
        let inside = light_media_inside(even.low, even.high, at, to_light, part);
        depth += even.sigma_t * max(inside.y - inside.x, 0.0);
    } else if is_near {
        // Sunlight has lost nothing where fog is everywhere.
        depth += even.sigma_t * distance;
    }
    let height = light_media.height;
    if any(height.sigma_t > vec3(0.0)) && (is_near || to_light.y > 0.0) {
        let column = scn_height_column(height, at.y, to_light.y, distance);
        depth += height.sigma_t * min(column, light_media_END);
    }
    return depth;
}

// Lights the part.
fn light_media_finish_part(
    path: light_Path,
    walk: ptr<function, light_MediaWalk>,
    steps: ptr<function, light_media_Steps>,
) {
    let part = (*steps).part;
    (*steps).part = light_media_Run();
    if part.weight > 0.0 {
        let emitter = light_emitter();
        var x = part.moment / part.weight;
        var light = emitter.intensity;
        var to_light = -emitter.position;
        var distance = light_media_END;
        var s = 0.0;
        if (*steps).has_lamp {
            // The variance of x times the slope of the logarithm of 1/d².
            let length = part.end - part.start;
            s = x - (*steps).foot;
            x -= length * length / 6.0 * s / (s * s + path.h * path.h);
            s = x - (*steps).foot;
            let from_light = light_from_light(path, s);
            distance = from_light.w;
            to_light = -from_light.xyz;
            light *= light_factor(emitter, from_light.xyz) * light_window_at(emitter, distance);
        }
        let at = (*walk).origin + x * (*walk).direction;
        light *= light_media_exp(light_media_even_depth(at, to_light, distance));
        var scattered = vec3(0.0);
        for (var i = 0u; i < light_media.phases; i++) {
            let record = light_media.first_phase + 2u * i;
            let kind = light_media_records[record].x;
            let parameters = bitcast<vec4<f32>>(light_media_records[record + 1u]);
            var phase: f32;
            if (*steps).has_lamp {
                phase = air_phase_from_foot(kind, parameters, s, path.h);
            } else {
                let cos = dot(path.direction, to_light);
                phase = air_phase(kind, parameters, 1.0 - cos, 1.0 + cos);
            }
            scattered += phase * (*steps).scattered[i];
        }
        let falloff = light_media_falloff(path, steps, part.start, part.end);
        let radiance = falloff * light * scattered;
        let weight = light_media_most(radiance);
        if weight > 0.0 {
            (*steps).radiance += radiance;
            (*steps).step.weight += weight;
            (*steps).step.moment += weight * x;
        }
    }
    for (var i = 0u; i < light_media.phases; i++) {
        (*steps).scattered[i] = vec3(0.0);
    }
}

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

// Where a long piece begins to take light, on the piece: fog may begin far below the
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
    // To a thousandth of where it is.
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

fn light_media_is_seen(
    walk: ptr<function, light_MediaWalk>,
    length: f32,
    own: vec3<f32>,
    before: vec3<f32>,
) -> bool {
    let depth = max(light_media_own_depth(walk, length) - own, vec3(0.0));
    return light_media_most(before * light_media_taken(depth)) >= light_media_NOTHING;
}

// Adds what of the piece is between two distances on the line. False once nothing is left to be
// seen.
fn light_media_add(
    path: light_Path,
    walk: ptr<function, light_MediaWalk>,
    steps: ptr<function, light_media_Steps>,
    begin: f32,
    stop: f32,
) -> bool {
    if (*steps).part.is_open && (*steps).part.end < begin {
        // A gap, over which the falloff must not be averaged.
        light_media_finish_part(path, walk, steps);
    }
    let length = select((*steps).limits.lengths.y, (*steps).limits.lengths.x, (*walk).has_smoke);
    // Smoke may want shorter steps than the fog before it.
    (*steps).step.last = min((*steps).step.last, begin + light_media_grown(steps, length, begin));
    // From here on on the piece.
    var start = begin - (*walk).start;
    let to = select(stop - (*walk).start, light_media_END, stop >= light_media_END);
    // Of the piece up to the start.
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
        // What is left of the piece, of every colour, is nothing to be seen.
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
        // Where the next piece begins without a gap, whatever the rounding.
        (*steps).part.end = select((*walk).start + end, stop, end >= to);
        // The channel of which most is left.
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

// Airlight of a spotlight with a cookie, texel by texel: the shader's side of
// `airlight/cookie.rs`, which says what is done and why.
//
// Needs the part NODES of `airlight` and its functions air_quadrature_uniforms and
// air_quadrature_entry.

// The most that a piece changes, and what is left out.
const light_COOKIE_OPAQUE: f32 = 30.0;
const light_COOKIE_FAR: f32 = 1e8;
const light_COOKIE_DISTANCE: f32 = 0.5;
const light_COOKIE_DEPTH: f32 = 1.5;
const light_COOKIE_PEAK: f32 = 0.5;
const light_COOKIE_TILT: f32 = 0.3;
const light_COOKIE_SHARE: f32 = 0.1;

// A ray in the cookie of its light: numerators of column and row, and their
// denominator, at the foot point and per metre behind it.
struct light_InCookie {
    column: vec2<f32>,
    row: vec2<f32>,
    front: vec2<f32>,
}

// The lines through the centres of texels along one axis that a ray crosses.
struct light_Lines {
    number: f32,
    step: f32,
    left: u32,
    // Where the next one is; light_FAR if there is none.
    position: f32,
}

// An end of a piece.
struct light_PieceEnd {
    s: f32,
    d: f32,
    // Root of the emission without the cookie.
    ramp: f32,
}

fn light_in_cookie(path: light_Path, emitter: light_Emitter) -> light_InCookie {
    let to_foot = path.h * path.to_foot;
    let size = vec2(f32(emitter.cookie_width), f32(emitter.cookie_height));
    let front = vec2(dot(emitter.axis, to_foot), dot(emitter.axis, path.direction));
    let right = vec2(dot(emitter.right, to_foot), dot(emitter.right, path.direction));
    let down = -vec2(dot(emitter.up, to_foot), dot(emitter.up, path.direction));
    let scale = size / emitter.tan_outer;
    return light_InCookie(
        0.5 * ((size.x - 1.0) * front + scale.x * right),
        0.5 * ((size.y - 1.0) * front + scale.y * down),
        front,
    );
}

// Of a numerator, between the positions start and end behind the foot point.
fn light_lines(at: vec2<f32>, front: vec2<f32>, start: f32, end: f32, texels: u32) -> light_Lines {
    let last = f32(texels - 1u);
    let from_here = light_place_in_cookie(at, front, start, last);
    let to = light_place_in_cookie(at, front, end, last);
    var lines: light_Lines;
    var until = 0.0;
    if from_here <= to {
        lines.step = 1.0;
        lines.number = max(floor(from_here) + 1.0, 0.0);
        until = min(ceil(to) - 1.0, last);
    } else {
        lines.step = -1.0;
        lines.number = min(ceil(from_here) - 1.0, last);
        until = max(floor(to) + 1.0, 0.0);
    }
    lines.left = u32(max(lines.step * (until - lines.number) + 1.0, 0.0));
    lines.position = light_line_position(at, front, lines);
    return lines;
}

// Column or row, or a little outside of the cookie.
fn light_place_in_cookie(at: vec2<f32>, front: vec2<f32>, s: f32, last: f32) -> f32 {
    let z = front.x + front.y * s;
    // At the apex of the cone there is no direction.
    if z <= 0.0 {
        return 0.5 * last;
    }
    return clamp((at.x + at.y * s) / z, -1.0, last + 1.0);
}

fn light_line_position(at: vec2<f32>, front: vec2<f32>, lines: light_Lines) -> f32 {
    let line = at - lines.number * front;
    // Not crossed within any distance that counts.
    if lines.left == 0u || abs(line.x) >= 1e18 * abs(line.y) {
        return light_FAR;
    }
    return -line.x / line.y;
}

fn light_piece_end(path: light_Path, emitter: light_Emitter, s: f32) -> light_PieceEnd {
    let from_light = light_from_light(path, s);
    return light_PieceEnd(s, from_light.w, light_ramp(emitter, from_light.xyz));
}

fn light_cookie_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    let emitter = light_emitter();
    let sigma_t = light_medium().sigma_t;
    let seen = light_in_cookie(path, emitter);
    var from_here = light_piece_end(path, emitter, start - path.foot);
    let first = from_here.s + from_here.d;
    let last = min(end - path.foot, from_here.s + light_COOKIE_FAR * from_here.d);
    var columns = light_lines(seen.column, seen.front, from_here.s, last, emitter.cookie_width);
    var rows = light_lines(seen.row, seen.front, from_here.s, last, emitter.cookie_height);
    var total = vec3(0.0);
    while from_here.s < last {
        // Optical depth per metre, of the light that is not used up yet.
        let used = sigma_t * (from_here.s + from_here.d - first) >= vec3(light_COOKIE_OPAQUE);
        if all(used) {
            break;
        }
        let in_use = select(sigma_t, vec3(0.0), used);
        let sigma = max(in_use.x, max(in_use.y, in_use.z));
        let step = light_cookie_step(path, seen, from_here, sigma);
        let next = min(from_here.s + step, min(columns.position, rows.position));
        let to = light_piece_end(path, emitter, min(next, last));
        if columns.position <= to.s {
            columns.number += columns.step;
            columns.left -= 1u;
            columns.position = light_line_position(seen.column, seen.front, columns);
        }
        if rows.position <= to.s {
            rows.number += rows.step;
            rows.left -= 1u;
            rows.position = light_line_position(seen.row, seen.front, rows);
        }
        if from_here.s < to.s {
            total += light_cookie_piece(path, emitter, seen, from_here, to, sigma);
            from_here = to;
        }
    }
    return total;
}

// How long a piece may be that starts at an end.
fn light_cookie_step(path: light_Path, seen: light_InCookie, end: light_PieceEnd, sigma: f32) -> f32 {
    let aside = path.h / end.d;
    let front = max(seen.front.x + seen.front.y * end.s, 1e-30);
    let tilt = abs(seen.front.y / front - (end.s / end.d) / end.d);
    var step = light_COOKIE_DISTANCE * end.d;
    if 2.0 * sigma * step > light_COOKIE_DEPTH {
        step = light_COOKIE_DEPTH / (2.0 * sigma);
    }
    step = min(step, light_COOKIE_PEAK * (light_cookie_peak(end.s) + aside) * end.d / max(aside, 1e-20));
    if tilt * step > light_COOKIE_TILT {
        step = light_COOKIE_TILT / tilt;
    }
    // Always forward, whatever has been rounded.
    return max(step, 1e-6 * end.d);
}

// The width of the peak of the phase function on this side of the foot point.
fn light_cookie_peak(s: f32) -> f32 {
    let rules = air_quadrature_uniforms();
    return 2.0 * select(rules.finest_front, rules.finest_behind, s >= 0.0);
}

fn light_cookie_nodes(
    path: light_Path,
    emitter: light_Emitter,
    seen: light_InCookie,
    a: light_PieceEnd,
    b: light_PieceEnd,
    sigma: f32,
) -> u32 {
    let tolerance = light_COOKIE_SHARE * air_quadrature_uniforms().tolerance;
    let ratio = max(b.d / a.d, a.d / b.d);
    let depth = sigma * ((b.s - a.s) + abs(b.d - a.d)) * ratio;
    let angle = ((b.s - a.s) / a.d) * (path.h / b.d);
    let fronts = max(seen.front.x + seen.front.y * vec2(a.s, b.s), vec2(1e-30));
    let turned = (fronts.y / b.d) / (fronts.x / a.d);
    let tilt = max(turned, 1.0 / turned) - 1.0;
    let peak = min(light_cookie_peak(a.s), light_cookie_peak(b.s)) + path.h / max(a.d, b.d);
    let power = max(tilt, angle * max(0.8 / peak, 0.4));
    let low = min(a.ramp, b.ramp);
    let high = max(a.ramp, b.ramp);
    var curved = 0.25 * angle * angle / emitter.edge;
    // Not 0, for the quotients.
    let most = max(max(high, 0.5 * (low + high + curved)), 1e-20);
    var ramp = (high - low + curved) / most;
    curved /= most;
    if low == 1.0 {
        ramp = 0.0;
        curved = 0.0;
    }
    let squares = vec4(depth * depth, power * power, ramp * ramp, curved * curved);
    let fourth = squares.xy * squares.xy;
    let bent = angle * angle + 3.0 * squares.y + 0.5 * squares.x;
    let two = fourth.x / 4320.0 + fourth.y / 36.0 + (3.0 * squares.z + bent) / 180.0;
    let three = bent * bent / 2800.0 + fourth.x * squares.x / 2.0e6 + fourth.y * squares.y / 400.0
        + (squares.w + 0.5 * squares.z * squares.y) / 100.0;
    let four = bent * bent * bent / 44100.0 + fourth.x * fourth.x / 1.8e9 + fourth.y * fourth.y / 4900.0
        + (squares.w * angle * angle * angle * angle + 0.5 * squares.z * fourth.y) / 1000.0;
    if emitter.fades != 0u || four > tolerance {
        return 6u;
    }
    return select(select(2u, 3u, two > tolerance), 4u, three > tolerance);
}

fn light_cookie_piece(
    path: light_Path,
    emitter: light_Emitter,
    seen: light_InCookie,
    a: light_PieceEnd,
    b: light_PieceEnd,
    sigma: f32,
) -> vec3<f32> {
    let rules = air_quadrature_uniforms().rules;
    // The rules of 1, 2, … nodes stand behind each other, or there is one.
    let rule = min(light_cookie_nodes(path, emitter, seen, a, b, sigma), rules) - 1u;
    let first = rules + rule * (rule + 1u) / 2u;
    let count = u32(air_quadrature_entry(rule).w);
    let far = vec2(1.0 / a.d, 1.0 / b.d);
    var sum = vec3(0.0);
    for (var i = 0u; i < count; i++) {
        let node = air_quadrature_entry(first + i);
        let share = vec2(1.0 - node.x, node.x) * far;
        let s = dot(share, vec2(a.s, b.s)) / (share.x + share.y);
        let q = length(vec2(s, path.h)) * (share.x + share.y);
        sum += (node.y / (q * q)) * light_source_behind(path, path.foot + s, s);
    }
    return sum * ((b.s - a.s) * far.x) * far.y;
}

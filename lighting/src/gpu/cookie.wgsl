// Airlight of a spotlight with a cookie, texel by texel: the shader's side of
// `airlight/cookie.rs`, which says what is done and why.
//
// Needs the part NODES of `airlight` and its functions air_quadrature_uniforms and
// air_quadrature_entry.

// See the constants of the same names in `airlight/cookie.rs`.
const light_COOKIE_OPAQUE: f32 = 30.0;
const light_COOKIE_DARK: f32 = 104.0;
const light_COOKIE_FAR: f32 = 1e8;
const light_COOKIE_DISTANCE: f32 = 0.5;
const light_COOKIE_DEPTH: f32 = 1.5;
const light_COOKIE_PEAK: f32 = 0.5;
const light_COOKIE_TILT: f32 = 0.3;
const light_COOKIE_SHARE: f32 = 0.1;
// Rays that cross more lines than this blend in the next coarser mip level, which takes over
// fully at twice as many.
const light_MOST_COOKIE_LINES: f32 = 4096.0;
// More pieces than any walk has. A walk crosses at most twice as many lines as above; the
// other limits, which are on factors and on optical depths, end some hundreds of pieces more.
// A piece takes up to three rounds of loops, and a ray one walk through a level and one half
// as long through the next: fewer than the 65,535 rounds after which some software drivers
// end all loops.
const light_COOKIE_PIECES: u32 = 10240u;

// A ray in the cookie of its light: the numerators of column and row, and their common
// denominator. Each has its value at the foot point and its slope per metre behind it.
struct light_InCookie {
    column: vec2<f32>,
    row: vec2<f32>,
    front: vec2<f32>,
}

// The lines through the centres of texels along one axis that a ray crosses.
struct light_Lines {
    // The number of the next line, and from one to the next: 1 or −1.
    number: f32,
    step: f32,
    // How many lines are left.
    left: u32,
    // Where the next one is crossed, m behind the foot point; light_FAR if there is none.
    position: f32,
}

// An end of a piece.
struct light_PieceEnd {
    // The distance behind the foot point, and that from the light, m.
    s: f32,
    d: f32,
    // The root of the emission without the cookie.
    ramp: f32,
}

fn light_in_cookie(path: light_Path, emitter: light_Emitter, level: light_CookieLevel) -> light_InCookie {
    let to_foot = path.h * path.to_foot;
    let size = vec2(f32(level.width), f32(level.height));
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

// The lines along one axis that are crossed between the positions start and end behind the
// foot point; `at` is the numerator of that axis.
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

// The column or row at a position, clamped to one texel outside of the cookie.
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
    // A line that is crossed farther away than any distance that counts is never crossed.
    if lines.left == 0u || abs(line.x) >= 1e18 * abs(line.y) {
        return light_FAR;
    }
    return -line.x / line.y;
}

fn light_piece_end(path: light_Path, emitter: light_Emitter, s: f32) -> light_PieceEnd {
    let from_light = light_from_light(path, s);
    return light_PieceEnd(s, from_light.w, light_ramp(emitter, from_light.xyz));
}

// The last position that counts for an interval from s to the distance `end`.
fn light_cookie_end(path: light_Path, s: f32, end: f32) -> f32 {
    return min(end - path.foot, s + light_COOKIE_FAR * length(vec2(s, path.h)));
}

// How many lines through the centres of texels the path crosses, as a real number that grows
// continuously.
fn light_cookie_lines(path: light_Path, seen: light_InCookie, level: light_CookieLevel) -> f32 {
    let start = path.start - path.foot;
    let end = light_cookie_end(path, start, path.end);
    let last = vec2(f32(level.width - 1u), f32(level.height - 1u));
    let from_here = vec2(
        light_place_in_cookie(seen.column, seen.front, start, last.x),
        light_place_in_cookie(seen.row, seen.front, start, last.y),
    );
    let to = vec2(
        light_place_in_cookie(seen.column, seen.front, end, last.x),
        light_place_in_cookie(seen.row, seen.front, end, last.y),
    );
    let crossed = abs(clamp(to, vec2(0.0), last) - clamp(from_here, vec2(0.0), last));
    return crossed.x + crossed.y;
}

fn light_next_cookie_level(level: light_CookieLevel) -> light_CookieLevel {
    let first = level.first + level.width * level.height;
    return light_CookieLevel((level.width + 1u) / 2u, (level.height + 1u) / 2u, first);
}

fn light_cookie_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    let emitter = light_emitter();
    var level = light_CookieLevel(emitter.cookie_width, emitter.cookie_height, 0u);
    var lines = 0.0;
    if f32(level.width + level.height) > light_MOST_COOKIE_LINES {
        lines = light_cookie_lines(path, light_in_cookie(path, emitter, level), level);
    }
    // No cookie has 2^32 lines.
    for (var i = 0u; i < 20u; i++) {
        if lines > 2.0 * light_MOST_COOKIE_LINES {
            lines *= 0.5;
            level = light_next_cookie_level(level);
        }
    }
    let share = lines / light_MOST_COOKIE_LINES - 1.0;
    let fine = light_cookie_level_airlight(path, emitter, level, start, end);
    if share <= 0.0 {
        return fine;
    }
    level = light_next_cookie_level(level);
    return mix(fine, light_cookie_level_airlight(path, emitter, level, start, end), share);
}

fn light_cookie_level_airlight(
    path: light_Path,
    emitter: light_Emitter,
    level: light_CookieLevel,
    start: f32,
    end: f32,
) -> vec3<f32> {
    let sigma_t = light_medium().sigma_t;
    let is_immersed = light_is_immersed();
    let seen = light_in_cookie(path, emitter, level);
    var from_here = light_piece_end(path, emitter, start - path.foot);
    let first = from_here.s + from_here.d;
    let last = light_cookie_end(path, from_here.s, end);
    var columns = light_lines(seen.column, seen.front, from_here.s, last, level.width);
    var rows = light_lines(seen.row, seen.front, from_here.s, last, level.height);
    var total = vec3(0.0);
    for (var i = 0u; i < light_COOKIE_PIECES && from_here.s < last; i++) {
        // The extinction of the colours that still have light left.
        let x = from_here.s + path.foot - path.entry;
        var used = sigma_t * x >= vec3(light_COOKIE_DARK);
        if is_immersed {
            // The way from the light by a position to the eye never gets shorter along the ray.
            used = sigma_t * (from_here.s + from_here.d - first) >= vec3(light_COOKIE_OPAQUE)
                | sigma_t * (x + from_here.d) >= vec3(light_COOKIE_DARK);
        }
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
            total += light_cookie_piece(path, emitter, level, seen, from_here, to, sigma);
            from_here = to;
        }
    }
    return total;
}

// How long a piece that starts at `end` may be.
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
    // Always makes progress, whatever rounding does.
    return max(step, 1e-6 * end.d);
}

// The width of the peak of the phase function on this side of the foot point.
fn light_cookie_peak(s: f32) -> f32 {
    let rules = air_quadrature_uniforms();
    return 2.0 * select(rules.finest_front, rules.finest_behind, s >= 0.0);
}

// The number of nodes with which a piece is within its share of the tolerance: 2, 3, 4 or 6.
// `two`, `three` and `four` estimate the relative errors of the rules with so many nodes from
// how much each factor of the integrand changes.
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
    // Above 0, as it is a divisor.
    let most = max(max(high, 0.5 * (low + high + curved)), 1e-20);
    var ramp = (high - low + curved) / most;
    curved /= most;
    if low == 1.0 {
        ramp = 0.0;
        curved = 0.0;
    }
    let fading = light_cookie_fading(emitter, a, b);
    ramp += fading.x;
    let squares = vec4(depth * depth, power * power, ramp * ramp, curved * curved);
    let fourth = squares.xy * squares.xy;
    let bent = angle * angle + 3.0 * squares.y + 0.5 * squares.x + fading.y;
    let two = fourth.x / 4320.0 + fourth.y / 36.0 + (3.0 * squares.z + bent) / 180.0;
    let three = bent * bent / 2800.0 + fourth.x * squares.x / 2.0e6 + fourth.y * squares.y / 400.0
        + (squares.w + 0.5 * squares.z * squares.y) / 100.0;
    let four = bent * bent * bent / 44100.0 + fourth.x * fourth.x / 1.8e9 + fourth.y * fourth.y / 4900.0
        + (squares.w * angle * angle * angle * angle + 0.5 * squares.z * fourth.y) / 1000.0;
    if four > tolerance {
        return 6u;
    }
    return select(select(2u, 3u, two > tolerance), 4u, three > tolerance);
}

// How much of the window of a light that fades changes over a piece, and how much of
// that is due to its curvature.
fn light_cookie_fading(emitter: light_Emitter, a: light_PieceEnd, b: light_PieceEnd) -> vec2<f32> {
    if emitter.fades == 0u {
        return vec2(0.0);
    }
    let windows = vec2(light_window_at(emitter, a.d), light_window_at(emitter, b.d));
    let most = max(max(windows.x, windows.y), 1e-20);
    let size = ((b.s - a.s) / emitter.range) * (max(a.d, b.d) / emitter.range);
    let curved = 6.0 * size * size / most;
    return vec2(abs(windows.x - windows.y) / most + curved, curved);
}

// The airlight of a piece.
fn light_cookie_piece(
    path: light_Path,
    emitter: light_Emitter,
    level: light_CookieLevel,
    seen: light_InCookie,
    a: light_PieceEnd,
    b: light_PieceEnd,
    sigma: f32,
) -> vec3<f32> {
    let rules = air_quadrature_uniforms().rules;
    // The rules of 1, 2, … nodes come one behind the other; a fixed number of nodes has one
    // rule alone.
    let rule = min(light_cookie_nodes(path, emitter, seen, a, b, sigma), rules) - 1u;
    let first = rules + rule * (rule + 1u) / 2u;
    let count = u32(air_quadrature_entry(rule).w);
    let far = vec2(1.0 / a.d, 1.0 / b.d);
    // Most pieces have two nodes. Outside of a loop these add nothing to the rounds that some
    // drivers count.
    var sum = light_cookie_node(path, emitter, level, vec2(a.s, b.s), far, first);
    if count > 1u {
        sum += light_cookie_node(path, emitter, level, vec2(a.s, b.s), far, first + 1u);
    }
    for (var i = 2u; i < count; i++) {
        sum += light_cookie_node(path, emitter, level, vec2(a.s, b.s), far, first + i);
    }
    return sum * ((b.s - a.s) * far.x) * far.y;
}

// The term of a node between two ends, of which `far` are the inverse distances from
// the light.
fn light_cookie_node(
    path: light_Path,
    emitter: light_Emitter,
    level: light_CookieLevel,
    ends: vec2<f32>,
    far: vec2<f32>,
    index: u32,
) -> vec3<f32> {
    let node = air_quadrature_entry(index);
    let share = vec2(1.0 - node.x, node.x) * far;
    let s = dot(share, ends) / (share.x + share.y);
    let q = length(vec2(s, path.h)) * (share.x + share.y);
    let from_light = light_from_light(path, s);
    let ramp = light_ramp(emitter, from_light.xyz);
    let emitted = ramp * ramp * light_cookie_in(level, light_cookie_uv(emitter, from_light.xyz));
    return (node.y / (q * q)) * emitted * light_scattered(path, path.foot + s, s, from_light);
}

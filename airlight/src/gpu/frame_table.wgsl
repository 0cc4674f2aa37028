// Airlight from a table that is made anew for every frame: the shader's side of
// `FrameTable`, which says what is stored and why.
//
// Needs the part SEGMENT and
//   fn air_frame_cell(index: u32) -> vec4<f32>

struct air_FrameTable {
    // Between eye and light, and the transmittance there.
    distance: f32,
    transmittance: f32,
    sigma_t: f32,
    rows: u32,
    // In a row of each sheet.
    cells: u32,
    // Where its cells begin.
    first: u32,
    padding_a: u32,
    padding_b: u32,
}

// The smallest difference of lookups that counts, as a share of the larger one.
const air_FRAME_LEAST: f32 = 0.0009765625;

// How far from the eye of the table a ray may begin, over its distance from the light.
const air_FRAME_ELSEWHERE: f32 = 0.0000152587890625;

// What the table does not know. No airlight is negative.
const air_FRAME_UNKNOWN: f32 = -1.0;

// Differences are less, or are not finite.
const air_FRAME_LARGEST: f32 = 3e38;

// Squares of what is farther away, in the distance of the light, are not taken.
const air_FRAME_FAR: f32 = 1e9;

// A ray from the eye, with P = D + x_F and q_m the value of d + s at x = D.
struct air_FrameRay {
    foot: f32,
    h: f32,
    p: f32,
    q_m: f32,
    row: u32,
    across: f32,
}

// Per unit of σ_s I, in 1/(m sr), of a part of a ray from the eye of the table;
// air_FRAME_UNKNOWN where the table cannot know it.
fn air_frame_look_up(table: air_FrameTable, segment: air_Segment) -> f32 {
    if table.rows == 0u || !(table.distance > 0.0) {
        return air_FRAME_UNKNOWN;
    }
    let foot = segment.x - segment.s;
    let h = segment.h;
    // Not below, so that what is no number is refused, too.
    let far = air_FRAME_FAR * table.distance;
    let is_part = segment.x >= 0.0 && segment.x <= far && segment.length > 0.0;
    if !(is_part && h >= 0.0 && h <= far && abs(foot) <= far) {
        return air_FRAME_UNKNOWN;
    }
    let found = sqrt(foot * foot + h * h);
    if abs(found - table.distance) > air_FRAME_ELSEWHERE * table.distance {
        return air_FRAME_UNKNOWN;
    }
    let ray = air_frame_ray(table, foot, h);
    let length = min(segment.length, 2.0 * far);
    // The light itself.
    if h == 0.0 && segment.x <= foot && foot <= segment.x + length {
        return air_FRAME_UNKNOWN;
    }
    let start = air_frame_point(table, ray, segment.x, segment.s);
    let end = air_frame_point(table, ray, segment.x + length, segment.s + length);
    if start.y < 0.0 || end.y < 0.0 {
        return air_FRAME_UNKNOWN;
    }
    var difference = end.y - start.y;
    var larger = end.y;
    if start.x == 1.0 {
        difference = -difference;
        larger = start.y;
    } else if end.x == 1.0 {
        // Past the light.
        if !(ray.q_m > 0.0) {
            return air_FRAME_UNKNOWN;
        }
        let near = air_frame_mean(table, ray, 0u, 1.0);
        let behind = air_frame_mean(table, ray, 1u, 1.0);
        if near < 0.0 || behind < 0.0 {
            return air_FRAME_UNKNOWN;
        }
        larger = (near + behind) / ray.q_m;
        difference = (near / ray.q_m - start.y) + (behind / ray.q_m - end.y);
    }
    let is_finite = difference < air_FRAME_LARGEST;
    if !(difference >= air_FRAME_LEAST * larger && difference > 0.0 && is_finite) {
        return air_FRAME_UNKNOWN;
    }
    return table.transmittance * difference;
}

fn air_frame_ray(table: air_FrameTable, foot: f32, h: f32) -> air_FrameRay {
    let distance = table.distance;
    // D + |x_F|, and what that leaves of 2D without cancellation.
    let larger = distance + abs(foot);
    let smaller = h * (h / larger);
    let is_ahead = foot >= 0.0;
    let share = select(larger, h, is_ahead) / (larger + h);
    let q = select(larger, smaller, is_ahead);
    let position = sqrt(share) * f32(table.rows - 1u);
    let row = min(u32(position), table.rows - 2u);
    let q_m = sqrt(2.0 * distance * q) + q;
    return air_FrameRay(foot, h, select(smaller, larger, is_ahead), q_m, row, position - f32(row));
}

// The sheet, 0 or 1, and tangent times mean, negative if that is not known.
fn air_frame_point(table: air_FrameTable, ray: air_FrameRay, x: f32, s: f32) -> vec2<f32> {
    let d = sqrt(s * s + ray.h * ray.h);
    if x <= table.distance {
        let under = table.distance * d + (ray.h * ray.h - s * ray.foot);
        if x == 0.0 {
            return vec2(0.0, 0.0);
        }
        // At the light.
        if under <= 0.0 {
            return vec2(0.0, air_FRAME_UNKNOWN);
        }
        let tangent = x / under;
        return vec2(0.0, tangent * air_frame_mean(table, ray, 0u, ray.q_m * tangent));
    }
    if x > air_FRAME_FAR * table.distance {
        return vec2(1.0, 0.0);
    }
    let q = d + max(s, 0.0);
    let position = 0.5 * (ray.q_m / q + (ray.p + ray.q_m) / (ray.p + q));
    return vec2(1.0, air_frame_mean(table, ray, 1u, position) / q);
}

// Negative in a cell that does not follow it.
fn air_frame_mean(table: air_FrameTable, ray: air_FrameRay, sheet: u32, position: f32) -> f32 {
    let cells = table.cells;
    let at = clamp(position, 0.0, 1.0) * f32(cells);
    let cell = min(u32(at), cells - 1u);
    let along = at - f32(cell);
    let index = table.first + (sheet * table.rows + ray.row) * cells + cell;
    let above = air_frame_cell(index);
    var below = air_frame_cell(index + cells);
    // The sign of a row says whether what follows it is known.
    if above.x < 0.0 {
        return air_FRAME_UNKNOWN;
    }
    below.x = abs(below.x);
    let cubic = mix(above, below, ray.across);
    return max(cubic.x + along * (cubic.y + along * (cubic.z + along * cubic.w)), 0.0);
}

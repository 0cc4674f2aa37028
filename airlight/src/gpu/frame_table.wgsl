// Airlight from a table that is made anew for every frame: the shader's side of
// `FrameTable`, which says what is stored and why.
//
// Needs the part SEGMENT and
//   fn air_frame_cell(index: u32) -> vec4<f32>    the four coefficients of a cell

struct air_FrameTable {
    // The distance between eye and light, m, and the transmittance over it.
    distance: f32,
    transmittance: f32,
    // The extinction for which the table was made, 1/m.
    sigma_t: f32,
    // Rows of each sheet; 0 for a table that knows nothing.
    rows: u32,
    // Cells of a row.
    cells: u32,
    // The index of the table's first cell.
    first: u32,
    padding_a: u32,
    padding_b: u32,
}

// The smallest difference of two lookups that still has its digits, as a share of the
// larger lookup: 1/1024.
const air_FRAME_LEAST: f32 = 0.0009765625;

// By how much the distance between the start of a ray and the light may differ from that
// of the table, as a share of it: 2^-16.
const air_FRAME_ELSEWHERE: f32 = 0.0000152587890625;

// Returned where the table has no answer. No airlight is negative.
const air_FRAME_UNKNOWN: f32 = -1.0;

// A difference that is not below this is not finite.
const air_FRAME_LARGEST: f32 = 3e38;

// Lengths beyond this, in units of the distance between eye and light, are not squared,
// so that nothing overflows.
const air_FRAME_FAR: f32 = 1e9;

// A ray from the eye.
struct air_FrameRay {
    // The distance x_F of the foot point from the eye.
    foot: f32,
    // The distance between ray and light.
    h: f32,
    // P = D + x_F.
    p: f32,
    // The value of d + s at x = D, where the near sheet ends and the far one begins.
    q_m: f32,
    // The row in front of the ray, and the share of the one behind it.
    row: u32,
    across: f32,
}

// The airlight of a part of a ray from the eye of the table, per unit of σ_s I, in
// 1/(m sr); air_FRAME_UNKNOWN where the table has no answer.
fn air_frame_look_up(table: air_FrameTable, segment: air_Segment) -> f32 {
    if table.rows == 0u || !(table.distance > 0.0) {
        return air_FRAME_UNKNOWN;
    }
    let foot = segment.x - segment.s;
    let h = segment.h;
    // The conditions are for what is accepted, so that NaN is refused.
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
    // The light is on the part.
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
        // The part begins nearer than the light and ends beyond it: the near sheet gives
        // what lies before x = D, the far one what lies behind.
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

// The ray whose foot point is `foot` from the eye and `h` from the light.
fn air_frame_ray(table: air_FrameTable, foot: f32, h: f32) -> air_FrameRay {
    let distance = table.distance;
    // D + |x_F|, and D − |x_F| without cancellation: their product is h².
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

// For the point at x: its sheet, 0 (near) or 1 (far), and tangent times mean there, which
// is negative if the table does not know it.
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

// The mean in a sheet at a position from 0 to 1 along the row; negative in a cell whose
// cubic does not follow it closely enough.
fn air_frame_mean(table: air_FrameTable, ray: air_FrameRay, sheet: u32, position: f32) -> f32 {
    let cells = table.cells;
    let at = clamp(position, 0.0, 1.0) * f32(cells);
    let cell = min(u32(at), cells - 1u);
    let along = at - f32(cell);
    let index = table.first + (sheet * table.rows + ray.row) * cells + cell;
    let above = air_frame_cell(index);
    var below = air_frame_cell(index + cells);
    // The sign of the upper row's cell says whether the strip between the two is known.
    if above.x < 0.0 {
        return air_FRAME_UNKNOWN;
    }
    below.x = abs(below.x);
    let cubic = mix(above, below, ray.across);
    return max(cubic.x + along * (cubic.y + along * (cubic.z + along * cubic.w)), 0.0);
}

// Arithmetic of transmittance curves in f32: exponentials, and interpolation between two
// depths.
//
// The bounds given here hold on any device that is as exact as WGSL asks for: with
// u = 2^-24, sums, differences and products are within u, quotients within 5 u.

const avsm_LARGEST: f32 = 0x1.fffffep+127;

// Stands for the number of insertions of a curve that lacks segments.
const avsm_INCOMPLETE: u32 = 0xffffffffu;

fn avsm_is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) < 0x7f800000u;
}

// A number, or 0 if it is below 2^-126, which a device need not tell from 0.
fn avsm_normal(x: f32) -> f32 {
    return select(0.0, x, (bitcast<u32>(x) & 0x7f800000u) != 0u);
}

// exp(-x) for x >= 0, within 2e-7 of it; 0 where the result is below 2^-126.
// The polynomial and the parts of ln 2 are those of the CPU.
fn avsm_exp_neg(x: f32) -> f32 {
    let y = min(x, 88.0);
    let k = round(y * 1.442695041);
    let r = (k * 0.693359375 - y) - k * 2.1219444e-4;
    var p = 1.0 / 120.0 + r * (1.0 / 720.0 + r * (1.0 / 5040.0));
    p = 0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * p));
    p = 1.0 + (r + r * r * p);
    return p * bitcast<f32>((127u - u32(clamp(k, 0.0, 127.0))) << 23u);
}

// An upper bound of 1 - exp(-x) for x >= 0, at most 3e-7 + 0.02 x above it.
fn avsm_lost(x: f32) -> f32 {
    let series = x * (1.0 - x * (0.5 - x * (1.0 / 6.0))) * 1.0000005;
    return select(1.0 - avsm_exp_neg(x) + 3e-7, series, x < 0.5);
}

// The weights of two depths `ends` in an interpolation at the depth `at` between them:
// each within 7 u of itself, also where one of them is small. Depths are scaled, so that
// neither they nor their differences overflow or get lost.
fn avsm_shares(ends: vec2<f32>, at: f32) -> vec2<f32> {
    let is_small = max(abs(ends.x), abs(ends.y)) < 0x1p-40;
    let scale = select(0.125, 0x1p+60, is_small);
    let from_here = vec2(ends.y * scale - at * scale, at * scale - ends.x * scale);
    let length = ends.y * scale - ends.x * scale;
    if length > 0.0 {
        return clamp(from_here / length, vec2(0.0), vec2(1.0));
    }
    return vec2(1.0, 0.0);
}

// The value between two that are not negative, within 9 u of itself.
fn avsm_mix(values: vec2<f32>, shares: vec2<f32>) -> f32 {
    let mixed = values.x * shares.x + values.y * shares.y;
    return clamp(mixed, min(values.x, values.y), max(values.x, values.y));
}

// The next larger of the numbers that a device tells apart.
fn avsm_next_up(x: f32) -> f32 {
    let bits = bitcast<u32>(x);
    if (bits & 0x7f800000u) == 0u {
        return 0x1p-126;
    }
    return bitcast<f32>(select(bits + 1u, bits - 1u, x < 0.0));
}

// Arithmetic that neither overflows nor depends on what WGSL leaves open.
// Numbers below 2^-126 may count as 0.

const air_LOG2_E: f32 = 1.44269502;

// The largest length, in units of a scaled segment; longer ones count as this.
const air_LONGEST: f32 = 0x1p+60;

// Whether a number is one that a shader may compute with, from its bits:
// comparisons with NaN may be assumed to be anything.
fn air_is_finite(value: f32) -> bool {
    return (bitcast<u32>(value) & 0x7fffffffu) < 0x7f800000u;
}

// value · 2^exponent for value ≥ 0: air_FAR above the range, 0 below.
fn air_scale(value: f32, exponent: i32) -> f32 {
    let bits = bitcast<i32>(value);
    let sum = (bits >> 23u) + exponent;
    if bits < 0x00800000 || sum < 1 {
        return 0.0;
    }
    if sum > 254 {
        return air_FAR;
    }
    return bitcast<f32>(bits + (exponent << 23u));
}

// value · 2^(x + exponent), within 3e-7 of itself and what the error of x adds.
// WGSL allows its own exp an error of 3 + 2|x| ULP.
//
// The polynomial interpolates 2^f in the Chebyshev nodes of −1/2 ≤ f ≤ 1/2, to
// 1.1e-7.
fn air_exp2_times(value: f32, x: f32, exponent: i32) -> f32 {
    let clamped = clamp(x, -1024.0, 1024.0);
    let whole = round(clamped);
    let f = clamped - whole;
    let power = 1.00000012 + f * (0.693147182 + f * (0.24022107 + f * (0.05550357 + f * (0.009676032 + f * 0.0013390863))));
    return air_scale(value * power, i32(whole) + exponent);
}

// 2^x: air_FAR from x = 128 on, 0 below −126.
fn air_exp2(x: f32) -> f32 {
    return air_exp2_times(1.0, x, 0);
}

// The product of two numbers that are not negative, or 1024 where it is more.
fn air_product(a: f32, b: f32) -> f32 {
    let large = max(a, b);
    let small = min(a, b);
    let is_large = large * 0x1p-64 * min(small, 0x1p+60) > 0x1p-54;
    return select(large * select(small, 0.0, is_large), 1024.0, is_large);
}

// √(s² + h²) for numbers that are 0 or between 2^-100 and 2^61.
fn air_distance(s: f32, h: f32) -> f32 {
    let is_small = max(abs(s), h) < 0x1p-40;
    let up = select(1.0, 0x1p+60, is_small);
    let down = select(1.0, 0x1p-60, is_small);
    let large_s = s * up;
    let large_h = h * up;
    return down * sqrt(large_s * large_s + large_h * large_h);
}

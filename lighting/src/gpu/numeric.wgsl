// Functions that WGSL lacks, or whose accuracy it does not promise. Polynomials are minimax
// fits of the relative error, rounded to f32.

const light_PI: f32 = 3.14159274;

// Stands for an infinite distance: f32::MAX. Shaders may assume that
// infinities do not occur.
const light_FAR: f32 = 0x1.fffffep+127;

// The angle of the vector (x, y), y ≥ 0, in [0, π]. Relative error 2e-7;
// WGSL's own atan2 may be off by 4096 ULP.
fn light_angle(y: f32, x: f32) -> f32 {
    let a = abs(x);
    let small = min(a, y);
    let large = max(a, y);
    if large <= 0.0 {
        return 0.0;
    }
    // The angle to the nearer axis is at most π/4. Beyond π/8 it is measured from the
    // diagonal instead, which halves the range of the polynomial.
    var r = small / large;
    var offset = 0.0;
    if r > 0.41421357 {
        r = (small - large) / (small + large);
        offset = 0.25 * light_PI;
    }
    let z = r * r;
    let p = -0.3333295 + z * (0.1997771 + z * (-0.1387768 + z * 0.08053723));
    var angle = offset + (r + r * z * p);
    if y > a {
        angle = 0.5 * light_PI - angle;
    }
    return select(angle, light_PI - angle, x < 0.0);
}

// sin a for a in [0, π/2]. Relative error 2e-7; WGSL's own sin may be off by
// 2^-11.
fn light_sin(a: f32) -> f32 {
    let z = a * a;
    let p = -0.1666666 + z * (0.008333066 + z * (-0.00019809602 + z * 2.6057808e-6));
    return a + a * z * p;
}

// (1 − exp(−x)) / x without cancellation.
fn light_mean_exponential(x: f32) -> f32 {
    if abs(x) > 0.35 {
        return (1.0 - exp(-x)) / x;
    }
    return 1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0)))));
}

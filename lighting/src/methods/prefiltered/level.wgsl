// Moments of depths: the shader's side of `Moments` and `Level`.
//
// Needs the parts face.wgsl and place.wgsl.

struct light_Level {
    pictures: light_Pictures,
    // The kind of moments, and how many each texel has.
    kind: u32,
    channels: u32,
    // The level, and its texels per side.
    level: u32,
    side: u32,
    // The depths between which the casters are, m.
    near: f32,
    far: f32,
    padding_a: u32,
    padding_b: u32,
}

// Kinds of moments.
const light_VARIANCE: u32 = 0u;
const light_EXPONENTIAL: u32 = 1u;
const light_FOUR: u32 = 2u;
const light_SIX: u32 = 3u;

// The scaled depths of the deepest caster, and of points behind all casters; a texel in which
// the light sees nothing has 1.
const light_DEEPEST: f32 = 0.9;
const light_BEHIND: f32 = 0.95;

// The factor c of the exponential warps, and the uncertainty of a scaled depth.
const light_WARP: f32 = 20.0;
const light_DEVIATION: f32 = 1e-3;

// A depth scaled to −1 to 1.
fn light_level_depth(level: light_Level, depth: f32) -> f32 {
    if depth == light_EMPTY {
        return 1.0;
    }
    let scale = (1.0 + light_DEEPEST) / (level.far - level.near);
    return clamp((depth - level.near) * scale - 1.0, -1.0, light_BEHIND);
}

// Two increasing functions of a scaled depth: e^(c z) and −e^(−c z).
fn light_warped(z: f32) -> vec2<f32> {
    let up = exp(light_WARP * z);
    return vec2(up, -1.0 / up);
}

fn light_moments_of(kind: u32, z: f32) -> array<f32, 6> {
    let square = z * z;
    let fourth = square * square;
    if kind == light_EXPONENTIAL {
        let warped = light_warped(z);
        return array<f32, 6>(warped.x, warped.x * warped.x, warped.y, warped.y * warped.y, 0.0, 0.0);
    }
    return array<f32, 6>(z, square, square * z, fourth, fourth * z, fourth * square);
}

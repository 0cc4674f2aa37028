// Light that fog sends to a surface: G_n(T, θ) for one exponent n, or for all from 1 to
// 200. Cubic B-splines interpolate the logarithm of e^T G.
//
// Needs the coefficients of a `LobeTable` or of a `GlossTable`:
//   fn air_surface_coefficient(index: u32) -> f32

// Nodes along the optical distance, the angle and the exponent.
const air_SURFACE_DISTANCES: u32 = 40u;
const air_SURFACE_ANGLES: u32 = 64u;
const air_SURFACE_EXPONENTS: u32 = 39u;
// Coefficients of one optical distance, and of one exponent. Splines have one more at
// each end than there are nodes.
const air_SURFACE_STRIDE: u32 = air_SURFACE_ANGLES + 2u;
const air_SURFACE_PLANE: u32 = (air_SURFACE_DISTANCES + 2u) * air_SURFACE_STRIDE;

// The four coefficients along an axis that a value depends on: the first, and the weight
// of each.
struct air_Neighbours {
    first: u32,
    weights: vec4<f32>,
}

// Those of a coordinate in [0, 1], along an axis of `count` nodes.
fn air_neighbours(coordinate: f32, count: u32) -> air_Neighbours {
    let x = clamp(coordinate, 0.0, 1.0) * f32(count - 1u);
    let first = min(u32(x), count - 2u);
    let f = x - f32(first);
    let g = 1.0 - f;
    return air_Neighbours(first, vec4(
        g * g * g / 6.0,
        2.0 / 3.0 - f * f * (1.0 - 0.5 * f),
        2.0 / 3.0 - g * g * (1.0 - 0.5 * g),
        f * f * f / 6.0,
    ));
}

// The neighbours of T, even in its fourth root.
fn air_surface_distance(optical_distance: f32) -> air_Neighbours {
    // Beyond 104, e^−T is 0.
    let t = clamp(optical_distance, 0.0, 104.0);
    return air_neighbours(sqrt(sqrt(t)) / 3.1934243, air_SURFACE_DISTANCES);
}

// The neighbours of θ, dense towards 0 and around a right angle.
fn air_surface_angle(cos_theta: f32) -> air_Neighbours {
    const half_asinh = 2.649171;
    const scale = 1.0 / (5.303305 + 2.0 * half_asinh);
    let c = clamp(cos_theta, -1.0, 1.0);
    let x = 100.0 * abs(c);
    let asinh_of = sign(c) * log(x + sqrt(x * x + 1.0));
    let fine = log(1.0 + 100.0 * (1.0 - c));
    return air_neighbours((fine - 0.5 * asinh_of + half_asinh) * scale, air_SURFACE_ANGLES);
}

// ln(e^T G) in the plane of one exponent, whose first coefficient is `start`.
fn air_surface_log(start: u32, distance: air_Neighbours, angle: air_Neighbours) -> f32 {
    var sum = 0.0;
    for (var row = 0u; row < 4u; row++) {
        let first = start + (distance.first + row) * air_SURFACE_STRIDE + angle.first;
        let c = vec4(
            air_surface_coefficient(first),
            air_surface_coefficient(first + 1u),
            air_surface_coefficient(first + 2u),
            air_surface_coefficient(first + 3u),
        );
        sum += distance.weights[row] * dot(c, angle.weights);
    }
    return sum;
}

// G_n(T, θ) by a table of one exponent, for T ≥ 0; cos θ is clamped to [−1, 1].
fn air_lobe(optical_distance: f32, cos_theta: f32) -> f32 {
    let distance = air_surface_distance(optical_distance);
    let angle = air_surface_angle(cos_theta);
    return exp(air_surface_log(0u, distance, angle) - max(optical_distance, 0.0));
}

// G_n(T, θ) by a table of all exponents; n is clamped to 1 to 200.
fn air_gloss(exponent: f32, optical_distance: f32, cos_theta: f32) -> f32 {
    let coordinate = log(clamp(exponent, 1.0, 200.0)) / 5.7037825;
    let gloss = air_neighbours(coordinate, air_SURFACE_EXPONENTS);
    let distance = air_surface_distance(optical_distance);
    let angle = air_surface_angle(cos_theta);
    var sum = 0.0;
    for (var plane = 0u; plane < 4u; plane++) {
        let start = (gloss.first + plane) * air_SURFACE_PLANE;
        sum += gloss.weights[plane] * air_surface_log(start, distance, angle);
    }
    return exp(sum - max(optical_distance, 0.0));
}

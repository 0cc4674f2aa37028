// How much light gets to a point, from filtered moments: the shader's side of
// `PrefilteredMap`. The share of depths in front of the point is bounded from below by their
// moments.
//
// Needs the part level.wgsl and the variables
//   light_moments: light_Level
//   light_moment_values: array<f32>, face by face, row by row

// Cantelli's inequality: the largest share that is not in front of z.
fn light_moments_not_before(mean: f32, square: f32, least_variance: f32, z: f32) -> f32 {
    let behind = z - mean;
    if !(behind > 0.0) {
        return 1.0;
    }
    let variance = max(square - mean * mean, least_variance);
    return variance / (variance + behind * behind);
}

// The only loop in this part has four rounds: a march calls it at each step, and some software
// drivers end all loops of an invocation after 65,535 rounds in all.

// The factors B = L D Lᵀ of a Hankel matrix of four rows, or of three rows and one of zeros.
struct light_moments_Factor {
    // L[1][0]; L[2][0], L[2][1]; L[3][0], L[3][1], L[3][2].
    second: f32,
    third: vec2<f32>,
    fourth: vec3<f32>,
    // The reciprocals of D; 0 for a row that is not there.
    inverse: vec4<f32>,
}

fn light_moments_powers(x: f32) -> vec4<f32> {
    return vec4(1.0, x, x * x, x * x * x);
}

// The factors for six moments, or for the first four of them if not `is_six`.
fn light_moments_factor(m: array<f32, 6>, is_six: bool) -> light_moments_Factor {
    var factor: light_moments_Factor;
    var all = m;
    let a = all[0];
    let da = max(all[1] - a * a, 1e-12);
    let b = all[1];
    let c = (all[2] - b * a) / da;
    let dc = max(all[3] - b * b - c * c * da, 1e-12);
    factor.second = a;
    factor.third = vec2(b, c);
    factor.inverse = vec4(1.0, 1.0 / da, 1.0 / dc, 0.0);
    if is_six {
        let d = all[2];
        let e = (all[3] - d * a) / da;
        let f = (all[4] - d * b - e * c * da) / dc;
        let df = max(all[5] - d * d - e * e * da - f * f * dc, 1e-12);
        factor.fourth = vec3(d, e, f);
        factor.inverse.w = 1.0 / df;
    }
    return factor;
}

// L⁻¹ x.
fn light_moments_forward(factor: light_moments_Factor, x: vec4<f32>) -> vec4<f32> {
    let y = x.y - factor.second * x.x;
    let z = x.z - factor.third.x * x.x - factor.third.y * y;
    let w = x.w - factor.fourth.x * x.x - factor.fourth.y * y - factor.fourth.z * z;
    return vec4(x.x, y, z, w);
}

// B⁻¹ x.
fn light_moments_solve(factor: light_moments_Factor, x: vec4<f32>) -> vec4<f32> {
    let y = light_moments_forward(factor, x) * factor.inverse;
    let w = y.w;
    let z = y.z - factor.fourth.z * w;
    let v = y.y - factor.third.y * z - factor.fourth.y * w;
    return vec4(y.x - factor.second * v - factor.third.x * z - factor.fourth.x * w, v, z, w);
}

// The weight of an atom of the distribution at x, if it lies in front of z.
fn light_moments_weight(factor: light_moments_Factor, x: f32, z: f32) -> f32 {
    if !(x < z) {
        return 0.0;
    }
    let y = light_moments_forward(factor, light_moments_powers(x));
    return 1.0 / dot(y * y, factor.inverse);
}

// Atoms beyond this weigh next to nothing; it stands for atoms that do not exist.
const light_moments_FAR: f32 = 1e3;

// The real roots of a x² + b x + c in order; light_moments_FAR for one that does not exist.
fn light_moments_quadratic(a: f32, b: f32, c: f32) -> vec2<f32> {
    let root = sqrt(max(b * b - 4.0 * a * c, 0.0));
    let q = -0.5 * select(b + root, b - root, b < 0.0);
    var roots = vec2(light_moments_FAR);
    if abs(q) < light_moments_FAR * abs(a) {
        roots.x = q / a;
    }
    if abs(c) < light_moments_FAR * abs(q) {
        roots.y = c / q;
    }
    return vec2(min(roots.x, roots.y), max(roots.x, roots.y));
}

// The cubic with coefficients p, the constant first, at x.
fn light_moments_value(p: vec4<f32>, x: f32) -> f32 {
    return ((p.w * x + p.z) * x + p.y) * x + p.x;
}

// How far from an extremum of p the parabola with the curvature there has its roots: a start
// for Newton's method.
fn light_moments_away(p: vec4<f32>, turn: f32) -> f32 {
    let curvature = 6.0 * p.w * turn + 2.0 * p.z;
    let square = -2.0 * light_moments_value(p, turn);
    if !(square * curvature > 0.0) {
        return 0.0;
    }
    return sqrt(square / curvature);
}

// A step of Newton's method from bracket.z within the bracket from x to y; the middle of the
// bracket where it would leave it.
fn light_moments_step(p: vec4<f32>, bracket: vec3<f32>, is_rising: bool) -> vec3<f32> {
    let x = bracket.z;
    let y = light_moments_value(p, x);
    let is_before = (y <= 0.0) == is_rising;
    let low = select(bracket.x, x, is_before);
    let high = select(x, bracket.y, is_before);
    let slope = (3.0 * p.w * x + 2.0 * p.z) * x + p.y;
    var next = 0.5 * (low + high);
    if slope != 0.0 {
        let newton = x - y / slope;
        next = select(next, newton, newton >= low && newton <= high);
    }
    return vec3(low, high, next);
}

fn light_moments_three_steps(p: vec4<f32>, bracket: vec3<f32>, is_rising: bool) -> vec3<f32> {
    let first = light_moments_step(p, bracket, is_rising);
    return light_moments_step(p, light_moments_step(p, first, is_rising), is_rising);
}

// The root between left and right, sought from start; light_moments_FAR if there is none.
// Nine steps suffice from a start that light_moments_away gave.
fn light_moments_root(p: vec4<f32>, left: f32, right: f32, start: f32) -> f32 {
    let is_rising = light_moments_value(p, left) <= 0.0;
    if is_rising == (light_moments_value(p, right) <= 0.0) {
        return light_moments_FAR;
    }
    let is_inside = start >= left && start <= right;
    var bracket = vec3(left, right, select(0.5 * (left + right), start, is_inside));
    bracket = light_moments_three_steps(p, bracket, is_rising);
    bracket = light_moments_three_steps(p, bracket, is_rising);
    return light_moments_three_steps(p, bracket, is_rising).z;
}

// The real roots of a cubic; light_moments_FAR for those that do not exist.
fn light_moments_cubic(p: vec4<f32>) -> vec3<f32> {
    let far = light_moments_FAR;
    let turns = light_moments_quadratic(3.0 * p.w, 2.0 * p.z, p.y);
    let before = light_moments_away(p, turns.x);
    let behind = light_moments_away(p, turns.y);
    let is_first_nearer = abs(light_moments_value(p, turns.x)) < abs(light_moments_value(p, turns.y));
    let inner = select(turns.y - behind, turns.x + before, is_first_nearer);
    return vec3(
        light_moments_root(p, -far, turns.x, turns.x - before),
        light_moments_root(p, turns.x, turns.y, inner),
        light_moments_root(p, turns.y, far, turns.y + behind),
    );
}

// The least share of a distribution with these 4 or 6 moments that lies in front of z. The
// moments are first mixed with those of the even distribution on −1 to 1, by `bias`, so that
// rounding cannot make them impossible.
fn light_moments_least_before(moments: array<f32, 6>, is_six: bool, bias: f32, z: f32) -> f32 {
    var m = moments;
    m[0] -= bias * m[0];
    m[1] += bias * (1.0 / 3.0 - m[1]);
    m[2] -= bias * m[2];
    m[3] += bias * (0.2 - m[3]);
    m[4] -= bias * m[4];
    m[5] += bias * (1.0 / 7.0 - m[5]);
    let factor = light_moments_factor(m, is_six);
    let p = light_moments_solve(factor, light_moments_powers(z));
    var roots = vec3(light_moments_quadratic(p.z, p.y, p.x), light_moments_FAR);
    if is_six {
        roots = light_moments_cubic(p);
    }
    let sum = light_moments_weight(factor, roots.x, z)
        + light_moments_weight(factor, roots.y, z)
        + light_moments_weight(factor, roots.z, z);
    return min(sum, 1.0);
}

// The share of light that gets to the scaled depth z past depths with these moments.
fn light_moments_share(kind: u32, moments: array<f32, 6>, z: f32) -> f32 {
    var m = moments;
    switch kind {
        case light_VARIANCE: {
            return light_moments_not_before(m[0], m[1], light_DEVIATION * light_DEVIATION, z);
        }
        case light_EXPONENTIAL: {
            let warped = light_warped(z);
            let least = light_WARP * light_DEVIATION * warped;
            return min(
                light_moments_not_before(m[0], m[1], least.x * least.x, warped.x),
                light_moments_not_before(m[2], m[3], least.y * least.y, warped.y),
            );
        }
        case light_FOUR: {
            return 1.0 - light_moments_least_before(m, false, 3e-5, z);
        }
        default: {
            return 1.0 - light_moments_least_before(m, true, 1e-4, z);
        }
    }
}

// Where the texels of a level are: the place of its first moment, the level, and its texels
// per side.
struct light_MomentTexels {
    first: u32,
    level: u32,
    side: u32,
}

// The share of light that gets to the scaled depth z past a texel.
fn light_moments_past(
    texels: light_MomentTexels,
    face: u32,
    column: u32,
    row: u32,
    z: f32,
) -> f32 {
    let channels = light_moments.channels;
    let texel = (face * texels.side + row) * texels.side + column;
    let first = texels.first + texel * channels;
    var moments = array<f32, 6>();
    moments[0] = light_moment_values[first];
    moments[1] = light_moment_values[first + 1u];
    if channels > 2u {
        moments[2] = light_moment_values[first + 2u];
        moments[3] = light_moment_values[first + 3u];
    }
    if channels > 4u {
        moments[4] = light_moment_values[first + 4u];
        moments[5] = light_moment_values[first + 5u];
    }
    return light_moments_share(light_moments.kind, moments, z);
}

// The same, bilinear between the four texels around a place of the map, in texels of the map.
fn light_moments_in(
    texels: light_MomentTexels,
    face: u32,
    texel: vec2<f32>,
    z: f32,
) -> f32 {
    let scale = 1.0 / f32(1u << texels.level);
    let last = texels.side - 1u;
    let position = clamp(texel * scale - 0.5, vec2(0.0), vec2(f32(last)));
    let low = vec2<u32>(position);
    let high = min(low + 1u, vec2(last));
    let part = position - vec2<f32>(low);
    var corners = vec4(0.0);
    for (var i = 0u; i < 4u; i++) {
        let corner = select(low, high, vec2(i % 2u, i / 2u) == vec2(1u));
        corners[i] = light_moments_past(texels, face, corner.x, corner.y, z);
    }
    let lines = corners.xz + part.x * (corners.yw - corners.xz);
    return lines.x + part.y * (lines.y - lines.x);
}

fn light_moments_visibility(point: vec3<f32>) -> vec3<f32> {
    // One origin for all faces.
    let v = point - light_moments.pictures.faces[0].origin;
    let index = light_face_along(light_moments.pictures.face_count, v);
    let face = light_moments.pictures.faces[index];
    let texel = light_texel_along(face, light_moments.pictures.resolution, v);
    if texel.x < 0.0 {
        return vec3(1.0);
    }
    let z = light_level_depth(light_moments, light_depth_of(face, v));
    let texels = light_MomentTexels(0u, light_moments.level, light_moments.side);
    return vec3(light_moments_in(texels, index, texel, z));
}

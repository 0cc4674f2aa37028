// How much light gets to a point, from filtered moments: the shader's side of
// `PrefilteredMap`.
//
// Needs the part level.wgsl and the variables
//   light_moments: light_Level
//   light_moment_values: array<f32>, face by face, each row by row

// Cantelli's inequality: the most that is not before z.
fn light_moments_not_before(mean: f32, square: f32, least_variance: f32, z: f32) -> f32 {
    let behind = z - mean;
    if !(behind > 0.0) {
        return 1.0;
    }
    let variance = max(square - mean * mean, least_variance);
    return variance / (variance + behind * behind);
}

// B = L D Lᵀ of a Hankel matrix.
struct light_moments_Factor {
    rows: u32,
    lower: array<array<f32, 4>, 4>,
    inverse: array<f32, 4>,
}

fn light_moments_powers(x: f32) -> array<f32, 4> {
    return array<f32, 4>(1.0, x, x * x, x * x * x);
}

fn light_moments_factor(moments: array<f32, 7>, rows: u32) -> light_moments_Factor {
    var all = moments;
    var factor: light_moments_Factor;
    factor.rows = rows;
    var diagonal = array<f32, 4>(1.0, 1.0, 1.0, 1.0);
    for (var i = 0u; i < rows; i++) {
        for (var j = 0u; j <= i; j++) {
            var rest = all[i + j];
            for (var k = 0u; k < j; k++) {
                rest -= factor.lower[i][k] * factor.lower[j][k] * diagonal[k];
            }
            if i == j {
                diagonal[i] = max(rest, 1e-12);
                factor.inverse[i] = 1.0 / diagonal[i];
            } else {
                factor.lower[i][j] = rest * factor.inverse[j];
            }
        }
    }
    return factor;
}

// L⁻¹ x.
fn light_moments_forward(factor: ptr<function, light_moments_Factor>, x: array<f32, 4>) -> array<f32, 4> {
    var y = x;
    for (var i = 0u; i < (*factor).rows; i++) {
        for (var k = 0u; k < i; k++) {
            y[i] -= (*factor).lower[i][k] * y[k];
        }
    }
    return y;
}

// B⁻¹ x.
fn light_moments_solve(factor: ptr<function, light_moments_Factor>, x: array<f32, 4>) -> array<f32, 4> {
    var y = light_moments_forward(factor, x);
    let rows = (*factor).rows;
    for (var n = 0u; n < rows; n++) {
        let i = rows - 1u - n;
        y[i] *= (*factor).inverse[i];
        for (var k = i + 1u; k < rows; k++) {
            y[i] -= (*factor).lower[k][i] * y[k];
        }
    }
    return y;
}

// The weight of an atom at x.
fn light_moments_weight(factor: ptr<function, light_moments_Factor>, x: f32) -> f32 {
    var y = light_moments_forward(factor, light_moments_powers(x));
    var sum = 0.0;
    for (var i = 0u; i < (*factor).rows; i++) {
        sum += y[i] * y[i] * (*factor).inverse[i];
    }
    return 1.0 / sum;
}

// Real roots in order, and how many there are.
struct light_moments_Roots {
    at: array<f32, 4>,
    count: u32,
}

// Atoms beyond this weigh next to nothing.
const light_moments_FAR: f32 = 1e3;

// The roots of a x² + b x + c.
fn light_moments_quadratic(a: f32, b: f32, c: f32) -> light_moments_Roots {
    var roots: light_moments_Roots;
    let root = sqrt(max(b * b - 4.0 * a * c, 0.0));
    let q = -0.5 * select(b + root, b - root, b < 0.0);
    if abs(q) < light_moments_FAR * abs(a) {
        roots.at[0] = q / a;
        roots.count = 1u;
    }
    if abs(c) < light_moments_FAR * abs(q) {
        roots.at[roots.count] = c / q;
        roots.count += 1u;
    }
    if roots.count == 2u && roots.at[1] < roots.at[0] {
        let first = roots.at[0];
        roots.at[0] = roots.at[1];
        roots.at[1] = first;
    }
    return roots;
}

fn light_moments_value(p: array<f32, 4>, x: f32) -> f32 {
    return ((p[3] * x + p[2]) * x + p[1]) * x + p[0];
}

// Newton's steps within a bracket, halves of it where they leave it.
fn light_moments_between(p: array<f32, 4>, left: f32, right: f32, is_rising: bool) -> f32 {
    var low = left;
    var high = right;
    var x = 0.5 * (low + high);
    for (var step = 0u; step < 32u; step++) {
        let y = light_moments_value(p, x);
        if (y <= 0.0) == is_rising {
            low = x;
        } else {
            high = x;
        }
        let slope = (3.0 * p[3] * x + 2.0 * p[2]) * x + p[1];
        var next = 0.5 * (low + high);
        if slope != 0.0 {
            let newton = x - y / slope;
            next = select(next, newton, newton >= low && newton <= high);
        }
        x = next;
    }
    return x;
}

// The roots of a polynomial of degree 2 or 3.
fn light_moments_roots(polynomial: array<f32, 4>, degree: u32) -> light_moments_Roots {
    let p = polynomial;
    if degree < 3u {
        return light_moments_quadratic(p[2], p[1], p[0]);
    }
    var turns = light_moments_quadratic(3.0 * p[3], 2.0 * p[2], p[1]);
    var roots: light_moments_Roots;
    var left = -light_moments_FAR;
    for (var i = 0u; i <= turns.count; i++) {
        var right = light_moments_FAR;
        if i < turns.count {
            right = turns.at[i];
        }
        let low = light_moments_value(p, left);
        let high = light_moments_value(p, right);
        if (low <= 0.0) != (high <= 0.0) {
            roots.at[roots.count] = light_moments_between(p, left, right, low <= 0.0);
            roots.count += 1u;
        }
        left = right;
    }
    return roots;
}

// The least share of a distribution with 4 or 6 moments that lies before z.
fn light_moments_least_before(moments: array<f32, 6>, rows: u32, bias: f32, z: f32) -> f32 {
    var own = moments;
    var all = array<f32, 7>(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (var k = 0u; k < 2u * rows - 2u; k++) {
        let uniform_moment = select(0.0, 1.0 / f32(k + 2u), k % 2u == 1u);
        all[k + 1u] = own[k] + bias * (uniform_moment - own[k]);
    }
    var factor = light_moments_factor(all, rows);
    let polynomial = light_moments_solve(&factor, light_moments_powers(z));
    var roots = light_moments_roots(polynomial, rows - 1u);
    var sum = 0.0;
    for (var i = 0u; i < roots.count; i++) {
        if roots.at[i] < z {
            sum += light_moments_weight(&factor, roots.at[i]);
        }
    }
    return min(sum, 1.0);
}

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
            return 1.0 - light_moments_least_before(m, 3u, 3e-5, z);
        }
        default: {
            return 1.0 - light_moments_least_before(m, 4u, 1e-4, z);
        }
    }
}

// The share of light that gets to the depth z past a texel.
fn light_moments_past(face: u32, column: u32, row: u32, z: f32) -> f32 {
    let side = light_moments.side;
    let channels = light_moments.channels;
    let first = ((face * side + row) * side + column) * channels;
    var moments = array<f32, 6>();
    for (var i = 0u; i < channels; i++) {
        moments[i] = light_moment_values[first + i];
    }
    return light_moments_share(light_moments.kind, moments, z);
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
    let scale = 1.0 / f32(1u << light_moments.level);
    let last = light_moments.side - 1u;
    let position = clamp(texel * scale - 0.5, vec2(0.0), vec2(f32(last)));
    let low = vec2<u32>(position);
    let high = min(low + 1u, vec2(last));
    let part = position - vec2<f32>(low);
    var lines = vec2(0.0);
    for (var i = 0u; i < 2u; i++) {
        let row = select(low.y, high.y, i == 1u);
        let a = light_moments_past(index, low.x, row, z);
        let b = light_moments_past(index, high.x, row, z);
        lines[i] = a + part.x * (b - a);
    }
    return vec3(lines.x + part.y * (lines.y - lines.x));
}

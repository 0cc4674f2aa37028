// Epipolar coordinates, and their voxels along α and θ: the shader's side of
// `Space` and `Lattice`.

// Distances above this, in metres, count as infinite.
const epi_FARTHEST: f32 = 1e18;

// Stands for an infinite distance: f32::MAX. Shaders may assume that
// infinities do not occur.
const epi_INFINITE: f32 = 0x1.fffffep+127;

const epi_PI: f32 = 3.14159274;

// atan r = r + r z p(z), z = r², up to tan(π/8).
const epi_ATAN = array<f32, 5>(-0.3333333, 0.1999954, -0.14263956, 0.10743731, -0.06451928);
const epi_TAN_EIGHTH: f32 = 0.41421357;

struct epi_Lattice {
    eye: vec3<f32>,
    // Distance between eye and light, m; 0 for a directional light.
    distance: f32,
    axis: vec3<f32>,
    directional: u32,
    right: vec3<f32>,
    alpha_scale: f32,
    up: vec3<f32>,
    theta_scale: f32,
    light: vec3<f32>,
    wraps: u32,
    // The axis divided by its largest component: the upper 12 bits of each number, and the
    // rest.
    slope_high: vec3<f32>,
    alpha: u32,
    slope_low: vec3<f32>,
    theta: u32,
    // The unit vector of that component.
    largest: vec3<f32>,
    bits: u32,
    alpha_start: vec2<f32>,
    theta_centre: vec2<f32>,
    // Half the width of a voxel; 0 for a directional light.
    thinnest: f32,
    starts_on_axis: u32,
}

// The direction of an eye ray: α as a unit vector, θ as a vector of any length.
struct epi_Ray {
    alpha: vec2<f32>,
    theta: vec2<f32>,
}

struct epi_LightRay {
    origin: vec3<f32>,
    direction: vec3<f32>,
}

// The angle of the vector (x, y) in [-π, π], 0 for the zero vector. Relative
// error 3e-7; WGSL's own atan2 may be off by 4096 ULP.
fn epi_angle(y: f32, x: f32) -> f32 {
    let a = abs(x);
    let b = abs(y);
    let small = min(a, b);
    let large = max(a, b);
    if large <= 0.0 {
        return 0.0;
    }
    var r = small / large;
    var offset = 0.0;
    if small > epi_TAN_EIGHTH * large {
        r = (small - large) / (small + large);
        offset = 0.25 * epi_PI;
    }
    let z = r * r;
    let p = epi_ATAN[0] + z * (epi_ATAN[1] + z * (epi_ATAN[2] + z * (epi_ATAN[3] + z * epi_ATAN[4])));
    var angle = offset + (r + r * z * p);
    if b > a {
        angle = 0.5 * epi_PI - angle;
    }
    if x < 0.0 {
        angle = epi_PI - angle;
    }
    return select(angle, -angle, y < 0.0);
}

// The upper 12 of the 24 bits of each number: products of two such are exact.
fn epi_upper(v: vec3<f32>) -> vec3<f32> {
    return bitcast<vec3<f32>>(bitcast<vec3<u32>>(v) & vec3(0xfffff000u));
}

// a.x b.y - a.y b.x, within 2^-34 of the product of both lengths and a rounding:
// vectors next to each other do not lose their digits.
fn epi_cross(a: vec2<f32>, b: vec2<f32>) -> f32 {
    let a_high = epi_upper(vec3(a, 0.0)).xy;
    let b_high = epi_upper(vec3(b, 0.0)).xy;
    let a_low = a - a_high;
    let b_low = b - b_high;
    let high = a_high.x * b_high.y - a_high.y * b_high.x;
    let middle = (a_high.x * b_low.y - a_high.y * b_low.x) + (a_low.x * b_high.y - a_low.y * b_high.x);
    return high + (middle + (a_low.x * b_low.y - a_low.y * b_low.x));
}

// The angle by which one vector is ahead of another, in [-π, π].
fn epi_relative(a: vec2<f32>, other: vec2<f32>) -> f32 {
    return epi_angle(epi_cross(other, a), dot(other, a));
}

// The length of a vector, also if its square underflows.
fn epi_length(v: vec2<f32>) -> f32 {
    let largest = max(abs(v.x), abs(v.y));
    if largest > 1e-18 {
        return sqrt(dot(v, v));
    }
    if largest > 0.0 {
        let scaled = v / largest;
        return largest * sqrt(dot(scaled, scaled));
    }
    return 0.0;
}

fn epi_largest(v: vec3<f32>) -> f32 {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// A vector less the multiple of the axis that has the same component along the axis's
// largest one. What is left has the same components across the axis. The products are
// exact, so that vectors close to the axis keep their digits.
fn epi_beside(l: epi_Lattice, v: vec3<f32>) -> vec3<f32> {
    let along = dot(v, l.largest);
    let high = epi_upper(vec3(along));
    let low = vec3(along) - high;
    return ((v - high * l.slope_high) - low * l.slope_high) - along * l.slope_low;
}

// The components across the axis of the way between two points, within 2^-33 of
// the larger coordinates and 6 roundings of the result. Both points are cut to
// 12 bits of the largest coordinate, so that no difference is rounded.
fn epi_across(l: epi_Lattice, origin: vec3<f32>, point: vec3<f32>) -> vec2<f32> {
    let largest = max(epi_largest(origin), epi_largest(point));
    let exponent = clamp(bitcast<u32>(largest) >> 23u, 14u, 250u) - 12u;
    let grid = bitcast<f32>(exponent << 23u);
    let inverse = bitcast<f32>((254u - exponent) << 23u);
    let start = trunc(origin * inverse) * grid;
    let end = trunc(point * inverse) * grid;
    let beside = epi_beside(l, end - start) + epi_beside(l, (point - end) - (origin - start));
    return vec2(dot(beside, l.right), dot(beside, l.up));
}

// The coordinates of the ray from one point through another.
fn epi_ray_through(l: epi_Lattice, origin: vec3<f32>, point: vec3<f32>) -> epi_Ray {
    let largest = max(epi_largest(origin), epi_largest(point));
    var start = origin;
    var end = point;
    if largest < 1e-9 || largest >= 1e9 {
        // A power of two, so that squares are normal numbers.
        let exponent = clamp(bitcast<u32>(largest) >> 23u, 1u, 253u);
        let scale = bitcast<f32>((254u - exponent) << 23u);
        start = origin * scale;
        end = point * scale;
    }
    let v = end - start;
    if epi_largest(v) <= 0.0 {
        return epi_Ray(vec2(1.0, 0.0), vec2(1.0, 0.0));
    }
    let theta = epi_across(l, start, end);
    let alpha = vec2(dot(v, l.axis), epi_length(theta));
    return epi_Ray(alpha / sqrt(dot(alpha, alpha)), theta);
}

// The coordinates of the ray along a direction of any length.
fn epi_ray(l: epi_Lattice, direction: vec3<f32>) -> epi_Ray {
    return epi_ray_through(l, vec3(0.0), direction);
}

// The coordinates of the ray to a point.
fn epi_ray_to(l: epi_Lattice, point: vec3<f32>) -> epi_Ray {
    return epi_ray_through(l, l.eye, point);
}

// φ of a point, as the pair (w, q); `ray` is the eye ray on which it lies.
fn epi_phi(l: epi_Lattice, ray: epi_Ray, point: vec3<f32>) -> vec2<f32> {
    if max(abs(point.x), max(abs(point.y), abs(point.z))) > epi_FARTHEST {
        return epi_phi_along(l, ray, epi_INFINITE);
    }
    let from_eye = point - l.eye;
    if l.directional != 0u {
        return vec2(1.0, epi_length(epi_across(l, l.eye, point)));
    }
    // The way from the eye and that from the light have the same component across the
    // axis; the shorter one has lost less of it to rounding.
    let from_light = point - l.light;
    var origin = l.eye;
    if dot(from_light, from_light) < dot(from_eye, from_eye) {
        origin = l.light;
    }
    return vec2(-dot(from_light, l.axis), epi_length(epi_across(l, origin, point)));
}

// The position of an eye ray along α, in voxels: 0 is where the lattice starts. It may lie
// outside of the lattice.
fn epi_alpha_position(l: epi_Lattice, alpha: vec2<f32>) -> f32 {
    return epi_relative(alpha, l.alpha_start) * l.alpha_scale;
}

// The position of an eye ray along θ, in voxels: the lattice is from 0 to l.theta.
fn epi_theta_position(l: epi_Lattice, theta: vec2<f32>) -> f32 {
    return 0.5 * f32(l.theta) + epi_relative(theta, l.theta_centre) * l.theta_scale;
}

// φ of the point at a distance along a ray from the eye, m.
fn epi_phi_along(l: epi_Lattice, ray: epi_Ray, distance: f32) -> vec2<f32> {
    let directional = l.directional != 0u;
    if distance > epi_FARTHEST {
        return vec2(select(-ray.alpha.x, 0.0, directional), ray.alpha.y);
    }
    let w = select(l.distance - distance * ray.alpha.x, 1.0, directional);
    return vec2(w, distance * ray.alpha.y);
}

// The distance along a ray from the eye at which it reaches φ, m; epi_INFINITE if it never
// does.
fn epi_distance_along(l: epi_Lattice, ray: epi_Ray, phi: vec2<f32>) -> f32 {
    if phi.y <= 0.0 {
        return 0.0;
    }
    var numerator = l.distance * phi.y;
    var denominator = ray.alpha.y * phi.x + ray.alpha.x * phi.y;
    if l.directional != 0u {
        numerator = phi.y;
        denominator = ray.alpha.y * phi.x;
    }
    if denominator > numerator / epi_FARTHEST {
        return numerator / denominator;
    }
    return epi_INFINITE;
}

// The light ray of a plane (unit vector of θ) and an angle at the light (as
// `Lattice::light_angles` has them).
fn epi_light_ray(l: epi_Lattice, plane: vec2<f32>, phi: vec2<f32>) -> epi_LightRay {
    let out = plane.x * l.right + plane.y * l.up;
    if l.directional != 0u {
        return epi_LightRay(l.eye + phi.y * out, -l.axis);
    }
    return epi_LightRay(l.light, phi.y * out - phi.x * l.axis);
}

// The voxel along α that holds a blocker at a distance along the light ray of `phi`, m;
// the number of voxels if there is no blocker or its shadow is too thin.
fn epi_blocked_from(l: epi_Lattice, phi: vec2<f32>, distance: f32) -> u32 {
    if !(abs(distance) < epi_INFINITE) {
        return l.alpha;
    }
    var alpha = vec2(-distance, phi.y);
    if l.directional == 0u {
        let from_light = max(distance, 0.0);
        alpha = vec2(l.distance - from_light * phi.x, from_light * phi.y);
        // A shadow thinner than half a voxel has none.
        if l.distance < l.thinnest * sqrt(dot(alpha, alpha)) {
            return l.alpha;
        }
    }
    return u32(clamp(epi_alpha_position(l, alpha), 0.0, f32(l.alpha)));
}

// The light that fog scatters to surfaces, for any light, any fog, and shadows in it: the
// shader's side of `Quadrature`. Planes around the line from the surface to the light are cut
// into directions from the light and directions from the surface.
//
// Needs the slot of the point visibility,
//   fn light_point_visibility(point: vec3<f32>) -> vec3<f32>
// and the variable
//   light_rules: array<vec2<f32>>
// with n nodes and weights on (0, 1), then 2 n planes all around as cosine and
// sine, then 2 n nodes and weights on (−1, 1).

// The angle of the vector (x, y) in (−π, π].
fn light_turn(y: f32, x: f32) -> f32 {
    let angle = light_angle(abs(y), x);
    return select(angle, -angle, y < 0.0);
}

// Cosine and sine of an angle in [0, π].
fn light_circle(angle: f32) -> vec2<f32> {
    let quarter = 0.5 * light_PI;
    let sin = light_sin(min(angle, max(light_PI - angle, 0.0)));
    let cos = light_sin(min(abs(quarter - angle), quarter));
    return vec2(select(cos, -cos, angle > quarter), sin);
}

// The part of [0, π] within `half` ≤ π/2 of the direction `middle` in (−π, π].
fn light_window(middle: f32, half: f32) -> vec2<f32> {
    if middle + half > 0.0 {
        return vec2(max(middle - half, 0.0), min(middle + half, light_PI));
    }
    return vec2(middle - half + 2.0 * light_PI, light_PI);
}

// The directions u of a light with u·axis ≥ cos_edge, by planes about the line to the surface.
struct light_Cone {
    middle: vec3<f32>,
    // Whether all planes about the line meet the cone.
    whole: bool,
    across: vec3<f32>,
    // If not, the angle from `middle` within which they do.
    half_turn: f32,
    axis: vec3<f32>,
    cos_edge: f32,
    cos_axis: f32,
}

fn light_cone(axis: vec3<f32>, cos_edge: f32, toward: vec3<f32>) -> light_Cone {
    var cone: light_Cone;
    cone.axis = axis;
    cone.cos_edge = cos_edge;
    cone.cos_axis = -dot(axis, toward);
    let offset = axis + cone.cos_axis * toward;
    if dot(offset, offset) > 1e-12 {
        cone.middle = normalize(offset);
    } else {
        cone.middle = light_any_normal(toward);
    }
    cone.across = cross(toward, cone.middle);
    cone.whole = !(abs(cone.cos_axis) < cos_edge);
    if !cone.whole {
        let sin2_axis = (1.0 - cone.cos_axis) * (1.0 + cone.cos_axis);
        let rest = (cos_edge - cone.cos_axis) * (cos_edge + cone.cos_axis);
        cone.half_turn = light_angle(sqrt(max(sin2_axis - rest, 0.0)), sqrt(max(rest, 0.0)));
    }
    return cone;
}

// Plane `j` of 2 n: the unit vector in it at right angles to the line (xyz), and its weight
// (w).
fn light_plane(cone: light_Cone, n: u32, j: u32) -> vec4<f32> {
    if cone.whole {
        let turn = light_rules[n + j];
        return vec4(cone.middle * turn.x + cone.across * turn.y, light_PI / f32(n));
    }
    let node = light_rules[3u * n + j];
    let psi = cone.half_turn * node.x;
    let turn = light_circle(abs(psi));
    let side = cone.middle * turn.x + cone.across * select(turn.y, -turn.y, psi < 0.0);
    return vec4(side, cone.half_turn * node.y);
}

// The angles to the line, from 0 to π, of those directions in a plane that are in the cone.
fn light_cone_window(cone: light_Cone, side: vec3<f32>) -> vec2<f32> {
    if cone.cos_edge < 0.0 {
        return vec2(0.0, light_PI);
    }
    let across = dot(cone.axis, side);
    let reach = sqrt(cone.cos_axis * cone.cos_axis + across * across);
    if reach <= cone.cos_edge {
        return vec2(0.0, 0.0);
    }
    let height = sqrt((reach - cone.cos_edge) * (reach + cone.cos_edge));
    return light_window(light_turn(across, cone.cos_axis), light_angle(height, cone.cos_edge));
}

// The phase function of the angle whose half has this sine and cosine.
fn light_phase_of_half(sin: f32, cos: f32) -> f32 {
    let medium = light_medium();
    return air_phase(medium.phase, medium.phase_parameters, 2.0 * sin * sin, 2.0 * cos * cos);
}

fn light_surface_quadrature_irradiance(position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    if light_emitter().kind == light_DIRECTIONAL {
        return light_quadrature_of_sun(position, normal);
    }
    return light_quadrature_of_point(position, normal);
}

fn light_quadrature_of_point(position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let emitter = light_emitter();
    let medium = light_medium();
    let n = arrayLength(&light_rules) / 5u;
    let to_light = emitter.position - position;
    let distance = length(to_light);
    if distance <= 0.0 {
        return vec3(0.0);
    }
    let toward = to_light / distance;
    var axis = normal;
    var cos_edge = -1.0;
    if emitter.emission != light_ISOTROPIC {
        axis = emitter.axis;
        cos_edge = select(0.0, 1.0 - emitter.outer_versine, emitter.emission == light_SPOT);
    }
    let cone = light_cone(axis, cos_edge, toward);
    var sum = vec3(0.0);
    for (var j = 0u; j < 2u * n; j++) {
        let plane = light_plane(cone, n, j);
        let side = plane.xyz;
        let along = dot(normal, toward);
        let across = dot(normal, side);
        let front = light_window(light_turn(across, along), 0.5 * light_PI);
        let lit = light_cone_window(cone, side);
        let first = lit.x;
        let last = min(lit.y, light_PI - front.x);
        if !(first < last) {
            continue;
        }
        for (var i = 0u; i < n; i++) {
            let outer = light_rules[i];
            let phi = first + (last - first) * outer.x;
            let turn = light_circle(phi);
            let from_light = side * turn.y - toward * turn.x;
            let part = light_inside(emitter.position, from_light, vec2(0.0, emitter.range));
            var start = front.x;
            if part.x > 0.0 {
                start = max(start, light_angle(part.x * turn.y, distance - part.x * turn.x));
            }
            var end = min(front.y, light_PI - phi);
            if part.y < light_FAR {
                end = min(end, light_angle(part.y * turn.y, distance - part.y * turn.x));
            }
            if !(start < end) {
                continue;
            }
            var inner = vec3(0.0);
            for (var k = 0u; k < n; k++) {
                let node = light_rules[k];
                let gamma = start + (end - start) * node.x;
                let look = light_circle(gamma);
                let half = light_circle(0.5 * (phi + gamma));
                let apex = 2.0 * half.x * half.y;
                if !(apex > 0.0) {
                    continue;
                }
                let d = distance * (look.y / apex);
                let r = distance * (turn.y / apex);
                let out = toward * look.x + side * look.y;
                let share = light_point_visibility(position + r * out);
                if !any(share > vec3(0.0)) {
                    continue;
                }
                var way = d - part.x;
                if medium.bounded == 0u {
                    way = distance * (light_circle(0.5 * abs(gamma - phi)).x / half.x);
                } else {
                    way += light_length_inside(position, out, r);
                }
                let cos = max(along * look.x + across * look.y, 0.0);
                let scattered = node.y * cos * light_phase_of_half(half.y, half.x);
                inner += share * exp(-medium.sigma_t * way) * (scattered * light_window_at(emitter, d));
            }
            let weight = plane.w * outer.y * (last - first) * (end - start);
            sum += emitter.intensity * light_factor(emitter, from_light) * inner * weight;
        }
    }
    return medium.sigma_s * sum / distance;
}

fn light_quadrature_of_sun(position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let medium = light_medium();
    let n = arrayLength(&light_rules) / 5u;
    let toward = -light_emitter().position;
    let cone = light_cone(normal, -1.0, toward);
    var sum = vec3(0.0);
    for (var j = 0u; j < 2u * n; j++) {
        let plane = light_plane(cone, n, j);
        let side = plane.xyz;
        let along = dot(normal, toward);
        let across = dot(normal, side);
        let front = light_window(light_turn(across, along), 0.5 * light_PI);
        for (var i = 0u; i < n; i++) {
            let outer = light_rules[i];
            let gamma = front.x + (front.y - front.x) * outer.x;
            let look = light_circle(gamma);
            let out = toward * look.x + side * look.y;
            var part = light_inside(position, out, vec2(0.0, light_FAR));
            part.y = min(part.y, part.x + medium.far_end);
            if !(part.x < part.y) {
                continue;
            }
            var inner = vec3(0.0);
            for (var k = 0u; k < n; k++) {
                let node = light_rules[k];
                let x = part.x + (part.y - part.x) * node.x;
                let point = position + x * out;
                var way = x - part.x;
                if medium.bounded != 0u {
                    way += light_length_inside(point, toward, light_FAR);
                }
                inner += light_point_visibility(point) * exp(-medium.sigma_t * way) * node.y;
            }
            let half = light_circle(0.5 * gamma);
            let cos = max(along * look.x + across * look.y, 0.0);
            let scattered = cos * look.y * light_phase_of_half(half.y, half.x);
            let weight = plane.w * outer.y * (front.y - front.x) * (part.y - part.x);
            sum += inner * (weight * scattered);
        }
    }
    return medium.sigma_s * light_emitter().intensity * sum;
}

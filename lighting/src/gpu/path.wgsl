// An eye ray as one light sees it: the shader's side of `LightPath`.
//
// Needs, from whoever assembles the shader:
//   fn light_emitter() -> light_Emitter
//   fn light_medium() -> light_Medium
//   fn light_cookie(index: u32) -> vec3<f32>     texels of the emitter's cookie
// and the part PHASE of `airlight`.

const light_POINT: u32 = 0u;
const light_DIRECTIONAL: u32 = 1u;

const light_ISOTROPIC: u32 = 0u;
const light_COSINE: u32 = 1u;
const light_SPOT: u32 = 2u;

// The most kinks of a path: two at the inner cone of a spotlight, three at faces of a box.
const light_KINKS: u32 = 5u;

struct light_Emitter {
    // The position, m; for a directional light the direction in which it travels.
    position: vec3<f32>,
    kind: u32,
    // The radiant intensity, W/sr; for a directional light the irradiance, W/m².
    intensity: vec3<f32>,
    // The distance beyond which there is no light, m; light_FAR for none.
    range: f32,
    // Normal of a cosine emitter, axis of a spotlight.
    axis: vec3<f32>,
    emission: u32,
    right: vec3<f32>,
    // 1 − cos of a spotlight's half angle, which keeps the digits of narrow cones.
    outer_versine: f32,
    up: vec3<f32>,
    // The cosine of the inner half angle less that of the outer one, at least 0.001.
    edge: f32,
    // Texels of the cookie of a spotlight; 0 without a cookie.
    cookie_width: u32,
    cookie_height: u32,
    tan_outer: f32,
    // Whether the light fades towards its range.
    fades: u32,
}

// A mip level of a cookie and where its texels begin.
struct light_CookieLevel {
    width: u32,
    height: u32,
    first: u32,
}

struct light_Medium {
    // Scattering and extinction coefficients, 1/m.
    sigma_s: vec3<f32>,
    // A kind of phase function of `airlight`.
    phase: u32,
    sigma_t: vec3<f32>,
    // The length at which methods that need an end cut off a ray to the sky, m.
    far_end: f32,
    // The box of the medium, if it is bounded.
    low: vec3<f32>,
    bounded: u32,
    high: vec3<f32>,
    padding: u32,
    phase_parameters: vec4<f32>,
}

struct light_Ray {
    origin: vec3<f32>,
    length: f32,
    direction: vec3<f32>,
    padding: f32,
}

// All distances are in m, along the ray from the eye.
struct light_Path {
    origin: vec3<f32>,
    // The number of the ray in its frame.
    index: u32,
    // A unit vector.
    direction: vec3<f32>,
    // The length of the ray.
    surface: f32,
    // The part that can be lit, empty unless start < end.
    start: f32,
    end: f32,
    // Where the ray enters the medium.
    entry: f32,
    // For a point light: the point of the ray's line that is closest to it, the distance
    // between the two, and the unit vector from the light to that point.
    foot: f32,
    h: f32,
    to_foot: vec3<f32>,
    // Where the light as a function of the distance has a kink, in order, followed by
    // light_FAR. Those of a sun may lie anywhere on the line of the ray.
    kinks: array<f32, light_KINKS>,
}

// The path of a ray for the light in question.
fn light_path(ray: light_Ray, index: u32) -> light_Path {
    let emitter = light_emitter();
    var path: light_Path;
    path.index = index;
    path.origin = ray.origin;
    path.direction = normalize(ray.direction);
    path.surface = ray.length;
    let inside = light_inside(ray.origin, path.direction, vec2(0.0, ray.length));
    path.start = inside.x;
    path.end = inside.y;
    path.entry = inside.x;
    path.kinks = array<f32, light_KINKS>(light_FAR, light_FAR, light_FAR, light_FAR, light_FAR);
    if !(inside.x < inside.y) {
        return path;
    }
    if emitter.kind == light_DIRECTIONAL {
        let kinks = light_face_changes(path);
        path.kinks[0] = kinks.x;
        path.kinks[1] = kinks.y;
        return path;
    }
    let to_light = emitter.position - ray.origin;
    let across = cross(to_light, path.direction);
    path.foot = dot(to_light, path.direction);
    path.h = length(across);
    if path.h > 0.0 {
        path.to_foot = cross(across / path.h, path.direction);
    } else {
        path.to_foot = light_any_normal(path.direction);
    }
    let part = light_within_reach(path, emitter);
    path.start = part.x;
    path.end = part.y;
    path.kinks = light_find_kinks(path, emitter);
    return path;
}

// Where the sunlight that reaches the ray begins to enter a bounded medium through another
// face, in order; light_FAR where there are fewer than two such positions.
fn light_face_changes(path: light_Path) -> vec2<f32> {
    let medium = light_medium();
    if medium.bounded == 0u {
        return vec2(light_FAR);
    }
    let back = -light_emitter().position;
    // Towards the sun, the distance to the face across an axis is base + slope x. Light
    // parallel to a face never enters through it.
    var base = vec3(light_FAR);
    var slope = vec3(0.0);
    for (var axis = 0u; axis < 3u; axis++) {
        if back[axis] != 0.0 {
            let face = select(medium.low[axis], medium.high[axis], back[axis] > 0.0);
            base[axis] = (face - path.origin[axis]) / back[axis];
            slope[axis] = -path.direction[axis] / back[axis];
        }
    }
    var kinks = vec2(light_FAR);
    for (var i = 0u; i < 3u; i++) {
        let j = (i + 1u) % 3u;
        let k = (i + 2u) % 3u;
        let relative = slope[i] - slope[j];
        if back[i] == 0.0 || back[j] == 0.0 || relative == 0.0 {
            continue;
        }
        let x = (base[j] - base[i]) / relative;
        let here = base[i] + slope[i] * x;
        let third = base[k] + slope[k] * x;
        // The nearest face counts: where two distances are equal, the third must not be less,
        // up to rounding.
        if back[k] == 0.0 || here <= third + 1e-5 * abs(here) {
            if x < kinks.x {
                kinks = vec2(x, kinks.x);
            } else if x < kinks.y {
                kinks.y = x;
            }
        }
    }
    return kinks;
}

// The kinks of a point light between start and end: at the inner cone of a spotlight, and
// where the light begins to enter a bounded medium through another face.
fn light_find_kinks(path: light_Path, emitter: light_Emitter) -> array<f32, light_KINKS> {
    var kinks = array<f32, light_KINKS>(light_FAR, light_FAR, light_FAR, light_FAR, light_FAR);
    if emitter.emission == light_SPOT && emitter.outer_versine > emitter.edge {
        let full = light_in_cone(path, emitter.axis, emitter.outer_versine - emitter.edge);
        if full.x < full.y {
            kinks[0] = full.x;
            kinks[1] = full.y;
        }
    }
    let medium = light_medium();
    if medium.bounded != 0u {
        let light = emitter.position;
        // Light from between the two faces of an axis enters through neither of them.
        let to_face = select(vec3(0.0), medium.low - light, light < medium.low)
            + select(vec3(0.0), medium.high - light, light > medium.high);
        let offset = path.origin - light;
        for (var axis = 0u; axis < 3u; axis++) {
            let next = (axis + 1u) % 3u;
            let slope = to_face[next] * path.direction[axis] - to_face[axis] * path.direction[next];
            if to_face[axis] != 0.0 && to_face[next] != 0.0 && slope != 0.0 {
                kinks[2u + axis] = (to_face[axis] * offset[next] - to_face[next] * offset[axis]) / slope;
            }
        }
    }
    for (var i = 0u; i < light_KINKS; i++) {
        if !(path.start < kinks[i] && kinks[i] < path.end) {
            kinks[i] = light_FAR;
        }
        for (var j = i; j > 0u; j--) {
            let low = min(kinks[j - 1u], kinks[j]);
            kinks[j] = max(kinks[j - 1u], kinks[j]);
            kinks[j - 1u] = low;
        }
    }
    return kinks;
}

// A unit vector at right angles to v.
fn light_any_normal(v: vec3<f32>) -> vec3<f32> {
    let axis = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), abs(v.x) > 0.5);
    return normalize(cross(v, axis));
}

// A path that passes a point light more closely than 1e-4 of the light's distance from the
// eye counts as passing it at that distance, so that no integrand is infinite.
fn light_off_the_light(path: light_Path) -> light_Path {
    var moved = path;
    if path.start <= path.foot && path.foot <= path.end {
        moved.h = max(max(path.h, 1e-4 * length(vec2(path.foot, path.h))), 1e-12);
    }
    return moved;
}

// Whether the light is at a point inside of the medium.
fn light_is_immersed() -> bool {
    let emitter = light_emitter();
    let medium = light_medium();
    let inside = all(emitter.position >= medium.low) && all(emitter.position <= medium.high);
    return emitter.kind == light_POINT && (medium.bounded == 0u || inside);
}

// The part of an interval of a ray that runs in the medium; empty unless x < y.
fn light_inside(start: vec3<f32>, direction: vec3<f32>, interval: vec2<f32>) -> vec2<f32> {
    let medium = light_medium();
    if medium.bounded == 0u {
        return interval;
    }
    let low = medium.low - start;
    let high = medium.high - start;
    let parallel = direction == vec3(0.0);
    if any(parallel & ((low > vec3(0.0)) | (high < vec3(0.0)))) {
        return vec2(0.0, 0.0);
    }
    let slope = select(direction, vec3(1.0), parallel);
    let near = select(min(low / slope, high / slope), vec3(-light_FAR), parallel);
    let far = select(max(low / slope, high / slope), vec3(light_FAR), parallel);
    return vec2(
        max(max(interval.x, near.x), max(near.y, near.z)),
        min(min(interval.y, far.x), min(far.y, far.z)),
    );
}

fn light_length_inside(start: vec3<f32>, direction: vec3<f32>, length: f32) -> f32 {
    let part = light_inside(start, direction, vec2(0.0, length));
    return max(part.y - part.x, 0.0);
}

// The part of the path within the range and the cone of a point light.
fn light_within_reach(path: light_Path, emitter: light_Emitter) -> vec2<f32> {
    var part = vec2(path.start, path.end);
    if emitter.range < light_FAR {
        let half = sqrt(max((emitter.range - path.h) * (emitter.range + path.h), 0.0));
        part = vec2(max(part.x, path.foot - half), min(part.y, path.foot + half));
    }
    if emitter.emission != light_ISOTROPIC {
        let versine = select(1.0, emitter.outer_versine, emitter.emission == light_SPOT);
        let cone = light_in_cone(path, emitter.axis, versine);
        part = vec2(max(part.x, cone.x), min(part.y, cone.y));
    }
    return part;
}

// Where the ray runs inside the cone p·axis ≥ c |p| around the light, with
// c = 1 − versine; the cone is convex, so that this is one interval, perhaps unbounded.
//
// With s in units of h behind the foot point, p = to_foot + s direction, where the two
// unit vectors are at right angles: no term gets large where the ray passes close
// to the light.
fn light_in_cone(path: light_Path, axis: vec3<f32>, versine: f32) -> vec2<f32> {
    let wa = dot(path.direction, axis);
    let ta = dot(path.to_foot, axis);
    // Crossings of the double cone, (wa² − c²) s² + 2 wa ta s + ta² − c² = 0,
    // and of the plane between its halves. Squares of cosines are replaced by those of
    // sines, which keep the digits of a narrow cone.
    let cos = 1.0 - versine;
    let sine2 = versine * (2.0 - versine);
    let aside = cross(path.direction, axis);
    let a = sine2 - dot(aside, aside);
    let b = wa * ta;
    let off = dot(cross(path.to_foot, path.direction), axis);
    let discriminant = cos * cos * (sine2 - off * off);
    let tilt = cross(path.to_foot, axis);
    var cuts = vec3(light_FAR);
    if discriminant >= 0.0 {
        let root = sqrt(discriminant);
        let q = -(b + select(-root, root, b >= 0.0));
        if abs(q) < 1e30 * abs(a) {
            cuts.x = path.h * (q / a);
        }
        if q != 0.0 {
            cuts.y = path.h * ((sine2 - dot(tilt, tilt)) / q);
        }
    }
    if wa != 0.0 {
        cuts.z = path.h * (-ta / wa);
    }
    let low = min(cuts.x, min(cuts.y, cuts.z));
    let high = max(cuts.x, max(cuts.y, cuts.z));
    let middle = max(min(cuts.x, cuts.y), min(max(cuts.x, cuts.y), cuts.z));
    let ends = array<f32, 5>(-light_FAR, low, middle, high, light_FAR);
    let scale = max(path.h, 1.0);
    var result = vec2(0.0, 0.0);
    var found = false;
    for (var i = 0u; i < 4u; i++) {
        let start = ends[i];
        let end = ends[i + 1u];
        if !(start < end) {
            continue;
        }
        // A position well inside.
        var s = 0.5 * start + 0.5 * end;
        if start == -light_FAR {
            s = select(end - scale, 0.0, end == light_FAR);
        } else if end == light_FAR {
            s = start + scale;
        }
        let p = path.h * path.to_foot + s * path.direction;
        let off_axis = axis - normalize(p);
        if 0.5 * dot(off_axis, off_axis) <= versine {
            result = vec2(select(start, result.x, found), end);
            found = true;
        }
    }
    return select(result, result + path.foot, abs(result) < vec2(light_FAR));
}

// The unit vector from a point light to the position s behind the foot point (xyz), and the
// distance (w).
fn light_from_light(path: light_Path, s: f32) -> vec4<f32> {
    let d = sqrt(s * s + path.h * path.h);
    return vec4(path.direction * (s / d) + path.to_foot * (path.h / d), d);
}

// The root of the factor that a spotlight without its cookie has on its intensity into a
// unit direction.
fn light_ramp(emitter: light_Emitter, direction: vec3<f32>) -> f32 {
    // 1 − cos of the angle to the axis, by the chord, which keeps the digits of small angles.
    let off_axis = emitter.axis - direction;
    let versine = 0.5 * dot(off_axis, off_axis);
    return clamp((emitter.outer_versine - versine) / emitter.edge, 0.0, 1.0);
}

// The factor on the intensity into a unit direction.
fn light_factor(emitter: light_Emitter, direction: vec3<f32>) -> vec3<f32> {
    let cos = dot(emitter.axis, direction);
    switch emitter.emission {
        case light_COSINE: {
            return vec3(max(cos, 0.0));
        }
        case light_SPOT: {
            let ramp = light_ramp(emitter, direction);
            if emitter.cookie_width == 0u || ramp <= 0.0 {
                return vec3(ramp * ramp);
            }
            return ramp * ramp * light_cookie_at(emitter, light_cookie_uv(emitter, direction));
        }
        default: {
            return vec3(1.0);
        }
    }
}

// The factor on the intensity at a distance d in range, for lights that fade towards it.
fn light_window_at(emitter: light_Emitter, d: f32) -> f32 {
    if emitter.fades == 0u {
        return 1.0;
    }
    let part = min(d / emitter.range, 1.0);
    return (1.0 - part * part) * (1.0 + part * part);
}

// Where the cookie is seen along a unit direction of the cone, from (0, 0) to (1, 1).
fn light_cookie_uv(emitter: light_Emitter, direction: vec3<f32>) -> vec2<f32> {
    let plane = vec2(dot(emitter.right, direction), -dot(emitter.up, direction))
        / (dot(emitter.axis, direction) * emitter.tan_outer);
    return 0.5 + 0.5 * plane;
}

fn light_cookie_at(emitter: light_Emitter, uv: vec2<f32>) -> vec3<f32> {
    return light_cookie_in(light_CookieLevel(emitter.cookie_width, emitter.cookie_height, 0u), uv);
}

// The cookie at a place, bilinear between texels; beyond its border it is as there.
fn light_cookie_in(level: light_CookieLevel, uv: vec2<f32>) -> vec3<f32> {
    let size = vec2(f32(level.width), f32(level.height));
    let position = clamp(uv, vec2(0.0), vec2(1.0)) * size - 0.5;
    let base = floor(position);
    let f = position - base;
    let last = vec2<i32>(size) - 1;
    let low = clamp(vec2<i32>(base), vec2(0), last);
    let high = clamp(vec2<i32>(base) + 1, vec2(0), last);
    let rows = i32(level.first) + vec2(low.y, high.y) * i32(level.width);
    let top = mix(light_cookie(u32(rows.x + low.x)), light_cookie(u32(rows.x + high.x)), f.x);
    let bottom = mix(light_cookie(u32(rows.y + low.x)), light_cookie(u32(rows.y + high.x)), f.x);
    return mix(top, bottom, f.y);
}

fn light_sun_phase(path: light_Path) -> f32 {
    let cos = -dot(path.direction, light_emitter().position);
    let medium = light_medium();
    return air_phase(medium.phase, medium.phase_parameters, 1.0 - cos, 1.0 + cos);
}

// How far sunlight has travelled inside the medium when it reaches the distance x of the ray.
fn light_sun_leg(path: light_Path, x: f32) -> f32 {
    let medium = light_medium();
    if medium.bounded == 0u {
        return 0.0;
    }
    // A position on a face may be rounded out of the box.
    let point = clamp(path.origin + x * path.direction, medium.low, medium.high);
    return light_length_inside(point, -light_emitter().position, light_FAR);
}

// σ_s p I exp(−σ_t (x + d)), with the emission in I: the integrand without the inverse square.
fn light_source(path: light_Path, x: f32) -> vec3<f32> {
    let emitter = light_emitter();
    let medium = light_medium();
    let eye_leg = x - path.entry;
    if emitter.kind == light_DIRECTIONAL {
        let optical_length = eye_leg + light_sun_leg(path, x);
        return medium.sigma_s * emitter.intensity * light_sun_phase(path)
            * exp(-medium.sigma_t * optical_length);
    }
    return light_source_behind(path, x, x - path.foot);
}

// The same for a light at a point, at x = foot + s. On a short piece far from the eye s has
// digits that x lacks.
fn light_source_behind(path: light_Path, x: f32, s: f32) -> vec3<f32> {
    let from_light = light_from_light(path, s);
    return light_factor(light_emitter(), from_light.xyz) * light_scattered(path, x, s, from_light);
}

// The same without the factor of the emission.
fn light_scattered(path: light_Path, x: f32, s: f32, from_light: vec4<f32>) -> vec3<f32> {
    let emitter = light_emitter();
    let medium = light_medium();
    let eye_leg = x - path.entry;
    // Measured from the ray, because seen from a light far away an f32 could not tell the
    // faces of the box apart.
    let point = path.origin + x * path.direction;
    let optical_length = eye_leg + light_length_inside(point, -from_light.xyz, from_light.w);
    return medium.sigma_s * emitter.intensity
        * light_window_at(emitter, from_light.w)
        * air_phase_from_foot(medium.phase, medium.phase_parameters, s, path.h)
        * exp(-medium.sigma_t * optical_length);
}

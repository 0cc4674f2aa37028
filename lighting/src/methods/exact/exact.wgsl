// Visibility: the lit intervals of a ray among the triangles of a scene; the shader's side
// of `Exact`.
//
// A triangle hides from the light an interval of the ray: what lies behind it in the plane
// through ray and light. A walk of the hierarchy of triangles, without a stack, collects these
// dark intervals. The ones nearest to the eye are kept; where they end another walk begins.
//
// Needs the parts numeric.wgsl, path.wgsl, lit.wgsl and triangles.wgsl, and what that needs.

// How many dark intervals of a ray are kept at once.
const light_exact_MOST: u32 = 16u;

// The largest rounding error of a coordinate in the plane, relative to the largest coordinate
// of a box: sums of three products are off by 3 units of 2^-24 of each product, here and
// where a triangle is cut.
const light_exact_MARGIN: f32 = 2e-6;

// The same for a position on the ray.
const light_exact_ROUNDING: f32 = 1e-6;

// A ray that passes the light more closely than this share of the light's distance counts as
// passing it at that distance: rounding would turn its plane.
const light_exact_NARROWEST: f32 = 1e-6;

// The interval that is hidden by something that hides nothing.
const light_exact_NOTHING: vec2<f32> = vec2(0.0, 0.0);

// The plane through the ray and its light, with coordinates along the ray and down from the
// light towards it. Their origin is a light at a point, so that ends of shadows have the
// digits of their direction from there. For a sun, and for a light far beyond all triangles,
// the origin is the eye.
struct light_exact_Plane {
    origin: vec3<f32>,
    is_sun: bool,
    along: vec3<f32>,
    // The distance along the ray of the foot point of a light at a point.
    foot: f32,
    // The coordinates of a light at a point.
    light: vec2<f32>,
    // Whether the origin is the eye although the light is at a point.
    is_far: bool,
    // From the light towards the ray.
    down: vec3<f32>,
    // The coordinate of the ray downwards.
    ray: f32,
    normal: vec3<f32>,
    // How far along the ray the light of a sun gets for each metre downwards.
    slope: f32,
}

struct light_exact_Cursor {
    plane: light_exact_Plane,
    // The ray has been yielded up to here.
    reached: f32,
    // All dark intervals up to here are in the list.
    known: f32,
    // The dark intervals, in order; they do not touch. Those in front of `next` are passed.
    dark: array<vec2<f32>, light_exact_MOST>,
    count: u32,
    next: u32,
}

// Whether a light at a distance from the eye is at least four times as far away as all
// triangles.
fn light_exact_is_beyond(eye: vec3<f32>, distance: f32) -> bool {
    if light_exact.nodes == 0u {
        return false;
    }
    let root = light_exact_nodes[0];
    return distance > 4.0 * length(max(abs(root.low - eye), abs(root.high - eye)));
}

fn light_exact_plane(path: light_Path) -> light_exact_Plane {
    let emitter = light_emitter();
    var plane: light_exact_Plane;
    plane.is_sun = emitter.kind == light_DIRECTIONAL;
    plane.along = path.direction;
    let to_light = select(emitter.position - path.origin, -emitter.position, plane.is_sun);
    let distance = length(to_light);
    let across = cross(path.direction, to_light);
    let h = length(across);
    let narrowest = max(light_exact_NARROWEST * distance, 1e-30);
    if h > narrowest {
        plane.normal = across / h;
    } else {
        plane.normal = light_any_normal(path.direction);
    }
    plane.down = cross(path.direction, plane.normal);
    let foot = dot(to_light, path.direction);
    if plane.is_sun {
        plane.origin = path.origin;
        plane.slope = foot / max(h, narrowest);
    } else {
        plane.foot = foot;
        plane.is_far = light_exact_is_beyond(path.origin, distance);
        if plane.is_far {
            plane.origin = path.origin;
            plane.light = vec2(foot, -max(h, narrowest));
        } else {
            plane.origin = emitter.position;
            plane.ray = max(h, narrowest);
        }
    }
    return plane;
}

fn light_exact_cursor(path: light_Path) -> light_exact_Cursor {
    var cursor: light_exact_Cursor;
    cursor.plane = light_exact_plane(path);
    cursor.reached = path.start;
    cursor.known = path.start;
    return cursor;
}

// Where the way of light through a point of the plane meets the line of the ray. The shadow of
// a point that is no lower than the light is at infinity.
fn light_exact_on_ray(plane: light_exact_Plane, point: vec2<f32>) -> f32 {
    if plane.is_sun {
        return point.x + plane.slope * point.y;
    }
    let below = point - plane.light;
    if abs(below.x) >= 1e18 * below.y {
        return select(light_FAR * sign(below.x), plane.foot, below.x == 0.0);
    }
    if plane.is_far {
        return point.x - point.y * (below.x / below.y);
    }
    return plane.foot + plane.ray * (below.x / below.y);
}

// An interval of the ray's line that contains everything that a box can hide from the light.
fn light_exact_of_box(plane: light_exact_Plane, low: vec3<f32>, high: vec3<f32>) -> vec2<f32> {
    let from_low = low - plane.origin;
    let from_high = high - plane.origin;
    let centre = 0.5 * (from_low + from_high);
    let half = 0.5 * (from_high - from_low);
    let size = abs(centre) + half;
    let margin = light_exact_MARGIN * max(size.x, max(size.y, size.z));
    if abs(dot(plane.normal, centre)) > dot(abs(plane.normal), half) + margin {
        return light_exact_NOTHING;
    }
    let middle = vec2(dot(plane.along, centre), dot(plane.down, centre));
    let reach = vec2(dot(abs(plane.along), half), dot(abs(plane.down), half)) + margin;
    let least = middle - reach;
    let most = vec2(middle.x + reach.x, min(middle.y + reach.y, plane.ray));
    if least.y > plane.ray || (!plane.is_sun && most.y <= plane.light.y) {
        return light_exact_NOTHING;
    }
    // The box lies in a rectangle of the plane, whose shadow is that of its corners.
    let a = min(
        light_exact_on_ray(plane, least),
        light_exact_on_ray(plane, vec2(least.x, most.y)),
    );
    let b = max(
        light_exact_on_ray(plane, vec2(most.x, least.y)),
        light_exact_on_ray(plane, most),
    );
    let place = select(abs(plane.foot), max(abs(least.x), abs(most.x)), plane.is_far);
    let rounding = light_exact_ROUNDING * (place + vec2(abs(a), abs(b)));
    return vec2(a - rounding.x, b + rounding.y);
}

// How far a corner is beside the plane (x), and its coordinates in the plane (yz).
fn light_exact_corner(plane: light_exact_Plane, first: u32) -> vec3<f32> {
    let corner = vec3(
        light_exact_corners[first],
        light_exact_corners[first + 1u],
        light_exact_corners[first + 2u],
    ) - plane.origin;
    return vec3(dot(plane.normal, corner), dot(plane.along, corner), dot(plane.down, corner));
}

// Where the plane cuts the edge between two corners on different sides. It is always computed
// from the upper side to the lower one, so that both triangles at an edge get the same bits.
fn light_exact_cut(a: vec3<f32>, b: vec3<f32>) -> vec2<f32> {
    let from_corner = select(a, b, a.x >= 0.0);
    let to_corner = select(b, a, a.x >= 0.0);
    let share = from_corner.x / (from_corner.x - to_corner.x);
    return from_corner.yz + share * (to_corner.yz - from_corner.yz);
}

// The interval of the ray's line that a segment of the plane hides from the light.
fn light_exact_of_segment(plane: light_exact_Plane, a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    let upper = select(b, a, a.y < b.y);
    var lower = select(a, b, a.y < b.y);
    if upper.y >= plane.ray {
        return light_exact_NOTHING;
    }
    if lower.y > plane.ray {
        // What lies beyond the ray hides nothing of it.
        let share = (plane.ray - upper.y) / (lower.y - upper.y);
        lower = vec2(upper.x + share * (lower.x - upper.x), plane.ray);
    }
    var end = light_exact_on_ray(plane, upper);
    if !plane.is_sun {
        // A segment that touches the light lies on a line through it and hides a single point,
        // wherever rounding has put it.
        let size = max(abs(a), abs(b));
        let rounding = light_exact_ROUNDING * max(size.x, size.y);
        let is_at_light = all(abs(lower - plane.light) <= vec2(rounding))
            || all(abs(upper - plane.light) <= vec2(rounding));
        if lower.y <= plane.light.y || is_at_light {
            return light_exact_NOTHING;
        }
        if upper.y <= plane.light.y {
            // The segment reaches the light's height: on that side its shadow has no end.
            let share = (plane.light.y - upper.y) / (lower.y - upper.y);
            let aside = upper.x + share * (lower.x - upper.x) - plane.light.x;
            if abs(aside) <= rounding {
                return light_exact_NOTHING;
            }
            end = light_FAR * sign(aside);
        }
    }
    let start = light_exact_on_ray(plane, lower);
    return vec2(min(start, end), max(start, end));
}

// The interval of the ray's line that a triangle hides from the light.
fn light_exact_of_triangle(plane: light_exact_Plane, triangle: u32) -> vec2<f32> {
    let a = light_exact_corner(plane, 9u * triangle);
    let b = light_exact_corner(plane, 9u * triangle + 3u);
    let c = light_exact_corner(plane, 9u * triangle + 6u);
    let is_above = vec3(a.x, b.x, c.x) >= vec3(0.0);
    if all(is_above) || !any(is_above) {
        return light_exact_NOTHING;
    }
    // The corner that is alone on its side comes first.
    var corners = array<vec3<f32>, 3>(c, a, b);
    if is_above.y == is_above.z {
        corners = array<vec3<f32>, 3>(a, b, c);
    } else if is_above.x == is_above.z {
        corners = array<vec3<f32>, 3>(b, c, a);
    }
    return light_exact_of_segment(
        plane,
        light_exact_cut(corners[0], corners[1]),
        light_exact_cut(corners[0], corners[2]),
    );
}

// Whether all of an interval is known to be dark.
fn light_exact_covers(cursor: ptr<function, light_exact_Cursor>, part: vec2<f32>) -> bool {
    for (var i = 0u; i < (*cursor).count; i++) {
        let dark = (*cursor).dark[i];
        if part.x <= dark.y {
            return dark.x <= part.x && part.y <= dark.y;
        }
    }
    return false;
}

// Adds a dark interval. If the list is full, the farthest interval is dropped and left to
// another walk.
fn light_exact_insert(cursor: ptr<function, light_exact_Cursor>, part: vec2<f32>) {
    let count = (*cursor).count;
    var first = 0u;
    while first < count && (*cursor).dark[first].y < part.x {
        first++;
    }
    // Intervals that touch it are joined with it.
    var joined = part;
    var last = first;
    while last < count && (*cursor).dark[last].x <= part.y {
        let dark = (*cursor).dark[last];
        joined = vec2(min(joined.x, dark.x), max(joined.y, dark.y));
        last++;
    }
    if last > first {
        let shift = last - first - 1u;
        if shift > 0u {
            for (var i = last; i < count; i++) {
                (*cursor).dark[i - shift] = (*cursor).dark[i];
            }
        }
        (*cursor).dark[first] = joined;
        (*cursor).count = count - shift;
        return;
    }
    var end = count;
    if count == light_exact_MOST {
        if first == count {
            (*cursor).known = part.x;
            return;
        }
        end = count - 1u;
        (*cursor).known = (*cursor).dark[end].x;
    }
    for (var i = end; i > first; i--) {
        (*cursor).dark[i] = (*cursor).dark[i - 1u];
    }
    (*cursor).dark[first] = part;
    (*cursor).count = end + 1u;
}

// Finds the dark intervals behind the part that is known.
fn light_exact_walk(cursor: ptr<function, light_exact_Cursor>, path: light_Path) {
    let plane = (*cursor).plane;
    let start = (*cursor).known;
    (*cursor).known = path.end;
    (*cursor).count = 0u;
    (*cursor).next = 0u;
    var i = 0u;
    while i < light_exact.nodes {
        let node = light_exact_nodes[i];
        let is_leaf = node.count > 0u;
        let of_box = light_exact_of_box(plane, node.low, node.high);
        var part = vec2(max(of_box.x, start), min(of_box.y, (*cursor).known));
        if !(part.x < part.y) || light_exact_covers(cursor, part) {
            i = select(node.link, i + 1u, is_leaf);
            continue;
        }
        for (var k = 0u; k < node.count; k++) {
            let hidden = light_exact_of_triangle(plane, node.link + k);
            part = vec2(max(hidden.x, start), min(hidden.y, (*cursor).known));
            if part.x < part.y {
                light_exact_insert(cursor, part);
            }
        }
        i++;
    }
}

fn light_exact_next_lit(
    cursor: ptr<function, light_exact_Cursor>,
    path: light_Path,
) -> light_Lit {
    loop {
        let reached = (*cursor).reached;
        var dark = vec2((*cursor).known);
        if (*cursor).next < (*cursor).count {
            dark = (*cursor).dark[(*cursor).next];
            (*cursor).next++;
        } else if !(reached < (*cursor).known) {
            if !(reached < path.end) {
                return light_dark();
            }
            light_exact_walk(cursor, path);
            continue;
        }
        (*cursor).reached = dark.y;
        if reached < dark.x {
            return light_lit(reached, dark.x, 1.0);
        }
    }
    return light_dark();
}

// Whether a triangle is in the way from a point: the shader's side of `Tracer::occluded`.
//
// Needs the parts numeric.wgsl and triangles.wgsl, and what that needs.

// A line that moves by less than this share of its length along an axis never gets anywhere
// there.
const light_exact_STILL: f32 = 1e-20;

// The rounding of a distance at which a line meets the side of a box, relative to the distance.
const light_exact_SLAB: f32 = 1e-6;

// Whether the line gets into a box between its origin and a length.
fn light_exact_gets_into(
    origin: vec3<f32>,
    direction: vec3<f32>,
    length: f32,
    node: light_exact_Node,
) -> bool {
    let low = node.low - origin;
    let high = node.high - origin;
    let still = abs(direction) < vec3(light_exact_STILL);
    if any(still & ((low > vec3(0.0)) | (high < vec3(0.0)))) {
        return false;
    }
    let slope = select(direction, vec3(1.0), still);
    let near = select(min(low / slope, high / slope), vec3(-light_FAR), still);
    let far = select(max(low / slope, high / slope), vec3(light_FAR), still);
    let enter = max(max(near.x, near.y), max(near.z, 0.0));
    let leave = min(min(far.x, far.y), min(far.z, length));
    return enter * (1.0 - light_exact_SLAB) <= leave * (1.0 + light_exact_SLAB);
}

fn light_exact_corner_from(origin: vec3<f32>, first: u32) -> vec3<f32> {
    return vec3(
        light_exact_corners[first],
        light_exact_corners[first + 1u],
        light_exact_corners[first + 2u],
    ) - origin;
}

// Whether the line meets a triangle between its origin and a length. Triangles at an edge get
// the same number for it but for the sign, so that a line between them meets one.
fn light_exact_is_met(
    origin: vec3<f32>,
    direction: vec3<f32>,
    length: f32,
    triangle: u32,
) -> bool {
    let a = light_exact_corner_from(origin, 9u * triangle);
    let b = light_exact_corner_from(origin, 9u * triangle + 3u);
    let c = light_exact_corner_from(origin, 9u * triangle + 6u);
    let sides = vec3(
        dot(direction, cross(b, a)),
        dot(direction, cross(c, b)),
        dot(direction, cross(a, c)),
    );
    if any(sides < vec3(0.0)) && any(sides > vec3(0.0)) {
        return false;
    }
    let normal = cross(b - a, c - a);
    let slope = dot(normal, direction);
    let height = dot(normal, a);
    // Both have the same sign in front of the origin; a line in the plane meets nothing.
    return height * sign(slope) > 0.0 && abs(height) < length * abs(slope);
}

// Distances from here on count as infinite.
const light_exact_END: f32 = 1e18;

// Whether no triangle is between a point and another one at a length, which may be light_FAR.
fn light_exact_is_open(origin: vec3<f32>, direction: vec3<f32>, length: f32) -> bool {
    let end = min(length, light_exact_END);
    var i = 0u;
    while i < light_exact.nodes {
        let node = light_exact_nodes[i];
        if !light_exact_gets_into(origin, direction, end, node) {
            i = select(node.link, i + 1u, node.count > 0u);
            continue;
        }
        for (var k = 0u; k < node.count; k++) {
            if light_exact_is_met(origin, direction, end, node.link + k) {
                return false;
            }
        }
        i++;
    }
    return true;
}

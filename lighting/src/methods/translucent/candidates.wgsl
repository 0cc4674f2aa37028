// Pieces of strands, balls, density grids and opaque triangles as candidates of the texels of a
// light's faces, which lie below each other, once for each colour with curves of its own: the
// shader's side of `FaceCandidates`.
//
// Needs the part segment.wgsl of `transmittance`, grid.wgsl, and the variables
//   light_picture: light_Picture
//   light_candidates: array<light_Candidate>
//   light_opaque: array<f32>, the depth of the nearest opaque triangle for each texel of the
//   faces

struct light_Picture {
    // Texels per metre to the right and up; per unit of the tangent for central rays.
    scale: vec2<f32>,
    // Half the number of texels per side.
    half: f32,
    resolution: u32,
    parallel: u32,
    // Depths from here on are those of no triangle.
    empty: f32,
    // Of all faces together.
    rows: u32,
    padding: u32,
}

// Positions in the picture count from the first of the texels that the candidate may touch.
struct light_Candidate {
    kind: u32,
    // First column, and the one behind the last in the upper half.
    columns: u32,
    first_row: u32,
    end_row: u32,
    // Of a strand: the ends of its axis in local coordinates, radius and opacity. Of a ball:
    // its centre and radius, then extinction, and 1 if it is soft.
    a: vec3<f32>,
    radius: f32,
    b: vec3<f32>,
    opacity: f32,
    // Of a strand, three numbers for each corner of its outline: its position in the picture,
    // and the nearest position on the axis in the picture, as a share of its length. Of a ball
    // the position of its centre in the picture, and 1 if it is well in front of the light.
    corners: array<vec4<f32>, 3>,
}

const light_STRAND: u32 = 0u;
const light_BALL: u32 = 1u;
const light_OPAQUE: u32 = 2u;
// From here on kinds are those of grids, in their order.
const light_GRID: u32 = 3u;

// Parts of the chord through a soft ball.
const light_PARTS: u32 = 4u;

fn light_blockers_candidate_texels(candidate: u32) -> vec4<u32> {
    let columns = light_candidates[candidate].columns;
    return vec4(
        columns & 0xffffu,
        light_candidates[candidate].first_row,
        columns >> 16u,
        light_candidates[candidate].end_row,
    );
}

fn light_blockers_candidate_segment_count(candidate: u32) -> u32 {
    let kind = light_candidates[candidate].kind;
    if kind >= light_GRID {
        return light_grids[kind - light_GRID].segments;
    }
    let is_soft = kind == light_BALL && light_candidates[candidate].b.y == 1.0;
    return select(1u, light_PARTS, is_soft);
}

fn light_blockers_candidate_segment(
    candidate: u32,
    texel: vec2<u32>,
    index: u32,
) -> avsm_Segment {
    var segment: avsm_Segment;
    let it = light_candidates[candidate];
    let offset = texel - vec2(it.columns & 0xffffu, it.first_row);
    if it.kind == light_STRAND {
        let met = light_strand_met(it, vec2<f32>(offset));
        segment.entry = met.x;
        segment.exit = met.y;
        segment.optical_depth[0] = met.z;
    } else if it.kind == light_BALL {
        let met = light_ball_met(it, vec2<f32>(offset), texel, index);
        segment.entry = met.x;
        segment.exit = met.y;
        segment.optical_depth[0] = met.z;
    } else if it.kind >= light_GRID {
        let rays = light_grids[it.kind - light_GRID];
        let met = light_grid_met(rays, vec2<f32>(offset), texel, index);
        segment.entry = met.x;
        segment.exit = met.y;
        segment.optical_depth[0] = met.z;
    } else {
        let row = texel.y % light_picture.rows;
        let depth = light_opaque[row * light_picture.resolution + texel.x];
        if depth < light_picture.empty {
            segment.entry = depth;
            segment.exit = depth;
            segment.optical_depth[0] = 1e30;
        }
    }
    return segment;
}

// -ln(x) for 0 < x <= 1, within 2e-7 of itself and a rounding of x; opaque for 0.
fn light_minus_ln(x: f32) -> f32 {
    if x <= 0x1p-126 {
        return 1e30;
    }
    // x = 2^exponent m with m from 0.71 to 1.42, and ln m = 2 artanh((m - 1) / (m + 1)).
    let bits = bitcast<u32>(x) - 0x3f350000u;
    let exponent = i32(bits) >> 23u;
    let m = bitcast<f32>((bits & 0x7fffffu) + 0x3f350000u);
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let ln = 2.0 * s * (1.0 + s2 * (1.0 / 3.0 + s2 * (0.2 + s2 * (1.0 / 7.0 + s2 * (1.0 / 9.0)))));
    return max(-(f32(exponent) * 0.69314718 + ln), 0.0);
}

// Polygons of at most eight corners, and their number. Of each corner the position and the
// share of the axis, which changes as positions do.
struct light_Polygon {
    corners: array<vec3<f32>, 8>,
    len: u32,
}

// The part with `sign * coordinate >= sign * limit`, relative to a texel.
fn light_cut(polygon: ptr<function, light_Polygon>, axis: u32, sign: f32, limit: f32) {
    var part: light_Polygon;
    for (var i = 0u; i < (*polygon).len; i++) {
        let start = (*polygon).corners[i];
        let end = (*polygon).corners[select(i + 1u, 0u, i + 1u == (*polygon).len)];
        let a = sign * (start[axis] - limit);
        let b = sign * (end[axis] - limit);
        if a >= 0.0 && part.len < 8u {
            part.corners[part.len] = start;
            part.len += 1u;
        }
        // Rounding may add a ninth corner, which is dropped.
        if (a < 0.0) != (b < 0.0) && part.len < 8u {
            var corner = start + (end - start) * (a / (a - b));
            corner[axis] = limit;
            part.corners[part.len] = corner;
            part.len += 1u;
        }
    }
    *polygon = part;
}

// Entry, exit and optical depth of what a strand takes from a texel.
fn light_strand_met(it: light_Candidate, offset: vec2<f32>) -> vec3<f32> {
    var part: light_Polygon;
    part.len = 4u;
    // From here on positions count from the texel, where they need their digits.
    let shift = vec3(offset, 0.0);
    part.corners[0] = it.corners[0].xyz - shift;
    part.corners[1] = vec3(it.corners[0].w, it.corners[1].xy) - shift;
    part.corners[2] = vec3(it.corners[1].zw, it.corners[2].x) - shift;
    part.corners[3] = it.corners[2].yzw - shift;
    for (var side = 0u; side < 4u; side++) {
        // Rows first, as on the CPU.
        light_cut(&part, 1u - side / 2u, 1.0 - 2.0 * f32(side % 2u), f32(side % 2u));
    }
    var twice = 0.0;
    for (var i = 2u; i < part.len; i++) {
        let u = part.corners[i - 1u] - part.corners[0];
        let v = part.corners[i] - part.corners[0];
        twice += u.x * v.y - u.y * v.x;
    }
    let coverage = min(0.5 * abs(twice), 1.0);
    if coverage <= 0.0 {
        return vec3(0.0);
    }
    var near = 0x1p+126;
    var far = -0x1p+126;
    for (var i = 0u; i < part.len; i++) {
        let depth = light_axis_depth(it, clamp(part.corners[i].z, 0.0, 1.0));
        near = min(near, depth);
        far = max(far, depth);
    }
    let passed = max(1.0 - coverage * it.opacity, 0.0);
    return vec3(near - it.radius, far + it.radius, light_minus_ln(passed));
}

// Depth of the axis at a position in the picture, given as a share of its length there.
fn light_axis_depth(it: light_Candidate, share: f32) -> f32 {
    if light_picture.parallel != 0u {
        return it.a.z + (it.b.z - it.a.z) * share;
    }
    let near = (1.0 - share) / it.a.z;
    let far = share / it.b.z;
    return length(it.a + (it.b - it.a) * (far / (near + far)));
}

// The central ray of a texel in local coordinates, as far as a metre forwards.
fn light_central_ray(texel: vec2<u32>) -> vec3<f32> {
    let row = f32(texel.y % light_picture.resolution);
    let at = vec2(f32(texel.x), row) + 0.5 - light_picture.half;
    return vec3(vec2(1.0, -1.0) * at / light_picture.scale, 1.0);
}

// Entry, exit and optical depth of what a ball takes from a texel's ray.
fn light_ball_met(
    it: light_Candidate,
    offset: vec2<f32>,
    texel: vec2<u32>,
    index: u32,
) -> vec3<f32> {
    // From the centre to the ray in the picture.
    let away = vec2(1.0, -1.0) * (offset + 0.5 - it.corners[0].xy) / light_picture.scale;
    var middle = it.a.z;
    var distance2 = dot(away, away);
    var least = -0x1p+126;
    if light_picture.parallel == 0u {
        let ray = light_central_ray(texel);
        let inverse = inverseSqrt(dot(ray, ray));
        middle = dot(it.a, ray) * inverse;
        if it.corners[0].z == 1.0 {
            // The product of centre and ray is that of the centre and their difference, in
            // which nothing cancels.
            let across = vec3(-away.y, away.x, (it.a.x * away.y - it.a.y * away.x) / it.a.z);
            distance2 = dot(across, across) * (it.a.z * inverse) * (it.a.z * inverse);
        } else {
            let across = it.a - middle * inverse * ray;
            distance2 = dot(across, across);
        }
        // What is behind the origin casts no shadow.
        least = -middle;
    }
    let h2 = (it.radius - sqrt(distance2)) * (it.radius + sqrt(distance2));
    if !(h2 > 0.0) {
        return vec3(0.0);
    }
    let half = sqrt(h2);
    least = max(least, -half);
    if least >= half {
        return vec3(0.0);
    }
    if it.b.y != 1.0 {
        return vec3(middle + least, middle + half, it.b.x * (half - least));
    }
    let from_here = least + (half - least) * (f32(index) / f32(light_PARTS));
    let to = least + (half - least) * (f32(index + 1u) / f32(light_PARTS));
    // The integral of h2 - t2, by powers of the middle so that nothing cancels.
    let between = 0.5 * (from_here + to);
    let width = to - from_here;
    let mean = (half - between) * (half + between) - width * width / 12.0;
    let tau = it.b.x * width * max(mean, 0.0) / (it.radius * it.radius);
    return vec3(middle + from_here, middle + to, tau);
}

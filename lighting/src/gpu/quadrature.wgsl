// Airlight of any light: the nodes of airlight's quadrature on each piece
// between two kinks, or texel by texel if the light has a cookie.
//
// Needs the parts SEGMENT, NUMERIC, SCALED and NODES of `airlight`, and the
// variables
//   light_rules: air_Quadrature
//   light_rule_entries: array<vec4<f32>>

fn air_quadrature_uniforms() -> air_Quadrature {
    return light_rules;
}

fn air_quadrature_entry(index: u32) -> vec4<f32> {
    return light_rule_entries[index];
}

fn light_segment(path: light_Path, start: f32, end: f32) -> air_Segment {
    let length = select(end - start, air_FAR, end == light_FAR);
    return air_Segment(start - path.entry, start - path.foot, path.h, length);
}

fn light_quadrature_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    if light_emitter().kind == light_DIRECTIONAL {
        return light_directional(path, start, end);
    }
    var total = vec3(0.0);
    var from_here = start;
    for (var i = 0u; i < light_KINKS; i++) {
        let kink = path.kinks[i];
        if kink >= end {
            break;
        }
        if from_here < kink {
            total += light_smooth_quadrature(path, from_here, kink);
            from_here = kink;
        }
    }
    return total + light_smooth_quadrature(path, from_here, end);
}

// The airlight of an interval without a kink inside.
fn light_smooth_quadrature(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    if !(start < end) {
        return vec3(0.0);
    }
    if path.h == 0.0 && start <= path.foot && path.foot <= end {
        return vec3(light_FAR);
    }
    if light_emitter().cookie_width > 0u {
        return light_cookie_airlight(path, start, end);
    }
    let segment = light_segment(path, start, end);
    let pattern = light_pattern(path, start, end);
    let sigma_t = light_medium().sigma_t;
    let red = light_node_sum(path, segment, pattern, start, sigma_t.x);
    if all(sigma_t == vec3(sigma_t.x)) {
        return red;
    }
    let green = light_node_sum(path, segment, pattern, start, sigma_t.y);
    let blue = light_node_sum(path, segment, pattern, start, sigma_t.z);
    return vec3(red.x, green.y, blue.z);
}

// What besides the phase function and the extinction changes along an interval without a
// kink inside.
fn light_pattern(path: light_Path, start: f32, end: f32) -> air_Pattern {
    let emitter = light_emitter();
    var pattern = air_Pattern();
    pattern.extra = select(light_OUTSIDE, 0u, light_is_immersed());
    if emitter.emission == light_COSINE {
        pattern.extra += air_EXTRA_COSINE;
        pattern.deeper = air_DEEPER;
    } else if emitter.emission == light_SPOT {
        // Inside of the inner cone a spot is a plain light.
        let s = start - path.foot;
        let middle = select(s + 0.5 * (end - start), s + abs(s) + path.h + 1.0, end == light_FAR);
        let off_axis = emitter.axis - light_from_light(path, middle).xyz;
        if 0.5 * dot(off_axis, off_axis) > emitter.outer_versine - emitter.edge {
            pattern.extra += air_EXTRA_SPOT;
            pattern.deeper = air_DEEPER;
        }
    }
    if emitter.fades != 0u {
        pattern.extra += air_EXTRA_FADING;
        pattern.deeper = air_DEEPER;
        pattern.range = emitter.range;
    }
    return pattern;
}

// Extra nodes on each piece if the light is outside of the medium.
const light_OUTSIDE: u32 = 2u;

// ∫ light_source / d² dx with the nodes for this extinction.
fn light_node_sum(
    path: light_Path,
    segment: air_Segment,
    pattern: air_Pattern,
    start: f32,
    sigma_t: f32,
) -> vec3<f32> {
    var sum = vec3(0.0);
    var nodes = air_pattern_nodes(sigma_t, segment, pattern);
    loop {
        let node = air_next_node(&nodes);
        if node.done {
            break;
        }
        sum += node.weight * light_source(path, start + node.distance);
    }
    return sum;
}

// Airlight: Gauss–Legendre quadrature in the equi-angular variable.
//
// Needs the variables
//   light_node_count: u32
//   light_nodes: array<vec2<f32>>, each a position in (0, 1) and a weight

fn light_equi_angular_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {
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
            total += light_equi_angular_smooth(path, from_here, kink);
            from_here = kink;
        }
    }
    return total + light_equi_angular_smooth(path, from_here, end);
}

// The airlight of an interval without a kink inside.
fn light_equi_angular_smooth(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    if !(start < end) {
        return vec3(0.0);
    }
    let arc = light_arc(path, start, end);
    if arc.extent == light_FAR {
        return vec3(light_FAR);
    }
    var sum = vec3(0.0);
    for (var i = 0u; i < light_node_count; i++) {
        let node = light_nodes[i];
        sum += node.y * light_source(path, light_arc_position(arc, node.x));
    }
    return arc.extent * sum;
}

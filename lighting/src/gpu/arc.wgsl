// An interval of a path as an arc seen from a point light: the shader's side
// of the equi-angular variable.

struct light_Arc {
    // Distances of the ends from the eye, m.
    start: f32,
    end: f32,
    // Distances of the ends from the light, m; light_FAR for an infinite end.
    d_a: f32,
    d_b: f32,
    // The angle that the interval spans at the light.
    angle: f32,
    // π − angle. Near a half turn `angle` itself has too few digits for its sine.
    supplement: f32,
    // ∫ dx / d², light_FAR if the light is on the interval.
    extent: f32,
}

fn light_arc(path: light_Path, start: f32, end: f32) -> light_Arc {
    let h = path.h;
    let s_a = start - path.foot;
    var across = h;
    var along = s_a;
    var per_h = 1.0 / max(s_a, 1e-30);
    var d_b = light_FAR;
    if end < light_FAR {
        let s_b = end - path.foot;
        across = h * (s_b - s_a);
        along = h * h + s_a * s_b;
        per_h = (end - start) / max(along, 1e-38);
        d_b = sqrt(s_b * s_b + h * h);
    }
    let angle = light_angle(across, along);
    var extent = light_FAR;
    if along > 0.0 && across <= 1e-4 * along {
        let ratio = across / along;
        extent = per_h * (1.0 - ratio * ratio / 3.0);
    } else if h > 0.0 {
        extent = angle / h;
    }
    let supplement = light_angle(across, -along);
    return light_Arc(start, end, sqrt(s_a * s_a + h * h), d_b, angle, supplement, extent);
}

// The distance from the eye at the fraction t in (0, 1) of the angle.
fn light_arc_position(arc: light_Arc, t: f32) -> f32 {
    var from_a = 1.0 - t;
    var from_b = t;
    if arc.angle > 1e-3 && t != 0.5 {
        from_a = light_arc_sine(arc, 1.0 - t, t);
        from_b = light_arc_sine(arc, t, 1.0 - t);
    }
    if arc.d_b == light_FAR {
        return arc.start + arc.d_a * (from_b / from_a);
    }
    let weight_a = from_a * arc.d_b;
    let weight_b = from_b * arc.d_a;
    let share = weight_b / (weight_a + weight_b);
    return clamp(arc.start + (arc.end - arc.start) * share, arc.start, arc.end);
}

// sin(part · angle); `part` and `rest` add up to 1.
fn light_arc_sine(arc: light_Arc, part: f32, rest: f32) -> f32 {
    let angle = part * arc.angle;
    if angle > 0.5 * light_PI {
        return light_sin(arc.supplement + rest * arc.angle);
    }
    return light_sin(angle);
}

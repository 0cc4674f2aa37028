// Visibility: a march in equal steps of distance or angle, one lookup each.
//
// Needs
//   fn light_march_visibility(point: vec3<f32>) -> f32
//   fn light_march_samples() -> u32
//   fn light_march_is_equi_angular() -> bool

struct light_Look {
    arc: light_Arc,
    equi_angular: bool,
    end: f32,
    // Start of the next step, and its number.
    start: f32,
    step: u32,
}

fn light_look(path: light_Path) -> light_Look {
    var look: light_Look;
    look.start = path.start;
    look.step = 0u;
    look.equi_angular = light_march_is_equi_angular() && light_emitter().kind == light_POINT;
    if look.equi_angular {
        look.arc = light_arc(path, path.start, path.end);
        look.end = path.end;
    } else {
        look.end = min(path.end, path.start + light_medium().far_end);
    }
    return look;
}

fn light_march_position(look: light_Look, path: light_Path, t: f32) -> f32 {
    if look.equi_angular {
        return light_arc_position(look.arc, t);
    }
    return path.start + t * (look.end - path.start);
}

fn light_next_lit(look: ptr<function, light_Look>, path: light_Path) -> light_Lit {
    let samples = light_march_samples();
    let step = 1.0 / f32(samples);
    while (*look).step < samples {
        let i = (*look).step;
        (*look).step = i + 1u;
        let start = (*look).start;
        var end = (*look).end;
        if i + 1u < samples {
            end = light_march_position(*look, path, f32(i + 1u) * step);
        }
        let middle = light_march_position(*look, path, (f32(i) + 0.5) * step);
        (*look).start = max(start, end);
        if start < end {
            let visibility = light_march_visibility(path.origin + middle * path.direction);
            if visibility > 0.0 {
                return light_Lit(start, end, visibility);
            }
        }
    }
    return light_Lit(0.0, 0.0, 0.0);
}

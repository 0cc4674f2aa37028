// The airlight of parallel light over an interval, in closed form.

// The optical path is linear in x between the positions at which sunlight
// changes the face of the box through which it comes in.
fn light_directional(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    if !(start < end) {
        return vec3(0.0);
    }
    let medium = light_medium();
    let light = medium.sigma_s * light_emitter().intensity * light_sun_phase(path);
    if medium.bounded == 0u {
        return light * light_directional_piece(medium, start - path.entry, 1.0, start, end);
    }
    let kinks = light_face_changes(path);
    var total = vec3(0.0);
    var begin = start;
    for (var i = 0u; i < 3u; i++) {
        var to = end;
        if i < 2u {
            to = min(kinks[i], end);
        }
        if begin < to {
            let first = (begin - path.entry) + light_sun_leg(path, begin);
            let last = (to - path.entry) + light_sun_leg(path, to);
            total += light_directional_piece(medium, first, (last - first) / (to - begin), begin, to);
            begin = to;
        }
    }
    return light * total;
}

// ∫ exp(−σ_t (first + slope (x − start))) dx.
fn light_directional_piece(medium: light_Medium, first: f32, slope: f32, start: f32, end: f32) -> vec3<f32> {
    var length = vec3(end - start);
    if end == light_FAR {
        // The tail of an exponential; where nothing is extinguished it is cut
        // off like everything infinite.
        length = min(length, 100.0 / max(medium.sigma_t * slope, vec3(1e-36)));
    }
    let k = medium.sigma_t * slope;
    let mean = vec3(
        light_mean_exponential(k.x * length.x),
        light_mean_exponential(k.y * length.y),
        light_mean_exponential(k.z * length.z),
    );
    return exp(-medium.sigma_t * first) * mean * length;
}

// Positions of those changes in order, light_FAR where there are fewer than two.
fn light_face_changes(path: light_Path) -> vec2<f32> {
    let medium = light_medium();
    let back = -light_emitter().position;
    // The distance to the face along one axis is base + slope x; absent for
    // light along that face.
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
        // The third line must not lie below the crossing, up to rounding.
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

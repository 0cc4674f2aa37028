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
    var total = vec3(0.0);
    var begin = start;
    for (var i = 0u; i < 3u; i++) {
        var to = end;
        if i < 2u {
            to = min(path.kinks[i], end);
        }
        if begin < to {
            let first = (begin - path.entry) + light_sun_leg(path, begin);
            let last = (to - path.entry) + light_sun_leg(path, to);
            // With the sun behind the eye the optical path may fall along the ray. The piece
            // then counts from its other end.
            let rise = abs(last - first) / (to - begin);
            total += light_directional_piece(medium, min(first, last), rise, begin, to);
            begin = to;
        }
    }
    return light * total;
}

// ∫ exp(−σ_t (first + slope (x − start))) dx.
fn light_directional_piece(medium: light_Medium, first: f32, slope: f32, start: f32, end: f32) -> vec3<f32> {
    var length = vec3(end - start);
    if end == light_FAR {
        // The tail of an exponential ends after a hundred mean free paths. Where there is no
        // extinction an infinite ray is cut off, too.
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

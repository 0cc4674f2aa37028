// Airlight: the integrand at the middle of the interval times the interval's length.

fn light_midpoint_airlight(path: light_Path, start: f32, whole_end: f32) -> vec3<f32> {
    let end = min(whole_end, start + light_medium().far_end);
    if !(start < end) {
        return vec3(0.0);
    }
    let x = start + 0.5 * (end - start);
    var inverse_square = 1.0;
    if light_emitter().kind == light_POINT {
        let s = x - path.foot;
        inverse_square = 1.0 / (s * s + path.h * path.h);
    }
    return light_source(path, x) * (inverse_square * (end - start));
}

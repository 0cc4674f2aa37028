// Airlight as if all light were daylight: the shader's side of `Daylight`.
//
// Needs the variable
//   light_daylight_distance: f32

fn light_daylight_airlight(path: light_Path, start: f32, whole_end: f32) -> vec3<f32> {
    let emitter = light_emitter();
    let medium = light_medium();
    if emitter.kind == light_DIRECTIONAL {
        return light_directional(path, start, whole_end);
    }
    let end = min(whole_end, start + medium.far_end);
    if !(start < end) {
        return vec3(0.0);
    }
    let s = start + 0.5 * (end - start) - path.foot;
    var factor = vec3(1.0);
    // At the light itself there is no direction.
    if s != 0.0 || path.h > 0.0 {
        factor = light_factor(emitter, light_from_light(path, s).xyz);
    }
    let irradiance = emitter.intensity * factor
        / (light_daylight_distance * light_daylight_distance);
    return medium.sigma_s * irradiance
        * air_phase_from_foot(medium.phase, medium.phase_parameters, s, path.h)
        * light_directional_piece(medium, start - path.entry, 1.0, start, end);
}

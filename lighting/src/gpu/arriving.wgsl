// Direct light on surfaces: the shader's side of `Arriving`. Needs the part PATH and what
// that needs.

// The irradiance that the light gives to a surface at a position, without shadow.
fn light_arriving(position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let emitter = light_emitter();
    let medium = light_medium();
    var to_light = -emitter.position;
    var irradiance = emitter.intensity;
    var way = 0.0;
    if emitter.kind == light_DIRECTIONAL {
        // In a medium without bounds the irradiance of the sun is that at the surface.
        if medium.bounded != 0u {
            way = light_length_inside(position, to_light, light_FAR);
        }
    } else {
        let offset = emitter.position - position;
        let distance = length(offset);
        if !(distance > 0.0 && distance <= emitter.range) {
            return vec3(0.0);
        }
        to_light = offset / distance;
        irradiance *= light_factor(emitter, -to_light) * light_window_at(emitter, distance);
        irradiance /= distance * distance;
        way = light_length_inside(position, to_light, distance);
    }
    return irradiance * max(dot(normal, to_light), 0.0) * exp(-medium.sigma_t * way);
}

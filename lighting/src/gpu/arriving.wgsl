// Light that reaches a point directly: the shader's side of `Arriving`. Needs the part PATH and
// what that needs.

struct light_Arriving {
    // The unit direction to the light, and its distance, m; light_FAR for a directional light.
    to_light: vec3<f32>,
    distance: f32,
    // The irradiance of a surface that faces the light, without shadow and fog; 0 where the
    // light does not reach.
    irradiance: vec3<f32>,
    // The share that the medium lets through on the way.
    through: vec3<f32>,
}

fn light_arriving_at(position: vec3<f32>) -> light_Arriving {
    let emitter = light_emitter();
    let medium = light_medium();
    var light: light_Arriving;
    light.to_light = -emitter.position;
    light.distance = light_FAR;
    light.irradiance = emitter.intensity;
    light.through = vec3(1.0);
    var way = 0.0;
    if emitter.kind == light_DIRECTIONAL {
        // In a medium without bounds the irradiance of the sun is that at the surface.
        if medium.bounded != 0u {
            way = light_length_inside(position, light.to_light, light_FAR);
        }
    } else {
        let offset = emitter.position - position;
        light.distance = length(offset);
        if !(light.distance > 0.0 && light.distance <= emitter.range) {
            light.irradiance = vec3(0.0);
            return light;
        }
        light.to_light = offset / light.distance;
        light.irradiance *= light_factor(emitter, -light.to_light)
            * light_window_at(emitter, light.distance);
        light.irradiance /= light.distance * light.distance;
        way = light_length_inside(position, light.to_light, light.distance);
    }
    light.through = exp(-medium.sigma_t * way);
    return light;
}

// The irradiance that the light gives to a surface at a position, without shadow.
fn light_arriving(position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let light = light_arriving_at(position);
    return light.irradiance * max(dot(normal, light.to_light), 0.0) * light.through;
}

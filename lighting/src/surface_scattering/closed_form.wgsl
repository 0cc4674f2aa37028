// The light that fog scatters to surfaces, for points that shine alike in all directions and
// for suns, in fog without bounds: the shader's side of `ClosedForm`.
//
// Needs the part SURFACE of `airlight`, and the variables
//   light_lobe: array<f32>           coefficients of the table of a Lambertian surface
//   light_sun_table: array<f32>      over the cosine to the sun from −1 to 1

fn air_surface_coefficient(index: u32) -> f32 {
    return light_lobe[index];
}

fn light_closed_form_irradiance(position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let emitter = light_emitter();
    let medium = light_medium();
    if emitter.kind == light_DIRECTIONAL {
        let last = arrayLength(&light_sun_table) - 1u;
        let cos = dot(normal, -emitter.position);
        let x = clamp(0.5 * cos + 0.5, 0.0, 1.0) * f32(last);
        let first = min(u32(x), last - 1u);
        let low = light_sun_table[first];
        let share = low + (x - f32(first)) * (light_sun_table[first + 1u] - low);
        // A colour without extinction has no scattering either.
        let divisor = select(medium.sigma_t, vec3(1.0), medium.sigma_t <= vec3(0.0));
        return medium.sigma_s / divisor * emitter.intensity * share;
    }
    let to_light = emitter.position - position;
    let distance = length(to_light);
    if distance <= 0.0 {
        return vec3(0.0);
    }
    let cos = dot(normal, to_light / distance);
    var gathered = vec3(air_lobe(medium.sigma_t.x * distance, cos));
    if medium.sigma_t.y != medium.sigma_t.x {
        gathered.y = air_lobe(medium.sigma_t.y * distance, cos);
    }
    if medium.sigma_t.z != medium.sigma_t.y {
        gathered.z = air_lobe(medium.sigma_t.z * distance, cos);
    } else {
        gathered.z = gathered.y;
    }
    return medium.sigma_s * emitter.intensity * gathered * (0.5 / light_PI / distance);
}

// An evaluator that looks airlight up in a table where the light shines alike in all
// directions from within the medium and does not fade, which includes the full cone of
// spotlights. Elsewhere it is the quadrature.
//
// Needs the part TABLE of `airlight` too, and the variables
//   light_table: air_Table
//   light_table_cells: array<vec4<u32>>

fn air_table_uniforms() -> air_Table {
    return light_table;
}

fn air_table_cell(index: u32) -> vec4<u32> {
    return light_table_cells[index];
}

fn light_analytic_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    return light_airlight_by_cone(path, start, end);
}

// The airlight of an interval in which the light shines alike in all directions.
fn light_plain_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    let medium = light_medium();
    let segment = light_segment(path, start, end);
    let sigma_t = medium.sigma_t;
    var airlight = vec3(air_table_airlight(sigma_t.x, segment));
    if !all(sigma_t == vec3(sigma_t.x)) {
        airlight.y = air_table_airlight(sigma_t.y, segment);
        airlight.z = air_table_airlight(sigma_t.z, segment);
    }
    // A channel without light stays dark, even where the ray meets the light.
    let light = medium.sigma_s * light_emitter().intensity;
    return select(vec3(0.0), min(light * airlight, vec3(light_FAR)), light > vec3(0.0));
}

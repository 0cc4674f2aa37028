// Tables of a frame as the evaluator, for what of the light by_cone.wgsl finds plain;
// the quadrature for what they do not know.
//
// Needs the part FRAME_TABLE of `airlight` too, and the variables
//   light_frame_tables: array<air_FrameTable, 3>
//   light_frame_cells: array<vec4<f32>>

// More mean free paths than that before the fog begins are not looked up.
const light_FRAME_DEEPEST: f32 = 16.0;

fn air_frame_cell(index: u32) -> vec4<f32> {
    return light_frame_cells[index];
}

fn light_per_frame_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    return light_airlight_by_cone(path, start, end);
}

fn light_plain_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {
    let medium = light_medium();
    var airlight = vec3(light_frame_airlight(0u, medium.sigma_t.x, path, start, end));
    if !all(medium.sigma_t == vec3(medium.sigma_t.x)) {
        airlight.y = light_frame_airlight(1u, medium.sigma_t.y, path, start, end);
        airlight.z = light_frame_airlight(2u, medium.sigma_t.z, path, start, end);
    }
    if any(airlight < vec3(0.0)) {
        return light_smooth_quadrature(path, start, end);
    }
    return medium.sigma_s * light_emitter().intensity * airlight;
}

// That of a channel; negative where its table does not know, or is for another extinction.
fn light_frame_airlight(
    channel: u32,
    sigma_t: f32,
    path: light_Path,
    start: f32,
    end: f32,
) -> f32 {
    let table = light_frame_tables[channel];
    // The way to a box of fog is clear.
    let clear = table.sigma_t * path.entry;
    if table.rows == 0u || table.sigma_t != sigma_t || clear > light_FRAME_DEEPEST {
        return air_FRAME_UNKNOWN;
    }
    // Of the whole ray, from the eye on.
    var segment = light_segment(path, start, end);
    segment.x = start;
    let airlight = air_frame_look_up(table, segment);
    return select(airlight, airlight * exp(clear), clear > 0.0 && airlight > 0.0);
}

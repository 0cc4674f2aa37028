// An evaluator that looks airlight up in tables made for the frame where by_cone.wgsl finds
// the light plain, and is the quadrature for what the tables do not know.
//
// Needs the part FRAME_TABLE of `airlight` too, and the variables
//   light_frame_tables: array<air_FrameTable, 3>
//   light_frame_cells: array<vec4<f32>>

// Where the fog begins more than this many mean free paths from the eye, nothing is looked
// up; `FrameTable::DEEPEST`.
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

// The airlight of a channel, per unit of σ_s I; negative where its table does not know it, or
// was made for another extinction.
fn light_frame_airlight(
    channel: u32,
    sigma_t: f32,
    path: light_Path,
    start: f32,
    end: f32,
) -> f32 {
    let table = light_frame_tables[channel];
    // The table takes the ray to be in fog from the eye on, but the way to a box of fog is
    // clear.
    let clear = table.sigma_t * path.entry;
    if table.rows == 0u || table.sigma_t != sigma_t || clear > light_FRAME_DEEPEST {
        return air_FRAME_UNKNOWN;
    }
    // The table measures from the eye, not from where the fog begins.
    var segment = light_segment(path, start, end);
    segment.x = start;
    let airlight = air_frame_look_up(table, segment);
    return select(airlight, airlight * exp(clear), clear > 0.0 && airlight > 0.0);
}

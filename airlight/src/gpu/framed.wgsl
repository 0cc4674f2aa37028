// A table of a frame that is bound by itself, with a quadrature for what the table does
// not know. Needs the parts of both, and the variables
//   air_frame: air_FrameTable
//   air_frame_cells: array<vec4<f32>>

fn air_frame_cell(index: u32) -> vec4<f32> {
    return air_frame_cells[index];
}

// Airlight per unit of σ_s I, in 1/(m sr), for any extinction and segment.
fn air_framed_airlight(sigma_t: f32, segment: air_Segment) -> f32 {
    if sigma_t == air_frame.sigma_t {
        let known = air_frame_look_up(air_frame, segment);
        if known >= 0.0 {
            return known;
        }
    }
    return air_quadrature_airlight(sigma_t, segment);
}

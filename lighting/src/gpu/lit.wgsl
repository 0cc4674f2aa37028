// A part of a path that the light reaches, with the share of each colour that
// gets there. A visibility source yields the lit parts of the path in order, then
// light_dark().

struct light_Lit {
    start: f32,
    end: f32,
    visibility: vec3<f32>,
}

// A part with the same share for all colours.
fn light_lit(start: f32, end: f32, visibility: f32) -> light_Lit {
    return light_Lit(start, end, vec3(visibility));
}

// The end of a list of lit parts.
fn light_dark() -> light_Lit {
    return light_Lit(0.0, 0.0, vec3(0.0));
}

fn light_is_dark(part: light_Lit) -> bool {
    return !any(part.visibility > vec3(0.0));
}

// A part of an eye ray as a point light sees it: the shader's side of
// `Segment`.

// Stands for an infinite length, and for the airlight of a segment that
// contains the light: f32::MAX. Shaders may assume that infinities do not
// occur.
const air_FAR: f32 = 0x1.fffffep+127;

struct air_Segment {
    // The distance of the start from the eye, m.
    x: f32,
    // The position of the start, m: 0 at the foot point of the light, negative in front.
    s: f32,
    // The distance between the ray's line and the light, m, ≥ 0.
    h: f32,
    // m.
    length: f32,
}

// The first `distance` metres of the ray from an eye along a unit vector.
fn air_segment(eye: vec3<f32>, direction: vec3<f32>, light: vec3<f32>, distance: f32) -> air_Segment {
    let to_light = light - eye;
    let across = cross(direction, to_light);
    return air_Segment(0.0, -dot(direction, to_light), sqrt(dot(across, across)), distance);
}

// The part of a segment between two distances from its start, m.
fn air_part(segment: air_Segment, start: f32, end: f32) -> air_Segment {
    return air_Segment(segment.x + start, segment.s + start, segment.h, end - start);
}

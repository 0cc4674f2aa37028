// A part of an eye ray as a point light sees it: the shader's side of
// `Segment`.

// Stands for an infinite length, and for the airlight of a segment that
// contains the light: f32::MAX. Shaders may assume that infinities do not
// occur.
const air_FAR: f32 = 0x1.fffffep+127;

struct air_Segment {
    x: f32,
    s: f32,
    h: f32,
    length: f32,
}

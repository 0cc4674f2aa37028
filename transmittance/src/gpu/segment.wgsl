// A blocker between two depths, with an optical depth for each channel. Optical depths of
// 1e30 and more are opaque.
struct avsm_Segment {
    entry: f32,
    exit: f32,
    optical_depth: array<f32, avsm_CHANNELS>,
}

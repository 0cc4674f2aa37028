//! A part of an eye ray as a point light sees it.

/// A part of an eye ray as a point light sees it.
///
/// ```text
///                     P  light
///                   / |
///             d   /   | h
///               /     |
///   E ────────X───────F──────→ ray      s = x − x_F  (here s < 0)
///   eye       x       foot point
/// ```
///
/// Four lengths in metres, each known to full precision by itself: nothing is
/// left to be formed as a difference, so that short parts and rays that all
/// but meet the light keep their digits. The layout is that of a
/// `vec4<f32>` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Segment {
    /// Way from the eye to the start of the part, at least 0. In a bounded
    /// medium only the way inside of it counts. A negative way is not turned
    /// away: it counts as it is, and dims the light less, as long as the whole
    /// way from the light is not negative too, where a result may be 0.
    pub x: f32,
    /// Position of the start behind the foot point of the light, negative in
    /// front of it.
    pub s: f32,
    /// Distance between the light and the line of the ray, at least 0.
    pub h: f32,
    /// Length of the part, at least 0, may be infinite. `f32::MAX` is endless
    /// too, which is how shaders must be told.
    pub length: f32,
}

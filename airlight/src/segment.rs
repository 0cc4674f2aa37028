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

impl Segment {
    /// The first `length` metres of the ray from `eye` along `direction`, a unit
    /// vector, as a light at `light` sees them.
    ///
    /// The products are summed in f64: `s` and `h` have the error of the vectors that
    /// were given, which is about 2⁻²⁴ of the distance between eye and light.
    ///
    /// ```
    /// use airlight::Segment;
    ///
    /// let ray = Segment::from_ray([0.0; 3], [0.0, 0.0, -1.0], [1.0, 0.0, -4.0], 10.0);
    /// assert_eq!(ray, Segment { x: 0.0, s: -4.0, h: 1.0, length: 10.0 });
    /// // What is lit of it, if something is in the way of the rest.
    /// let lit = ray.part(2.0, 5.0);
    /// assert_eq!(lit, Segment { x: 2.0, s: -2.0, h: 1.0, length: 3.0 });
    /// ```
    pub fn from_ray(
        eye: impl Into<[f32; 3]>,
        direction: impl Into<[f32; 3]>,
        light: impl Into<[f32; 3]>,
        length: f32,
    ) -> Self {
        let [eye, [x, y, z], light] =
            [eye.into(), direction.into(), light.into()].map(|v| v.map(f64::from));
        let [a, b, c] = [0, 1, 2].map(|k| light[k] - eye[k]);
        let across = [y * c - z * b, z * a - x * c, x * b - y * a];
        Self {
            x: 0.0,
            s: -(x * a + y * b + z * c) as f32,
            h: across.iter().map(|v| v * v).sum::<f64>().sqrt() as f32,
            length,
        }
    }

    /// The part between two distances from the start of this one, m, such as a lit
    /// interval of the ray.
    #[must_use]
    pub fn part(&self, start: f32, end: f32) -> Self {
        Self {
            x: self.x + start,
            s: self.s + start,
            h: self.h,
            length: end - start,
        }
    }
}

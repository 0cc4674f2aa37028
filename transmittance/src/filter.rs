//! Questions to a map between its texel centres.

/// How a map is asked between its texel centres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filter {
    /// The texel that the point lies in.
    Nearest,
    /// Transmittances of the four texels around, weighted.
    #[default]
    Bilinear,
}

/// A point whose share of the light is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Receiver {
    /// Column and row in texels: texel centres are at 0.5, 1.5, … Points outside
    /// of the map count as at its edge, NaN as 0.
    pub position: [f32; 2],
    /// Depth, as the segments have it.
    pub depth: f32,
}

/// The answer to a receiver, from the answers of texels of these numbers.
#[inline]
pub(crate) fn filtered<const C: usize>(
    [width, height]: [usize; 2],
    position: [f32; 2],
    filter: Filter,
    texel: impl Fn(usize) -> [f32; C],
) -> [f32; C] {
    if width == 0 || height == 0 {
        return [1.0; C];
    }
    let [x, y] = position;
    match filter {
        Filter::Nearest => {
            // The conversion cuts off what is outside, and makes 0 of NaN.
            let (x, y) = ((x as usize).min(width - 1), (y as usize).min(height - 1));
            texel(y * width + x)
        }
        Filter::Bilinear => {
            let ([left, right], u) = neighbours(x, width);
            let ([above, below], v) = neighbours(y, height);
            let row = |y: usize| {
                let (left, right) = (texel(y * width + left), texel(y * width + right));
                std::array::from_fn::<_, C, _>(|c| left[c] + (right[c] - left[c]) * u)
            };
            let (above, below) = (row(above), row(below));
            // Rounding may leave the range of the four by an ULP.
            std::array::from_fn(|c| (above[c] + (below[c] - above[c]) * v).clamp(0.0, 1.0))
        }
    }
}

/// The two texels around a position, and the weight of the second.
fn neighbours(position: f32, count: usize) -> ([usize; 2], f32) {
    let position = (position - 0.5).max(0.0);
    let first = (position as usize).min(count - 1);
    let second = (first + 1).min(count - 1);
    ([first, second], (position - first as f32).min(1.0))
}

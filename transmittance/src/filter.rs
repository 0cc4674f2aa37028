//! Questions to a map between its texel centres.

/// How a map is asked between its texel centres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filter {
    /// The texel that the point lies in.
    Nearest,
    /// Transmittances of the four texels around, weighted.
    #[default]
    Bilinear,
    /// The mean over a square of so many texels per side with the point at its centre: softer
    /// shadows, with less noise of single texels. A texel counts as far as the square covers
    /// it, so the result changes without steps as the point moves. `Square(1)` is
    /// [`Filter::Bilinear`], `Square(0)` is [`Filter::Nearest`]. Costs (side + 1)² lookups.
    ///
    /// Drivers in software end the loops of a shader's invocation after 65,535 turns, of which
    /// a lookup takes up to the curve's nodes: with them, ask for less.
    Square(u8),
}

impl Filter {
    /// Texels per side of the square over which the mean is taken, 0 for the nearest texel.
    pub fn side(self) -> u8 {
        match self {
            Self::Nearest => 0,
            Self::Bilinear => 1,
            Self::Square(side) => side,
        }
    }
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
    match filter.side() {
        0 => {
            // The conversion cuts off what is outside, and makes 0 of NaN.
            let (x, y) = ((x as usize).min(width - 1), (y as usize).min(height - 1));
            texel(y * width + x)
        }
        1 => {
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
        side => {
            let mean = 1.0 / (f32::from(side) * f32::from(side));
            let mut sum = [0.0; C];
            for (y, of_row) in covered(y, side, height) {
                let mut row = [0.0; C];
                for (x, of_column) in covered(x, side, width) {
                    let texel = texel(y * width + x);
                    row = std::array::from_fn(|c| row[c] + texel[c] * of_column);
                }
                sum = std::array::from_fn(|c| sum[c] + row[c] * of_row);
            }
            sum.map(|sum| (sum * mean).clamp(0.0, 1.0))
        }
    }
}

/// The texels that `side` texels around a position reach into, and how much of each they
/// cover; beside the map it is the texel at its rim.
fn covered(position: f32, side: u8, count: usize) -> impl Iterator<Item = (usize, f32)> {
    // NaN is 0.
    let position = position.max(0.0).min(count as f32);
    let start = position - 0.5 * f32::from(side);
    let first = start.floor();
    let beside = start - first;
    (0..=side).map(move |i| {
        let covered = match i {
            0 => 1.0 - beside,
            _ if i == side => beside,
            _ => 1.0,
        };
        // The conversion cuts off what is before the first.
        let texel = ((first + f32::from(i)) as usize).min(count - 1);
        (texel, covered)
    })
}

/// The two texels around a position, and the weight of the second.
fn neighbours(position: f32, count: usize) -> ([usize; 2], f32) {
    let position = (position - 0.5).max(0.0);
    let first = (position as usize).min(count - 1);
    let second = (first + 1).min(count - 1);
    ([first, second], (position - first as f32).min(1.0))
}

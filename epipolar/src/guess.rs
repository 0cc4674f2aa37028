//! A first guess of the voxel along φ that holds a pair.
//!
//! Bounds lie along φ as a [`Spacing`](crate::Spacing) likes. What is tabulated here is which
//! of them come before each of many cells of equal width in
//!
//! ```text
//! t = q / (w + q)          point lights, w ≥ 0
//! t = 2 − q / (q − w)      point lights, w < 0
//! t = q / w                directional lights
//! ```
//!
//! which grows with φ, takes one division, and by a factor of two at most is as steep as the
//! angle. With [`CELLS`] cells per voxel of equal angles no cell has more than one bound, so
//! that one comparison decides between the guess and the voxel after it. A guess may be
//! wrong, for what is rounded and for other spacings: whoever takes it has to check.

use glam::Vec2;

/// Cells per voxel: voxels of equal angles are at least half of the mean in t.
const CELLS: usize = 4;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Guess {
    /// The last bound before each cell; the first one if there is none.
    bounds: Vec<u16>,
    /// t where the cells begin, and cells per t.
    start: f32,
    scale: f32,
    directional: bool,
}

impl Guess {
    /// For the bounds of voxels, one more than there are voxels.
    pub(crate) fn new(bounds: &[Vec2], directional: bool) -> Self {
        let voxels = bounds.len() - 1;
        let cells = CELLS * voxels;
        let start = measure(directional, bounds[0]);
        let scale = cells as f32 / (measure(directional, bounds[voxels]) - start);
        let mut guess = Self {
            bounds: vec![0; cells],
            start,
            // Bounds that all but coincide have one cell.
            scale: if scale.is_finite() { scale } else { 0.0 },
            directional,
        };
        for (number, bound) in (0..).zip(&bounds[..voxels]) {
            let after = guess.cell(*bound) + 1;
            guess.bounds[after..].fill(number);
        }
        guess
    }

    /// The cell of a pair; the first one if the pair is 0 or NaN.
    #[inline(always)]
    pub(crate) fn cell(&self, pair: Vec2) -> usize {
        let cell = (measure(self.directional, pair) - self.start) * self.scale;
        (cell as u32).min(self.bounds.len() as u32 - 1) as usize
    }

    /// The last bound before a cell.
    #[inline(always)]
    pub(crate) fn bound(&self, cell: usize) -> usize {
        self.bounds[cell].into()
    }
}

#[inline(always)]
fn measure(directional: bool, Vec2 { x: w, y: q }: Vec2) -> f32 {
    let t = q / if directional { w } else { w.abs() + q };
    if w < 0.0 { 2.0 - t } else { t }
}

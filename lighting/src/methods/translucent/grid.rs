//! Density grids as a light sees them: one segment for each cell on the ray of each texel.
//!
//! Along a ray the extinction in a cell is constant or, between the samples of
//! a trilinear grid, a polynomial of degree 3, whose integral is exact.

use transmittance::BlockerSegment;

use super::view::{Texels, View};
use crate::scene::DensityGrid;

/// Calls `put` with what the grid takes from each texel, in one colour channel.
pub(super) fn segments(
    grid: &DensityGrid,
    view: &View,
    texels: Texels,
    channel: usize,
    put: &mut dyn FnMut([usize; 2], BlockerSegment),
) {
    let least = if view.is_parallel() {
        f64::NEG_INFINITY
    } else {
        0.0
    };
    let tint = f64::from(grid.tint()[channel]);
    texels.for_each(|x, y| {
        let (start, direction) = view.world_ray(x, y);
        for span in grid.occupied_cells_along(start, direction, least, f64::INFINITY) {
            let tau = tint * grid.optical_depth(&span);
            // This cannot fail: depths are finite and in order, and a sum of positive terms is
            // positive.
            if tau > 0.0
                && let Ok(segment) =
                    BlockerSegment::from_optical_depth(span.from as f32, span.to as f32, tau as f32)
            {
                put([x as usize, y as usize], segment);
            }
        }
    });
}

//! Density grids as a light sees them: a segment per cell on the ray of each
//! texel.
//!
//! Along a ray the extinction in a cell is constant or, between the samples of
//! a trilinear grid, a polynomial of degree 3, whose integral two Gauss nodes
//! give exactly.

use glam::DVec3;
use transmittance::BlockerSegment;

use super::view::{Texels, View};
use crate::scene::{DensityGrid, Interpolation};

/// Calls `put` with what the grid takes from each of the texels.
pub(super) fn segments(
    grid: &DensityGrid,
    view: &View,
    texels: Texels,
    put: &mut dyn FnMut([usize; 2], BlockerSegment),
) {
    let (min, max) = (
        grid.bounds().min().as_dvec3(),
        grid.bounds().max().as_dvec3(),
    );
    let cells = grid.cells();
    let per_metre = DVec3::from_array(cells.map(f64::from)) / (max - min);
    texels.for_each(|x, y| {
        let (start, direction) = view.world_ray(x, y);
        let walk = Walk {
            start: (start - min) * per_metre,
            direction: direction * per_metre,
            cells,
        };
        let least = if view.is_parallel() {
            f64::NEG_INFINITY
        } else {
            0.0
        };
        walk.run(least, |cell, from, to| {
            let tau = optical_depth(grid, &walk, cell, from, to);
            // Finite depths in order, and a sum of what is positive.
            if tau > 0.0
                && let Ok(segment) =
                    BlockerSegment::from_optical_depth(from as f32, to as f32, tau as f32)
            {
                put([x as usize, y as usize], segment);
            }
        });
    });
}

fn optical_depth(grid: &DensityGrid, walk: &Walk, cell: [u32; 3], from: f64, to: f64) -> f64 {
    // ±1/√3 of half the length around the middle.
    const NODE: f64 = 0.577_350_269_189_625_8;
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let at = |t: f64| {
        let place = walk.start + t * walk.direction - DVec3::from_array(cell.map(f64::from));
        grid.extinction(cell, place.clamp(DVec3::ZERO, DVec3::ONE))
    };
    match grid.interpolation() {
        Interpolation::Constant => 2.0 * half * at(middle),
        Interpolation::Linear => half * (at(middle - NODE * half) + at(middle + NODE * half)),
    }
}

/// A ray in units of cells; the position at depth `t` is
/// `start + t direction`.
struct Walk {
    start: DVec3,
    direction: DVec3,
    cells: [u32; 3],
}

impl Walk {
    /// Calls `visit(cell, from, to)` for each cell on the ray behind the depth
    /// `least`, from front to back.
    fn run(&self, least: f64, mut visit: impl FnMut([u32; 3], f64, f64)) {
        let (mut from, mut end) = (least, f64::INFINITY);
        for axis in 0..3 {
            let (start, step) = (self.start[axis], self.direction[axis]);
            let size = f64::from(self.cells[axis]);
            if step == 0.0 {
                if !(start >= 0.0 && start <= size) {
                    return;
                }
                continue;
            }
            let (a, b) = (-start / step, (size - start) / step);
            from = from.max(a.min(b));
            end = end.min(a.max(b));
        }
        if !(from < end) {
            return;
        }
        let mut cell = [0, 1, 2].map(|axis| {
            let position = self.start[axis] + from * self.direction[axis];
            (position.max(0.0) as u32).min(self.cells[axis] - 1)
        });
        // A cell is left through one of three faces, never to come back.
        loop {
            let leaving = [0, 1, 2].map(|axis| {
                let step = self.direction[axis];
                let border = f64::from(cell[axis]) + f64::from(u8::from(step > 0.0));
                if step == 0.0 {
                    f64::INFINITY
                } else {
                    (border - self.start[axis]) / step
                }
            });
            let axis = (0..3).fold(0, |a, b| if leaving[b] < leaving[a] { b } else { a });
            let to = leaving[axis].min(end);
            if to > from {
                visit(cell, from, to);
                from = to;
            }
            let next = if self.direction[axis] > 0.0 {
                (cell[axis] + 1 < self.cells[axis]).then_some(cell[axis] + 1)
            } else {
                cell[axis].checked_sub(1)
            };
            match next {
                Some(next) if leaving[axis] < end => cell[axis] = next,
                _ => return,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_walk_goes_through_the_box_without_gaps() {
        for (start, direction) in [
            (DVec3::new(-5.0, 0.3, 0.7), DVec3::new(1.0, 0.5, 0.25)),
            (DVec3::new(9.0, 9.0, 9.0), DVec3::new(-1.0, -1.0, -1.0)),
            (DVec3::new(1.0, 1.0, -2.0), DVec3::new(0.0, 0.0, 0.3)),
            (DVec3::new(0.5, 2.5, 4.5), DVec3::new(1e-9, -2.0, -1e-7)),
            (DVec3::new(4.0, 0.0, 3.0), DVec3::new(0.0, 1.0, -1.0)),
        ] {
            let walk = Walk {
                start,
                direction,
                cells: [4, 5, 6],
            };
            let mut parts = Vec::new();
            walk.run(f64::NEG_INFINITY, |cell, from, to| {
                parts.push((cell, from, to));
            });
            assert!(!parts.is_empty() && parts.len() <= 15, "{start}");
            for pair in parts.windows(2) {
                assert_eq!(pair[0].2, pair[1].1);
            }
            for (cell, from, to) in parts {
                let middle = start + 0.5 * (from + to) * direction;
                let place = middle - DVec3::from_array(cell.map(f64::from));
                assert!(place.cmpge(DVec3::splat(-1e-9)).all(), "{place}");
                assert!(place.cmple(DVec3::splat(1.0 + 1e-9)).all(), "{place}");
            }
        }
        let past = Walk {
            start: DVec3::new(-1.0, 0.0, 0.0),
            direction: DVec3::Y,
            cells: [1; 3],
        };
        past.run(0.0, |_, _, _| panic!("misses the box"));
    }
}

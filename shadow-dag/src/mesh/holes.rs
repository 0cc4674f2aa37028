//! Triangles that are not there everywhere.

use std::fmt::Debug;
use std::sync::Arc;

use glam::{DVec3, DVec4};
use gpu_backend::Cpu;

use super::ONE;

/// Where triangles have holes through which light passes.
pub trait Holes: Send + Sync + Debug {
    /// Whether a triangle has a hole at the barycentric coordinates (`u`, `v`) of
    /// its second and third corner. Asked about triangles that were named as
    /// [having holes](super::Surfaces::with_holes) alone, and always answered alike.
    fn is_hole(&self, triangle: u32, u: f64, v: f64) -> bool;

    /// Tells, word by word, what tells these holes from others: a bake that was
    /// stopped goes on with the same holes only.
    fn describe(&self, word: &mut dyn FnMut(u64));
}

/// The triangles of a mesh that have holes, as a light sees them.
#[derive(Debug, Clone)]
pub(crate) struct Masks {
    pub(super) holes: Arc<dyn Holes>,
    all: Vec<Mask>,
}

/// A triangle with holes.
#[derive(Debug, Clone, Copy)]
struct Mask {
    triangle: u32,
    /// By how much of each corner a point of the map is a mixture, but for a common
    /// factor: products with (x, y, 1).
    weights: [DVec3; 3],
}

impl Masks {
    /// Of triangles by their numbers; `corners` are homogeneous coordinates
    /// `(X, Y, depth, W)` over the map.
    pub(super) fn new(
        cpu: &Cpu,
        holes: Arc<dyn Holes>,
        triangles: &[u32],
        corners: impl Fn(u32) -> [DVec4; 3] + Sync + Send,
    ) -> Self {
        let all = cpu.map(triangles.len(), |number| {
            let triangle = triangles[number];
            // A ray meets the triangle in the mixture of the corners that it is
            // itself; the weights are determinants.
            let [a, b, c] = corners(triangle).map(|p| DVec3::new(p.x, p.y, p.w));
            Mask {
                triangle,
                weights: [b.cross(c), c.cross(a), a.cross(b)],
            }
        });
        Self { holes, all }
    }

    /// Whether the triangle of a number has a hole over a point of the grid.
    pub(super) fn is_hole(&self, number: u32, at: [i32; 2]) -> bool {
        let mask = &self.all[number as usize];
        let [x, y] = at.map(|at| f64::from(at) / f64::from(ONE));
        let [a, b, c] = mask.weights.map(|weight| weight.dot(DVec3::new(x, y, 1.0)));
        let sum = a + b + c;
        self.holes.is_hole(mask.triangle, b / sum, c / sum)
    }
}

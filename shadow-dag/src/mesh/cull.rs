//! Triangles that cannot change the grid of a light.
//!
//! What lies beside the map meets no texel. What lies behind the last slice has
//! no slice, but it may be the far side of a solid that begins in the grid. So a
//! solid is left out as a whole or not at all; open surfaces go one by one.
//! Leaving them out changes no bit of what is baked.

use glam::{DVec3, DVec4, Vec3};

use super::sorted::runs;
use crate::{LightSpace, Slices};
use gpu_backend::Cpu;

/// Triangles in a row that share a box.
pub(super) const GROUP: usize = 64;

/// Rounding of a product of a row of the matrix and a point, and of what clipping
/// makes of it, relative to the sizes of its terms.
const ROUNDING: f64 = 1e-12;

/// How much nearer than it is a surface may count as being that is tested against
/// the last slice, relative to its depth. More than depths are rounded by where
/// solids that touch are joined.
const TOUCH: f64 = 1e-6;

/// A box along the axes: its centre and half its size.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    centre: DVec3,
    half: DVec3,
}

impl Extent {
    /// Around points; around the origin without any.
    fn of(points: impl Iterator<Item = Vec3>) -> Self {
        let bounds = points.fold(None, |bounds: Option<[Vec3; 2]>, point| {
            let [low, high] = bounds.unwrap_or([point; 2]);
            Some([low.min(point), high.max(point)])
        });
        let [low, high] = bounds.unwrap_or_default().map(Vec3::as_dvec3);
        Self {
            centre: 0.5 * (low + high),
            half: 0.5 * (high - low),
        }
    }
}

/// Boxes around triangles, for any light.
#[derive(Debug, Clone)]
pub(super) struct Extents {
    /// Of each [`GROUP`] triangles.
    groups: Vec<Extent>,
    /// Of each solid.
    solids: Vec<Extent>,
    /// The number of the solid that a triangle belongs to, or [`OPEN`].
    solid_of: Vec<u32>,
}

/// Of a triangle that belongs to no solid.
const OPEN: u32 = u32::MAX;

impl Extents {
    /// Of triangles; `part` is any number for each that those of the same part
    /// share, below the number of positions.
    pub(super) fn new(
        cpu: &Cpu,
        positions: &[Vec3],
        indices: &[[u32; 3]],
        closed: &[bool],
        part: impl Fn(usize) -> usize,
    ) -> Self {
        let corners = |triangle: usize| indices[triangle].map(|corner| positions[corner as usize]);
        let mut numbers = vec![OPEN; positions.len()];
        let mut bounds: Vec<[Vec3; 2]> = Vec::new();
        let mut solid_of = vec![OPEN; indices.len()];
        for triangle in (0..indices.len()).filter(|&triangle| closed[triangle]) {
            let number = &mut numbers[part(triangle)];
            if *number == OPEN {
                *number = bounds.len() as u32;
                bounds.push([corners(triangle)[0]; 2]);
            }
            solid_of[triangle] = *number;
            let [low, high] = &mut bounds[*number as usize];
            for corner in corners(triangle) {
                (*low, *high) = (low.min(corner), high.max(corner));
            }
        }
        let groups = cpu.map(indices.len().div_ceil(GROUP), |group| {
            let triangles = group * GROUP..indices.len().min((group + 1) * GROUP);
            Extent::of(triangles.flat_map(corners))
        });
        Self {
            groups,
            solids: (bounds.into_iter())
                .map(|bounds| Extent::of(bounds.into_iter()))
                .collect(),
            solid_of,
        }
    }

    /// The numbers of the triangles that may change the grid of `light`, in order.
    pub(super) fn seen(
        &self,
        cpu: &Cpu,
        light: &LightSpace,
        corners: impl Fn(usize) -> [DVec4; 3] + Sync + Send,
    ) -> Vec<u32> {
        let view = View::new(light);
        let hidden: Vec<bool> = (self.solids.iter())
            .map(|solid| view.hides_solid(solid))
            .collect();
        let groups = self.groups.len();
        let found = cpu.map(groups, |group| !view.misses(&self.groups[group]));
        let groups: Vec<usize> = (0..groups).filter(|&group| found[group]).collect();
        let found = runs(cpu, groups.len() * GROUP, |run| {
            let numbers = run.map(|at| groups[at / GROUP] * GROUP + at % GROUP);
            let is_seen = |triangle: &usize| {
                let Some(&solid) = self.solid_of.get(*triangle) else {
                    return false;
                };
                let corners = corners(*triangle);
                !view.is_beside(&corners)
                    && !match solid {
                        OPEN => view.hides_surface(&corners),
                        solid => hidden[solid as usize],
                    }
            };
            numbers
                .filter(is_seen)
                .map(|triangle| triangle as u32)
                .collect::<Vec<_>>()
        });
        found.concat()
    }
}

/// What the grid of a light sees.
struct View {
    /// From the world to `(X, Y, depth, W)`, as [`LightSpace::homogeneous`].
    rows: [DVec4; 4],
    /// The ends of logarithmic slices.
    ends: Option<[f64; 2]>,
}

impl View {
    fn new(light: &LightSpace) -> Self {
        let mut rows = [0, 1, 2, 3].map(|row| light.matrix().row(row));
        let ends = match light.slices() {
            Slices::Linear => None,
            Slices::Logarithmic(ends) => {
                rows[2] = rows[3];
                Some([ends.near(), ends.far()])
            }
        };
        Self { rows, ends }
    }

    /// Bounds of a row over a box.
    fn range(row: DVec4, extent: &Extent) -> [f64; 2] {
        let (centre, half) = (extent.centre, extent.half);
        let axes = row.truncate();
        let middle = axes.dot(centre) + row.w;
        let size = axes.abs().dot(centre.abs() + half) + row.w.abs();
        let reach = axes.abs().dot(half) + ROUNDING * size;
        [middle - reach, middle + reach]
    }

    /// True if the map shows nothing of a box.
    fn misses(&self, extent: &Extent) -> bool {
        let [x, y, _, w] = self.rows;
        let is_out = |row: DVec4| Self::range(row, extent)[1] < 0.0;
        is_out(x)
            || is_out(y)
            || is_out(w - x)
            || is_out(w - y)
            || self
                .ends
                .is_some_and(|[near, _]| Self::range(w, extent)[1] < near)
    }

    /// True if the map shows nothing of a triangle with these corners.
    fn is_beside(&self, corners: &[DVec4; 3]) -> bool {
        let all = |is_out: &dyn Fn(&DVec4) -> bool| corners.iter().all(is_out);
        // Rounding counts as being there.
        let below = |value: f64, corner: &DVec4| {
            value < -ROUNDING * (corner.x.abs() + corner.y.abs() + corner.w.abs())
        };
        all(&|p| below(p.x, p))
            || all(&|p| below(p.y, p))
            || all(&|p| below(p.w - p.x, p))
            || all(&|p| below(p.w - p.y, p))
            || self
                .ends
                .is_some_and(|[near, _]| all(&|p| p.w < near * (1.0 - ROUNDING)))
    }

    /// True if an open surface lies behind the last slice.
    fn hides_surface(&self, corners: &[DVec4; 3]) -> bool {
        let end = self.ends.map_or(1.0, |[_, far]| far) * (1.0 + ROUNDING);
        corners.iter().all(|corner| corner.z >= end)
    }

    /// True if all of a solid lies behind the last slice, and so far behind it
    /// that none of its front faces counts as touching what ends in front: a face
    /// may count as being nearer by as much as its depths differ.
    fn hides_solid(&self, solid: &Extent) -> bool {
        let [least, most] = Self::range(self.rows[2], solid);
        match self.ends {
            None => least - (most - least) >= 1.0 + TOUCH * most.abs(),
            // Depths of triangles are −1/distance there.
            Some([_, far]) => {
                least >= far && 2.0 / least - 1.0 / most <= (1.0 - TOUCH) / far - TOUCH / least
            }
        }
    }
}

//! Hair, smoke and glass as a light sees them: how much of the light gets how far.
//!
//! A ray of a light meets strands, cells of a density grid, particles and triangles in any
//! order. [`FaceBlockers`] yields them as segments, texel by texel, and a [`TransmittanceMap`]
//! holds one curve of the crate `transmittance` for each texel. For a point it gives the share
//! of the light that arrives: in the air ([`visibility::March`](crate::visibility::March)), on
//! a surface, or inside the smoke and the hair themselves.
//!
//! | caster | a segment per | optical depth or transmittance | depths |
//! |---|---|---|---|
//! | [`Strands`](crate::scene::Strands) | piece and texel | `1 − coverage × opacity`, the coverage exact over the texel | of the piece within the texel |
//! | [`DensityGrid`](crate::scene::DensityGrid) | cell on the ray of the texel's centre | the exact integral over the cell | the ray's way in the cell |
//! | [`Particles`](crate::scene::Particles) | ball, or quarter of a soft one | the exact integral over the chord | of the chord |
//! | see-through triangles | texel | what passes where the ray of the texel's centre meets it, per colour | of that place |
//! | other triangles | texel | opaque | of the nearest one |
//!
//! Based on: M. Salvi, K. Vidimče, A. Lauritzen, A. Lefohn, "Adaptive Volumetric Shadow Maps",
//! Eurographics Symposium on Rendering 2010, section 3. Departures: the coverage of strands is
//! exact, where the paper uses that of a rasteriser; and density grids are traversed, where the
//! paper has particles only.
//!
//! Strands are averaged over a texel before anything else: behind two strands that cover half
//! of a texel each, a quarter of the light is left, whether or not they cover the same half.
//! Grids and particles are met on the ray of each texel's centre: where the shadow is smooth,
//! the error of a filtered map is of second order in the size of texels.
//!
//! A face of a light's picture that sees nothing has one texel. The methods give each face as many
//! as it needs ([`Casters::side`]): of smoke without edges no more than that has details. Where
//! shaders make a map, all faces have as many as the finest.
//!
//! On GPUs, maps of strands, density grids, particles and opaque triangles are made in shaders
//! (`TransmittanceMap::build_in_shaders`), by the paper's pipeline of fixed memory
//! (`transmittance::gpu::build_from_candidates`): casters are listed by square of texels, and
//! each texel makes the segments of what it meets, in the order of the CPU's, without one of
//! them in memory. The CPU makes the map where there are see-through triangles, pieces of strands
//! longer than 128 texels, whose coverage the precision of shaders does not resolve to 1e-3, or
//! grids of more than 2048 cells along an axis. The methods also leave it to the CPU on a software
//! driver, where the processor is faster at rasterising casters than at playing a GPU on which
//! every texel goes through the lists of its squares; the [watch](crate::Watch::told) is told so.
//!
//! A curve has one value for all colours. Where see-through triangles colour the light, red,
//! green and blue have curves of their own, at three times the memory and time. Stacked
//! surfaces take two nodes each; if they need more than the nodes of a curve, they are
//! approximated like everything else.

pub(crate) mod bins;
mod blockers;
#[cfg(feature = "wgpu")]
mod candidates;
#[cfg(all(test, feature = "procedural", feature = "wgpu"))]
mod candidates_tests;
#[cfg(feature = "wgpu")]
mod gpu;
mod grid;
#[cfg(all(test, feature = "procedural", feature = "wgpu"))]
mod grid_candidates_tests;
#[cfg(feature = "wgpu")]
mod grid_rays;
mod map;
#[cfg(feature = "methods")]
mod method;
#[cfg(all(feature = "methods", feature = "wgpu"))]
mod method_gpu;
#[cfg(all(test, feature = "trace"))]
mod pane_tests;
mod panes;
mod particles;
mod resolution;
pub(crate) mod strands;
#[cfg(test)]
mod tests;
pub(crate) mod view;

pub use blockers::FaceBlockers;
pub use map::{CurveMemory, MAX_RESOLUTION, TransmittanceMap, TransmittanceMapError};
#[cfg(feature = "methods")]
pub(super) use method::methods;
#[cfg(all(feature = "methods", feature = "wgpu"))]
pub(super) use method_gpu::made;

use glam::Vec3;

use crate::scene::{Bounds, Caster, Geometry, Translucent};

/// The casters that a light meets.
#[derive(Debug, Clone, Copy)]
pub struct Casters<'a> {
    translucent: &'a [Translucent],
    triangles: Triangles<'a>,
}

/// The triangles that cast shadows into a map.
#[derive(Debug, Clone, Copy)]
enum Triangles<'a> {
    None,
    SeeThrough(&'a Geometry),
    All(&'a Geometry),
}

impl<'a> Triangles<'a> {
    /// The geometry whose triangles let a share of the light through.
    fn panes(self) -> Option<&'a Geometry> {
        match self {
            Self::None => None,
            Self::SeeThrough(geometry) | Self::All(geometry) => Some(geometry),
        }
    }

    fn opaque(self) -> Option<&'a Geometry> {
        match self {
            Self::All(geometry) => Some(geometry),
            Self::None | Self::SeeThrough(_) => None,
        }
    }
}

impl<'a> Casters<'a> {
    /// Translucent casters, and the triangles of a geometry if these should cast shadows into
    /// the same map: see-through ones by their transmittance, masked ones outside of their
    /// holes.
    pub fn new(translucent: &'a [Translucent], geometry: Option<&'a Geometry>) -> Self {
        Self {
            translucent,
            triangles: geometry.map_or(Triangles::None, Triangles::All),
        }
    }

    /// Everything that lets a share of the light through: translucent casters and see-through
    /// triangles. Other triangles are left to a shadow map, which
    /// [`Both`](crate::visibility::Both) combines with a map of these.
    pub fn see_through(translucent: &'a [Translucent], geometry: &'a Geometry) -> Self {
        Self {
            translucent,
            triangles: Triangles::SeeThrough(geometry),
        }
    }

    /// Number of colour channels that differ: 3 if see-through triangles, or grids with a tint,
    /// colour the light that passes, else 1.
    pub fn channels(&self) -> usize {
        let panes = self.triangles.panes();
        let is_coloured = panes.is_some_and(|geometry| geometry.coatings().any_coloured());
        let is_tinted = |caster: &Translucent| match caster {
            Translucent::Grid(grid) => grid.tint() != Vec3::splat(grid.tint().x),
            Translucent::Strands(_) | Translucent::Particles(_) => false,
        };
        if is_coloured || self.translucent.iter().any(is_tinted) {
            3
        } else {
            1
        }
    }

    /// A box around all of them; `None` if there are none.
    pub fn bounds(&self) -> Option<Bounds> {
        let triangles = match self.triangles {
            Triangles::None => None,
            Triangles::All(geometry) => Some(geometry.bounds()),
            Triangles::SeeThrough(geometry) if !geometry.coatings().any_see_through() => None,
            Triangles::SeeThrough(geometry) => {
                let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
                for (index, corners) in geometry.triangles().iter().enumerate() {
                    if let Caster::SeeThrough(_) = geometry.caster(index) {
                        for corner in corners {
                            (min, max) = (min.min(*corner), max.max(*corner));
                        }
                    }
                }
                if !min.cmple(max).all() {
                    return self.translucent_bounds();
                }
                // A flat pane needs a box with a volume, inside the box of the whole geometry.
                let all = geometry.bounds();
                let margin = 1e-6 * (1.0 + min.abs().max(max.abs()).max_element());
                Bounds::new((min - margin).max(all.min()), (max + margin).min(all.max())).ok()
            }
        };
        let both = self.translucent_bounds().into_iter().chain(triangles);
        both.reduce(Bounds::around)
    }

    fn translucent_bounds(&self) -> Option<Bounds> {
        let boxes = self.translucent.iter().filter_map(Translucent::bounds);
        boxes.reduce(Bounds::around)
    }
}

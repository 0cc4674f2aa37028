//! Hair and smoke as a light sees them: how much of it gets how far.
//!
//! Each ray of a light meets strands, cells of a density grid, particles and
//! triangles in any order. [`FaceBlockers`] yields them as segments, texel by
//! texel, and a [`TransmittanceMap`] holds a curve of the crate `transmittance`
//! per texel. Asked at a point, it tells the share of the light that gets there:
//! in the air ([`visibility::March`](crate::visibility::March)),
//! on a surface, or inside of the smoke and the hair themselves.
//!
//! | caster | a segment per | optical depth or transmittance | depths |
//! |---|---|---|---|
//! | [`Strands`](crate::scene::Strands) | piece and texel | `1 − coverage × opacity`, the coverage exact over the texel | of the piece within the texel |
//! | [`DensityGrid`](crate::scene::DensityGrid) | cell on the ray of the texel's centre | the exact integral over the cell | the ray's way in the cell |
//! | [`Particles`](crate::scene::Particles) | ball, or quarter of a soft one | the exact integral over the chord | of the chord |
//! | triangles | texel | opaque | of the nearest one |
//!
//! Based on: M. Salvi, K. Vidimče, A. Lauritzen, A. Lefohn, "Adaptive Volumetric
//! Shadow Maps", Eurographics Symposium on Rendering 2010, section 3. Departures:
//! coverage of strands is exact where the paper has a rasteriser's, and density
//! grids are walked where the paper has particles only.
//!
//! Strands are averaged over texels before anything else: behind two strands
//! that cover half of a texel each, a quarter of the light is left, whether they
//! cover the same half or not. Grids and particles are met on the ray of each
//! texel's centre: the error of a filtered map falls with the square of the
//! texel's size where the shadow is smooth.

mod bins;
mod blockers;
#[cfg(feature = "wgpu")]
mod gpu;
mod grid;
mod map;
#[cfg(feature = "methods")]
mod method;
#[cfg(all(feature = "methods", feature = "wgpu"))]
mod method_gpu;
mod particles;
mod strands;
#[cfg(test)]
mod tests;
mod view;

pub use blockers::FaceBlockers;
pub use map::{CurveMemory, MAX_RESOLUTION, TransmittanceMap, TransmittanceMapError};
#[cfg(feature = "methods")]
pub use method::curve_resolution;
#[cfg(feature = "methods")]
pub(super) use method::methods;

use crate::scene::{Bounds, Geometry, Translucent};

/// What a light meets.
#[derive(Debug, Clone, Copy)]
pub struct Casters<'a> {
    translucent: &'a [Translucent],
    geometry: Option<&'a Geometry>,
}

impl<'a> Casters<'a> {
    /// Translucent casters, and opaque triangles if there are any that should
    /// cast shadows into the same map.
    pub fn new(translucent: &'a [Translucent], geometry: Option<&'a Geometry>) -> Self {
        Self {
            translucent,
            geometry,
        }
    }

    /// A box around all of them, `None` if there is nothing.
    pub fn bounds(&self) -> Option<Bounds> {
        let opaque = self.geometry.map(Geometry::bounds);
        let translucent = self.translucent.iter().filter_map(Translucent::bounds);
        translucent.chain(opaque).reduce(Bounds::around)
    }
}

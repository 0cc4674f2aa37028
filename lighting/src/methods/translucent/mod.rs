//! Hair, smoke and glass as a light sees them: how much of it gets how far.
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
//! | see-through triangles | texel | what passes where the ray of the texel's centre meets it, per colour | of that place |
//! | other triangles | texel | opaque | of the nearest one |
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
//!
//! A curve knows one number for all colours. Where see-through triangles colour the
//! light, each of red, green and blue has curves of its own: three times the memory
//! and the time. Stacked surfaces take two nodes each: more of them than half the
//! nodes of a curve are approximated, as all else is.

pub(crate) mod bins;
mod blockers;
#[cfg(feature = "wgpu")]
mod gpu;
mod grid;
mod map;
#[cfg(feature = "methods")]
mod method;
#[cfg(all(feature = "methods", feature = "wgpu"))]
mod method_gpu;
#[cfg(all(test, feature = "trace"))]
mod pane_tests;
mod panes;
mod particles;
pub(crate) mod strands;
#[cfg(test)]
mod tests;
pub(crate) mod view;

pub use blockers::FaceBlockers;
pub use map::{CurveMemory, MAX_RESOLUTION, TransmittanceMap, TransmittanceMapError};
#[cfg(feature = "methods")]
pub use method::curve_resolution;
#[cfg(feature = "methods")]
pub(super) use method::methods;

use glam::Vec3;

use crate::scene::{Bounds, Caster, Geometry, Translucent};

/// What a light meets.
#[derive(Debug, Clone, Copy)]
pub struct Casters<'a> {
    translucent: &'a [Translucent],
    triangles: Triangles<'a>,
}

/// Which triangles cast a shadow into a map.
#[derive(Debug, Clone, Copy)]
enum Triangles<'a> {
    None,
    SeeThrough(&'a Geometry),
    All(&'a Geometry),
}

impl<'a> Triangles<'a> {
    /// Those that let a share of the light through.
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
    /// Translucent casters, and triangles if there are any that should cast shadows
    /// into the same map: see-through ones as they are, masked ones where they
    /// are there.
    pub fn new(translucent: &'a [Translucent], geometry: Option<&'a Geometry>) -> Self {
        Self {
            translucent,
            triangles: geometry.map_or(Triangles::None, Triangles::All),
        }
    }

    /// All that lets a share of the light through: translucent casters and
    /// see-through triangles. What is behind the others is left to a shadow map,
    /// which [`Both`](crate::visibility::Both) puts together with a map of these.
    pub fn see_through(translucent: &'a [Translucent], geometry: &'a Geometry) -> Self {
        Self {
            translucent,
            triangles: Triangles::SeeThrough(geometry),
        }
    }

    /// Colour channels that differ: 3 if see-through triangles or grids with a tint
    /// colour the light that goes through them, else 1.
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

    /// A box around all of them, `None` if there is nothing.
    pub fn bounds(&self) -> Option<Bounds> {
        let triangles = match self.triangles {
            Triangles::None => None,
            Triangles::All(geometry) => Some(geometry.bounds()),
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
                // A flat pane still gets a box with a volume, within that of all.
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

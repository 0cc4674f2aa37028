//! Light that fog scatters onto surfaces.
//!
//! Based on: Sun, Ramamoorthi, Narasimhan and Nayar, A practical analytic single scattering
//! model for real time rendering, SIGGRAPH 2005. A surface in fog is lit by a lamp, and by the
//! glow around the lamp, which is light that the fog has scattered once. The irradiance of that
//! glow is
//!
//! ```text
//! E(x, n) = ∫_{n·ω > 0} (n·ω) L_a(x, ω) dω
//! ```
//!
//! where `L_a(x, ω)` is the airlight of the ray that leaves the surface along ω. The surface
//! reflects `albedo/π · E`. [`AddSurfaceScattering`] adds this for the surfaces of a picture,
//! light by light, in one of two ways:
//!
//! * [`ClosedForm`], where there is one: two lookups of the paper's `G_0` for point lights that
//!   shine alike in all directions, or one lookup for a sun.
//! * [`Quadrature`] for everything else: spotlights and their cookies, the points of area
//!   lights, ranges, fog in a box, any phase function, and shadows in the fog from any [source
//!   of visibility at points](crate::visibility::PointVisibility).
//!
//! [`ClosedForm::covers`] tells which of the two a light needs. A step that is given a light
//! that the closed form does not cover returns an error that says why.
//!
//! Departures from the paper: surfaces are Lambertian, because the materials of scenes are (the
//! lobes of glossy surfaces are in [`airlight::surface`]); spotlights, boxes, suns and shadows
//! are new.
//!
//! # Limits
//!
//! Blockers between the scattering fog and the surface cast no shadow: the shadows of
//! [`Quadrature`] are those between the light and the fog. In a room that light enters through
//! a window, only the shadows of the furniture are missing.
//!
//! ```
//! use glam::Vec3;
//! use gpu_backend::{Backend, Cpu, Download};
//! use lighting::scene::{Emission, Medium, PhaseFunction};
//! use lighting::surface_scattering::{AddSurfaceScattering, ClosedForm, LitSurfaces};
//! use lighting::{Emitter, SurfacePoint};
//!
//! let cpu = Cpu::new();
//! let fog = Medium::new(Vec3::splat(0.1), Vec3::splat(0.01), PhaseFunction::Isotropic)?;
//! let lamp = Emitter::point(Vec3::Y, Vec3::splat(50.0), f32::INFINITY, Emission::Isotropic)?;
//! let floor = SurfacePoint::new(Vec3::X, Vec3::Y, Vec3::splat(0.2)).expect("a sound point");
//!
//! let closed_form = ClosedForm::new(&fog);
//! assert!(closed_form.covers(&lamp, &fog).is_ok());
//! let points = cpu.upload(&[floor])?;
//! let mut radiance = cpu.zeros::<[f32; 4]>(1)?;
//! let lit = LitSurfaces { points: &points, emitter: &lamp, medium: &fog };
//! cpu.add_surface_scattering(&lit, &closed_form, &mut radiance)?;
//! assert!(cpu.download(&radiance)?[0][0] > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod closed_form;
#[cfg(feature = "wgpu")]
mod gpu;
mod quadrature;
#[cfg(test)]
mod tests;

pub use closed_form::ClosedForm;
#[cfg(feature = "wgpu")]
pub use gpu::SurfaceScatteringSlot;
pub use quadrature::Quadrature;

use glam::Vec3;
use gpu_backend::{Backend, Cpu, Error, Memory};

use crate::gather::check_lengths;
use crate::scene::Medium;
use crate::{Emitter, SurfacePoint};

/// Surfaces, a light, and the fog that scatters it.
#[derive(Debug)]
pub struct LitSurfaces<'a, M: Memory> {
    /// One point per pixel, in the memory of the backend.
    pub points: &'a M::Buffer<SurfacePoint>,
    /// The light.
    pub emitter: &'a Emitter,
    /// The medium that scatters the light.
    pub medium: &'a Medium,
}

/// Why a way of computing scattered light does not cover a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NotCovered {
    /// The fog ends at a box.
    #[error("the fog is in a box, and the closed form is that of fog without bounds")]
    Bounds,
    /// The light is a point light, and the fog does not scatter isotropically.
    #[error(
        "the closed form of a point light is that of fog that scatters evenly in all directions"
    )]
    Phase,
    /// The table for suns was made for another phase function.
    #[error("the closed form was made for another phase function than that of the fog")]
    OtherPhase,
    /// The light does not shine alike in all directions.
    #[error("the closed form is that of a light that shines evenly in all directions")]
    Emission,
    /// The light has a range.
    #[error("the closed form is that of a light of unlimited range")]
    Range,
}

/// Computes how much light fog scatters onto a surface, on the CPU.
pub trait SurfaceEvaluator: Covers + Sync {
    /// Irradiance of a surface at `position` with the unit `normal`, from light that the medium
    /// scattered once. The light must be covered. The result is finite and at least 0.
    fn irradiance(&self, position: Vec3, normal: Vec3, emitter: &Emitter, medium: &Medium) -> Vec3;
}

/// Tells which lights it can compute.
pub trait Covers {
    /// Whether it can compute the light of `emitter` that `medium` scatters onto surfaces.
    ///
    /// # Errors
    /// The reason why it cannot.
    fn covers(&self, emitter: &Emitter, medium: &Medium) -> Result<(), NotCovered>;
}

/// The step that adds the light that fog scatters onto surfaces.
///
/// It is implemented on the CPU for every [`SurfaceEvaluator`], and on GPUs for every evaluator
/// that brings a shader part.
pub trait AddSurfaceScattering<S>: Backend {
    /// Adds `response · E` of every point to the first three components of `radiance`, where
    /// `E` is the irradiance from light that was scattered once. A medium that scatters nothing
    /// adds nothing.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if points and radiance differ in length, and
    /// [`Error::Rejected`] if `scattering` does not [cover](Covers) the light; nothing is
    /// written then.
    fn add_surface_scattering(
        &self,
        lit: &LitSurfaces<'_, Self::Memory>,
        scattering: &S,
        radiance: &mut <Self::Memory as Memory>::Buffer<[f32; 4]>,
    ) -> Result<(), Error>;
}

/// Points in a unit of work; a quadrature takes up to some hundred microseconds for each.
const CHUNK: usize = 256;

impl<S: SurfaceEvaluator> AddSurfaceScattering<S> for Cpu {
    fn add_surface_scattering(
        &self,
        lit: &LitSurfaces<'_, Self::Memory>,
        scattering: &S,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(lit.points.len(), radiance.len())?;
        check_covered(scattering, lit.emitter, lit.medium)?;
        if lit.medium.scatters_nothing() {
            return Ok(());
        }
        self.for_each_chunk(radiance, CHUNK, |first, chunk: &mut [[f32; 4]]| {
            for (sum, point) in chunk.iter_mut().zip(&lit.points[first..]) {
                if !point.reflects() {
                    continue;
                }
                let (position, normal) = (point.position(), point.normal());
                let irradiance = scattering.irradiance(position, normal, lit.emitter, lit.medium);
                let added = point.response() * irradiance;
                for (sum, added) in sum.iter_mut().zip(added.to_array()) {
                    *sum += added;
                }
            }
        });
        Ok(())
    }
}

/// Refuses lights that are not covered.
fn check_covered(by: &impl Covers, emitter: &Emitter, medium: &Medium) -> Result<(), Error> {
    by.covers(emitter, medium)
        .map_err(|reason| Error::Rejected {
            what: "light that reaches surfaces by way of the fog".into(),
            reason: reason.to_string(),
        })
}

//! Light that reaches surfaces by way of the fog.
//!
//! Based on: Sun, Ramamoorthi, Narasimhan and Nayar, A practical analytic single
//! scattering model for real time rendering, SIGGRAPH 2005. A surface in fog is lit
//! by a lamp, and by the glow around the lamp: light that was scattered once on its
//! way. The irradiance of that glow is
//!
//! ```text
//! E(x, n) = ∫_{n·ω > 0} (n·ω) L_a(x, ω) dω
//! ```
//!
//! with `L_a(x, ω)` the airlight of the ray that leaves the surface along ω, and
//! `albedo/π · E` is reflected. [`AddSurfaceScattering`] adds it for the surfaces of
//! a picture, light by light, in one of two ways:
//!
//! * [`ClosedForm`] where there is one: two lookups of the paper's `G_0`, for points
//!   that shine evenly, or one lookup for a sun.
//! * [`Quadrature`] for everything else: spotlights and their cookies, the points of
//!   area lights, ranges, fog in a box, any phase function, and shadows in the fog,
//!   from whatever answers [questions at points](crate::visibility::PointVisibility).
//!
//! [`ClosedForm::covers`] tells which of the two a light needs; a step that is given
//! a light that the closed form does not cover fails and says why.
//!
//! Departures from the paper: surfaces are Lambertian, since the materials of scenes
//! are (the lobes of glossy surfaces are in [`airlight::surface`]); spotlights, boxes,
//! suns and shadows are new.
//!
//! # Limits
//!
//! What stands between the scattering fog and the surface casts no shadow there: the
//! shadows of [`Quadrature`] are those between the light and the fog. A room that
//! light enters through a window gets it right but for its own furniture.
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

/// Surfaces, a light and the fog between them.
#[derive(Debug)]
pub struct LitSurfaces<'a, M: Memory> {
    /// One point per pixel, in the memory of the backend.
    pub points: &'a M::Buffer<SurfacePoint>,
    /// The light.
    pub emitter: &'a Emitter,
    /// What scatters it.
    pub medium: &'a Medium,
}

/// Why a light is not covered by a way to compute its scattered light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NotCovered {
    /// The fog ends at a box.
    #[error("the fog is in a box, and the closed form is that of fog without bounds")]
    Bounds,
    /// A point light in fog that does not scatter evenly.
    #[error(
        "the closed form of a point light is that of fog that scatters evenly in all directions"
    )]
    Phase,
    /// The sun's table is that of another phase function.
    #[error("the closed form was made for another phase function than that of the fog")]
    OtherPhase,
    /// A light that shines into a part of space only.
    #[error("the closed form is that of a light that shines evenly in all directions")]
    Emission,
    /// A light that ends somewhere.
    #[error("the closed form is that of a light of unlimited range")]
    Range,
}

/// What knows how much light fog sends to a surface, on the CPU.
pub trait SurfaceEvaluator: Covers + Sync {
    /// Irradiance, by light that the medium scattered once, on a surface at `position`
    /// with the unit `normal`. The light is covered. Finite and at least 0.
    fn irradiance(&self, position: Vec3, normal: Vec3, emitter: &Emitter, medium: &Medium) -> Vec3;
}

/// What knows which lights it can do.
pub trait Covers {
    /// Whether the light that `emitter` sends to surfaces by way of `medium` can be
    /// computed.
    ///
    /// # Errors
    /// What is in the way.
    fn covers(&self, emitter: &Emitter, medium: &Medium) -> Result<(), NotCovered>;
}

/// The step that adds the light that surfaces receive by way of the fog.
///
/// Implemented for the CPU for every [`SurfaceEvaluator`], and for GPUs for every
/// evaluator that brings a shader part.
pub trait AddSurfaceScattering<S>: Backend {
    /// Adds `response · E` of every point to `radiance`, where `E` is the irradiance
    /// by light that was scattered once. The fourth component is left alone. A medium
    /// that scatters nothing adds nothing.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if points and radiance differ in length, and
    /// [`Error::Rejected`] if `scattering` does not [cover](Covers) the light; nothing
    /// is written then.
    fn add_surface_scattering(
        &self,
        lit: &LitSurfaces<'_, Self::Memory>,
        scattering: &S,
        radiance: &mut <Self::Memory as Memory>::Buffer<[f32; 4]>,
    ) -> Result<(), Error>;
}

/// Points per unit of work: a quadrature takes up to some hundred microseconds each.
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

/// What steps do with lights that are not covered.
fn check_covered(by: &impl Covers, emitter: &Emitter, medium: &Medium) -> Result<(), Error> {
    by.covers(emitter, medium)
        .map_err(|reason| Error::Rejected {
            what: "light that reaches surfaces by way of the fog".into(),
            reason: reason.to_string(),
        })
}

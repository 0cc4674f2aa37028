//! The light that fog scatters towards the eye, along a ray, from one light.
//!
//! The package is `crepuscular-airlight` and the library `airlight`: `Cargo.toml` has the first
//! name, and `use` the second.
//!
//! For a point light of radiant intensity `I` in a homogeneous medium the
//! airlight of a part of an eye ray is
//!
//! ```text
//! L = σ_s I A,     A = ∫ p(cos θ) exp(−σ_t (x + d)) / d² dx
//! ```
//!
//! with `x` the distance from the eye and `d` from the light; a [`Segment`]
//! says which part. Every evaluator here computes `A`, per colour channel, and
//! is right everywhere its page says: towards the light, past it and away from
//! it, exactly and nearly, in vacuum and through an optical depth of 80, for
//! parts of a billionth of the ray and for endless ones.
//!
//! ```
//! use airlight::{Evaluator, PhaseFunction, Segment, Table};
//!
//! // Isotropic fog of extinction 0.2 per metre. A lamp of 50 cd stands 4 m
//! // ahead, 1 m beside the ray, which ends after 10 m.
//! let table = Table::new(&PhaseFunction::Isotropic, 64)?;
//! let segment = Segment { x: 0.0, s: -4.0, h: 1.0, length: 10.0 };
//! let (sigma_s, intensity) = (0.18, 50.0);
//! let radiance = sigma_s * intensity * table.airlight(0.2, &segment);
//! assert!(radiance > 0.0 && table.error_bound() < 1e-4);
//! # Ok::<(), airlight::Error>(())
//! ```
//!
//! # Which evaluator
//!
//! | evaluator | relative error | for |
//! |---|---|---|
//! | [`Exact`] | 1e-12 (`f64`) | truth; any phase function |
//! | [`Table`] | 1e-4 in 64 KiB, stated by each table | batches; any phase function, fixed when the table is made |
//! | [`Quadrature`] | any tolerance from 0.1 to 1e-6 | no table; lights with a pattern ([`Quadrature::airlight_of`]); integrands of one's own |
//! | [`SunTable`] | none that is bounded; 1e-5 on ordinary rays | comparison with what was published |
//! | [`FrameTable`] | 5e-3 with 128 rows, for what it knows (1e-2 for the sharpest phase functions) | rays from one eye, one light and one medium, for which it is made anew |
//!
//! # Modules
//!
//! | item | what |
//! |---|---|
//! | [`PhaseFunction`], [`Phase`] | isotropic, Henyey-Greenstein with one or two lobes, Rayleigh, Schlick, Cornette-Shanks, droplets of fog, one's own |
//! | [`Emission`] | spotlights, surfaces that emit, lights of limited range |
//! | [`directional`] | sunlight in closed form; daylight after Hoffman and Preetham |
//! | [`surface`] | light that reaches a surface by way of the fog |
//! | [`point_spread`] | environments seen through fog |
//! | [`EvaluateAirlight`] | batches on a backend |
//! | `gpu` (feature `wgsl`) | parts for shaders, without any way of running them |
//!
//! The feature `wgpu` runs batches on GPUs and includes `wgsl`. What the API takes
//! of the crate `gpu-backend` is found in [`gpu_backend`].
//!
//! # Limits
//!
//! Light is scattered once, in a homogeneous medium that holds the light, the
//! eye and the segment; for a bounded one `x` counts the way inside of it. The
//! light is a point. Whether anything is in the way is not asked here: split the
//! ray into the parts that see the light.
//!
//! Based on: Sun, Ramamoorthi, Narasimhan and Nayar, A Practical Analytic Single
//! Scattering Model for Real Time Rendering, SIGGRAPH 2005; Wyman and Ramsey,
//! Interactive Volumetric Shadows in Participating Media with Single-Scattering,
//! Interactive Ray Tracing 2008.

mod angle;
pub mod directional;
mod emission;
mod error;
pub mod exact;
mod frame_table;
pub mod gauss;
#[cfg(feature = "wgsl")]
pub mod gpu;
mod phase;
pub mod point_spread;
pub mod quadrature;
mod real;
mod scaled;
mod segment;
mod segment64;
mod side;
mod simd;
mod spline;
mod step;
#[cfg(test)]
mod stiff;
mod sun_table;
pub mod surface;
mod table;
mod within;

pub use angle::ScatteringAngle;
pub use emission::Emission;
pub use error::Error;
pub use exact::Exact;
pub use frame_table::{FramePoint, FrameRay, FrameTable, Framed};
pub use gpu_backend;
pub use phase::{Phase, PhaseFunction};
pub use quadrature::Quadrature;
pub use real::Real;
pub use segment::Segment;
pub use segment64::Segment64;
pub use step::EvaluateAirlight;
pub use sun_table::SunTable;
pub use table::Table;

/// Computes the airlight of segments.
pub trait Evaluator: Sync {
    /// `A` in 1/(m sr): the airlight per unit of `σ_s I` for extinction
    /// `sigma_t`, 1/m. Never NaN; 0 where the result is below the range of
    /// f32, +∞ for a segment that contains the light.
    fn airlight(&self, sigma_t: f32, segment: &Segment) -> f32;

    /// [`Evaluator::airlight`] of each segment of a batch, with the same error bound.
    /// Within that bound a value may depend on the other segments of the slice, as those
    /// of a [`Quadrature`] do, unless the evaluator
    /// [has independent batches](Evaluator::has_independent_batches).
    ///
    /// # Panics
    /// If the slices differ in length.
    fn airlight_batch(&self, sigma_t: f32, segments: &[Segment], airlight: &mut [f32]) {
        assert_eq!(segments.len(), airlight.len(), "one result per segment");
        for (segment, value) in segments.iter().zip(airlight) {
            *value = self.airlight(sigma_t, segment);
        }
    }

    /// Whether [`Evaluator::airlight_batch`] gives each segment the bits of
    /// [`Evaluator::airlight`], whatever the others are. Callers that need these bits
    /// take segments one by one otherwise.
    fn has_independent_batches(&self) -> bool {
        false
    }
}

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

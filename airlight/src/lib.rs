//! The light that fog scatters towards the eye, along a ray, from one light.
//!
//! For a point light of radiant intensity `I` in a homogeneous medium the
//! airlight of a part of an eye ray is
//!
//! ```text
//! L = σ_s I A,     A = ∫ p(cos θ) exp(−σ_t (x + d)) / d² dx
//! ```
//!
//! with `x` the distance from the eye and `d` from the light; a [`Segment`]
//! says which part. Every evaluator here computes `A`, per colour channel.

mod angle;
pub mod directional;
mod emission;
mod error;
pub mod exact;
mod frame_table;
pub mod gauss;
#[cfg(feature = "wgpu")]
pub mod gpu;
mod phase;
pub mod point_spread;
pub mod quadrature;
mod real;
mod segment;
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
pub use exact::{Exact, Segment64};
pub use frame_table::FrameTable;
pub use phase::{Phase, PhaseFunction};
pub use quadrature::Quadrature;
pub use real::Real;
pub use segment::Segment;
pub use step::EvaluateAirlight;
pub use sun_table::SunTable;
pub use table::Table;

/// Computes the airlight of segments.
pub trait Evaluator: Sync {
    /// `A` in 1/(m sr): the airlight per unit of `σ_s I` for extinction
    /// `sigma_t`, 1/m. Never NaN; 0 where the result is below the range of
    /// f32, +∞ for a segment that contains the light.
    fn airlight(&self, sigma_t: f32, segment: &Segment) -> f32;

    /// [`Evaluator::airlight`] of each segment of a batch.
    ///
    /// # Panics
    /// If the slices differ in length.
    fn airlight_batch(&self, sigma_t: f32, segments: &[Segment], airlight: &mut [f32]) {
        assert_eq!(segments.len(), airlight.len(), "one result per segment");
        for (segment, value) in segments.iter().zip(airlight) {
            *value = self.airlight(sigma_t, segment);
        }
    }
}

//! How fog spreads the light of distant lamps and environments.
//!
//! Based on: Sun, Ramamoorthi, Narasimhan and Nayar, A practical analytic
//! single scattering model for real time rendering, SIGGRAPH 2005. Around a
//! lamp at the optical distance `T` an endless ray at the angle γ to it shows
//! the airlight `(σ_s σ_t I / T) e^{−T} N(γ)`, with the point-spread function
//!
//! ```text
//! N(γ) = [F(T sin γ, π/2) − F(T sin γ, γ/2)] / (2π sin γ e^{(cos γ − 1) T})
//! ```
//!
//! in 1/sr. An environment of radiance `L` at that distance is therefore
//! seen as `e^{−T} (L + σ_s/σ_t T ∫ N L dω)` ([`through_fog`]). Departures from the
//! paper: N is computed without its two large factors ([`exact`]); it has a
//! table per T that is exact to 3e-5 up to the lamp ([`Table`]); and
//! environments are convolved over the sphere, with the mean of N over each
//! texel, since N is infinite at γ = 0.
//!
//! The medium is homogeneous and scatters evenly in all directions, once.
//!
//! ```
//! use airlight::point_spread::{Fog, through_fog};
//! use gpu_backend::Cpu;
//!
//! let mut sky = vec![[0.1, 0.2, 0.3]; 64 * 32];
//! sky[10 * 64 + 20] = [500.0; 3];
//! let fog = Fog::new([0.8; 3], [0.9; 3])?;
//! let seen = through_fog(&Cpu::new(), &fog, &sky, 64, 32)?;
//! assert!(seen[10 * 64 + 23][0] > 0.1, "a halo around the lamp");
//! # Ok::<(), airlight::Error>(())
//! ```

mod environment;
pub mod exact;
mod fourier;
mod table;
mod weights;

pub use environment::{Fog, spread, through_fog};
pub use table::Table;

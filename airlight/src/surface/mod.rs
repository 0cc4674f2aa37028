//! The light that fog sends to a surface, besides what the lamp sends.
//!
//! Based on: Sun, Ramamoorthi, Narasimhan and Nayar, A practical analytic
//! single scattering model for real time rendering, SIGGRAPH 2005. A surface
//! at the distance `D` from a lamp of radiant intensity `I`, at the optical
//! distance `T = σ_t D`, reflects
//!
//! ```text
//! L_a = σ_s σ_t I / (2π T) · [k_d G_0(T, θ_s) + k_s G_n(T, θ'_s)]
//! ```
//!
//! of the light that was scattered once on its way, where `G_n` gathers the
//! airlight of all directions, each weighted by a cosine lobe; θ is the angle
//! between the lobe and the lamp. Departures from the paper:
//!
//! * `G_0` and `G_n` are one function, since a Lambertian surface is a lobe of
//!   exponent 1 about the normal: `G_0 = G_1`. The lobe of a glossy surface is
//!   not clipped by the surface, as in the paper.
//! * The exponent is continuous, one table holds all of them ([`GlossTable`]).
//! * Tables are cubic splines of the logarithm of `e^T G_n`, so that a small
//!   table gives a small relative error.
//!
//! The medium scatters evenly in all directions (isotropic phase function), is
//! homogeneous and without bounds; the lamp is a point that shines evenly;
//! nothing casts shadows. [`exact`] has the same functions in f64.
//!
//! ```
//! use airlight::surface::{Material, Receiver, Table};
//!
//! let table = Table::new();
//! let paint = Material::new(0.2, 0.1, 40.0)?;
//! let receiver = Receiver { distance: 10.0, cos_normal: 0.5, cos_mirror: 0.8 };
//! // σ_s and σ_t of one colour channel, 1/m.
//! let light = table.radiance(0.04, 0.05, &receiver, &paint);
//! assert!(light.direct > light.scattered && light.scattered > 0.0);
//! # Ok::<(), airlight::Error>(())
//! ```

pub mod exact;
mod grid;
mod radiance;
mod ring;
mod table;

pub use radiance::{Material, Radiance, Receiver, Table};
pub use table::{GlossTable, LobeTable};

use crate::Error;

/// The exponent, if a lobe may have it.
fn checked_exponent(exponent: f64) -> Result<f64, Error> {
    if (1.0..=200.0).contains(&exponent) {
        Ok(exponent)
    } else {
        Err(Error::bad_value(
            "the exponent of a cosine lobe",
            exponent,
            "1 to 200",
        ))
    }
}

//! Froxels: the view frustum is divided into cells, which are lit one by one and summed from
//! front to back, as in game engines.
//!
//! Based on: Wronski, Volumetric Fog: Unified Compute Shader Based Solution to
//! Atmospheric Scattering, SIGGRAPH 2014 course; Hillaire, Physically Based and Unified
//! Volumetric Rendering in Frostbite, SIGGRAPH 2015 course.
//!
//! The picture is divided into tiles and each tile into slices of depth
//! ([`FroxelGrid`]). Three passes make the light of a frame:
//!
//! 1. *Inject* ([`InjectFroxels`]): for each light and froxel, one sample of the light that is
//!    scattered to the eye, with one lookup of its shadow. At the point `x` of a ray, at the
//!    distance d from the light,
//!
//!    ```text
//!    s(x) = Σ_lights σ_s p(cos θ) V(x) I(ω) T_light / d²        1/m of radiance
//!    T_light = e^{−σ_t d}, the light's own extinction, or 1
//!    ```
//!
//!    (with E in place of I/d² for a sun, whose extinction counts in a bounded medium only).
//! 2. *Integrate* ([`FroxelSteps::integrate`]): along each column, front to back. s counts as
//!    constant in a slice of length Δ, and the integral over the slice is exact then
//!    (Hillaire), so that a thick slice scatters no more than it can:
//!
//!    ```text
//!    L_{k+1} = L_k + e^{−σ_t (x_k − x_0)} s_k (1 − e^{−σ_t Δ_k}) / σ_t
//!    ```
//!
//!    where x_0 is where the column enters the medium.
//! 3. *Look up* ([`FroxelSteps::look_up`]): L at the end of each ray, trilinear.
//!
//! Without shadows the error is of second order in the length of the slices and in the width of
//! the tiles; with shadows it is of first order. Cost: froxels × lights, whatever the number of
//! pixels.
//!
//! A [`FroxelHistory`] samples each frame at another place of its froxels and blends it with
//! the frames before ([`FroxelSteps::blend`]) by the position in the world, so the camera may
//! move. The method in the list keeps it over the frames of a
//! [film](crate::methods::share_film_frame); otherwise it shows the last of sixteen frames of a
//! still camera.
//!
//! # Departures
//!
//! * Slices are distances along rays, and end where the longest ray does. Engines use distances
//!   to the plane of the camera, and a far end that is chosen by hand. Rays to the sky end
//!   after ten mean free paths.
//! * Lights have no radius that bounds the inverse square. Instead it is limited to 8 / (w Δ)
//!   for a froxel of width w and length Δ. This is close to its mean over a froxel around the
//!   light, 7.8 / w² in a cube and 11 / (w Δ) in a long one, where a single sample could have
//!   any value.
//! * Engines leave out the extinction between light and froxel (with it, the light of a lamp in
//!   fog falls off as e^{−σ_t d} / d²). Both are available, see [`FroxelLight::extinction`].
//! * A froxel on the border of a bounded medium counts with the part inside.
//! * The first frames of a history are blended to their mean, instead of with the weight of
//!   later frames.
//! * The method in the list treats an area light as one point at its centre with all of its
//!   power and one shadow map, as engines do. [`InjectFroxels`] takes any lights.
//!
//! # Limits
//!
//! There are at most 1024 slices and 2²³ froxels. Hair, smoke and see-through surfaces are
//! ignored.

#[cfg(feature = "methods")]
#[cfg(test)]
mod film_tests;
#[cfg(feature = "wgpu")]
mod gpu;
#[cfg(feature = "wgpu")]
#[cfg(test)]
mod gpu_tests;
mod grid;
mod history;
#[cfg(feature = "methods")]
mod method;
#[cfg(test)]
mod tests;
mod volume;

pub use crate::path::depth_range;
pub use grid::{FroxelError, FroxelGrid, MOST_FROXELS, MOST_SLICES, lit_depths};
pub use history::{FroxelHistory, Jitter};
#[cfg(feature = "methods")]
pub(super) use method::methods;
pub use volume::{FroxelAirlight, FroxelLight, FroxelSteps, FroxelVolume, InjectFroxels};

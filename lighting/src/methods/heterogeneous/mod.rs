//! Media that are not the same everywhere, seen and lit: smoke on grids and as
//! particles, fog that thins out with altitude, each in the other and in even fog.
//!
//! Based on: M. Salvi, K. Vidimče, A. Lauritzen, A. Lefohn, "Adaptive Volumetric
//! Shadow Maps", Eurographics Symposium on Rendering 2010, whose shadows fall on the
//! smoke itself here; the way along the eye ray is not theirs.
//!
//! Along an eye ray, the light of a lamp that is scattered once is
//!
//! ```text
//! L = ∫ T(x) Σ σ_s p(cos θ) V(x) I / d² dx,      T(x) = exp(−∫₀ˣ σ_t)
//! ```
//!
//! summed over the media at x, with `V` the share of the lamp's light that gets
//! there. Everything but V is known in closed form on each [piece](crate::scene::MediaPiece)
//! of the ray, be it a voxel or a metre of fog: what a piece scatters is
//! `σ_s/σ_t` times what it takes from T, whatever its density, and the mean of `1/d²`
//! over it is an angle at the light over its length and h. So no step size is needed for the
//! density, and opaque smoke is no special case. Pieces are put together, and cut, to parts
//! that are at most 0.15 of the distance of the light long and 0.4 mean free paths deep, and
//! the light is evaluated once on each. V is asked once for each *step*, a run of such parts, at
//! the centroid of the light that it would scatter unshadowed.
//!
//! # Steps
//!
//! A ray has about N steps. A third of them is spread evenly over the length within
//! media, a third over the angle at the light, a third over what is left of T: a step
//! ends where it has had its share of any of the three. Under a sun there is no angle
//! and it is halves. Where a ray runs through smoke and fog, either has half of the steps of
//! even lengths, however far the fog is seen beside the smoke.
//!
//! # Error and cost
//!
//! What is not shadowed is right to the second order in the lengths of parts; shadows are
//! sampled N times and converge with the first order at their edges and the second
//! elsewhere. A ray visits each cell on its way once for every light, which is most of the
//! time with few steps.
//!
//! # Emission
//!
//! What grids [emit](crate::scene::DensityGrid::with_emission) needs no lamp: a frame adds
//! it once, by [`AddEmission`], beside the gathers of all lamps and the light of surfaces.
//!
//! # On GPUs
//!
//! The same pieces, parts and steps in f32, an invocation per ray, for visibility that
//! shaders ask at points: shadow maps and curves of a fixed size. Distances are measured from where a
//! ray enters the box around all smoke, for the digits of far voxels. Media are
//! uploaded once (`UploadedMedia`); of WebGPU's eight storage buffers these take three and
//! leave two to the visibility. A ray keeps the next 16 particles at hand, sorted, and
//! looks at all of them again behind those; where it is in more than 16 at once it
//! looks at all of them for every piece, with the same result. Against the CPU, a step in
//! some hundred thousand ends with another piece or falls to the other side of a shadow;
//! the others agree to rounding (`GpuMedia` in the table of tolerances).
//!
//! # Limits
//!
//! Single scattering. Even fog and fog that thins out take light on its way from the
//! lamp in closed form; what grids and particles take has to be part of V, as it is in
//! a [map of transmittance](super::translucent). Hair and see-through surfaces before the
//! eye dim what is behind them where they are [told of](MediaRays::panes), but not with
//! [`DoubleMarch`].
//!
//! On GPUs at most 16 grids and 16 different phase functions, and all densities in one
//! binding of the device: a grid that does not fit is named by the error (`MediaError`).
//! Optical depths and distances beyond 1e18 count as that. Curves of deep shadow maps,
//! opacity maps, Fourier maps and moments have no shader, and the double march has none.

mod baseline;
mod emission;
mod gather;
#[cfg(feature = "wgpu")]
mod gpu;
#[cfg(test)]
#[cfg(all(feature = "trace", feature = "translucent", feature = "wgpu"))]
mod gpu_tests;
mod memory;
#[cfg(all(feature = "methods", feature = "translucent"))]
mod method;
#[cfg(all(feature = "methods", feature = "translucent", feature = "wgpu"))]
mod method_gpu;
mod steps;
#[cfg(test)]
mod tests;

pub use baseline::DoubleMarch;
pub use emission::{AddEmission, EmittingRays};
pub use gather::{GatherMedia, MediaRays};
#[cfg(feature = "wgpu")]
pub use gpu::{MAX_GRIDS, MediaError, UploadedMedia};
pub use memory::{MediaMemory, MediaOf};
#[cfg(all(feature = "methods", feature = "translucent"))]
pub(super) use method::methods;

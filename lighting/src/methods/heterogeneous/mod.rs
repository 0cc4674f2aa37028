//! Heterogeneous media, as they are seen and lit: smoke on grids and as particles, and fog that
//! thins out with altitude, also inside each other and in homogeneous fog.
//!
//! Based on: M. Salvi, K. Vidimče, A. Lauritzen, A. Lefohn, "Adaptive Volumetric Shadow Maps",
//! Eurographics Symposium on Rendering 2010, for shadows, which fall on the smoke itself here.
//! The integration along the eye ray is not theirs.
//!
//! Along an eye ray, the light of a lamp that is scattered once is
//!
//! ```text
//! L = ∫ T(x) Σ σ_s p(cos θ) V(x) I / d² dx,      T(x) = exp(−∫₀ˣ σ_t)
//! ```
//!
//! summed over the media at x, where `V` is the share of the lamp's light that arrives there.
//! Everything except V is known in closed form on each [piece](crate::scene::MediaPiece) of the
//! ray, be it a voxel or a metre of fog. A piece scatters `σ_s/σ_t` times what it takes from T,
//! whatever its density, and the mean of `1/d²` over it is an angle at the light, divided by
//! the length and by h. So the density needs no step size, and opaque smoke is no special case.
//! Pieces are joined and cut to parts that are at most 0.4 mean free paths deep and no longer
//! than 0.15 of the distance of the light, and the light is evaluated once on each part. Where
//! there is even fog alone all factors but V are smooth, except at the full cone of a spotlight:
//! it is cut there, and to stretches, and the light is evaluated at the two nodes of Gauss's rule
//! in the angle at the light; of a sun, in the distance. A stretch is at most `min(0.6 T^−¼, 2)`
//! mean free paths deep and 16° wide at the light. It may be 32° wide if the lamp shines alike in
//! all directions and does not fade, the fog has no bounds, and the phase function has no narrow
//! peak (|g| ≤ 1/7). V is asked once for each *step*, which is a run of parts or stretches, at the
//! centroid of the light that the step would scatter unshadowed.
//!
//! # Steps
//!
//! A ray has about N steps. A third of them is spread evenly over the length within media, a
//! third over the angle at the light, and a third over what is left of T: a step ends when it
//! has had its share of any of the three. For a sun, which has no such angle, two halves
//! replace the thirds. Where a ray runs through smoke and fog, each has half of the steps of
//! equal length, however far the fog can be seen beside the smoke.
//!
//! # Error and cost
//!
//! Unshadowed light is of second order in the lengths of parts, and of fourth order in those of
//! stretches. Shadows are sampled N times; their error is of first order at their edges and of
//! second order elsewhere. A ray visits each cell on its way in which there is anything once
//! for every light, which takes most of the time where smoke fills the view and steps are few.
//! Empty cells are passed over: a bit for each cell tells.
//!
//! # Shadows whose ends are known
//!
//! [`PartsAndPoints`] takes the shadows of some casters from the lit parts of a ray, such as
//! those of [exact visibility](crate::visibility::Exact): steps end where lit parts do, what is
//! dark costs nothing but the walk, and the edges of these shadows have no error of the steps.
//! Everything else is asked about at points, as above. In the embedded scene `smoke-room`, whose
//! beams come through a window, 8 steps are then better than 128 without. The methods
//! `media-exact-area-8` and `media-exact-area-16` do this for all triangles; only smoke and hair
//! are in their curves. With many steps the error of the curves is left, which is largest where
//! the eye looks at a lamp in smoke: in that scene and with 64 steps 1.9 % of the mean with 8
//! nodes and 0.5 % with 16, which take twice the memory and 1.6 times as long to make, and no
//! longer to look up.
//!
//! # Emission
//!
//! The light that grids [emit](crate::scene::DensityGrid::with_emission) needs no lamp: a frame
//! adds it once, by [`AddEmission`], beside the gathers of all lamps and the light of surfaces.
//!
//! # On GPUs
//!
//! Shaders use the same pieces, parts and steps in f32, with one invocation per ray. They work
//! with visibility that shaders can ask at points: shadow maps and curves of a fixed size. The
//! methods have these curves made in shaders too, as [`translucent`](super::translucent) says.
//! Where shadows of triangles are exact, the CPU finds the lit parts, which shaders read with the
//! panes: 16 bytes for each end of a part, so that an image may have as many as one binding of
//! the device holds, 8 million in WebGPU; an error of the backend names the limit.
//! Distances are measured from the point where a ray enters the box around all smoke, so that
//! far voxels keep their digits. Media are uploaded once (`UploadedMedia`). Of WebGPU's eight
//! storage buffers they take three, and leave two to the visibility. A ray keeps the next 16
//! particles sorted, and searches all particles again behind those; inside more than 16
//! particles at once it searches all of them for every piece, with the same result. Compared
//! with the CPU, one step in some hundred thousand ends with another piece or falls on the
//! other side of a shadow; the others agree to rounding (`GpuMedia` in the table of
//! tolerances).
//!
//! # Limits
//!
//! Light is scattered once. Homogeneous fog, and fog that thins out, attenuate light on its way
//! from the lamp in closed form; the attenuation by grids and particles must be part of V, as
//! it is in a [transmittance map](super::translucent). Hair and see-through surfaces in front
//! of the eye dim what is behind them if the method is [told of them](MediaRays::panes), but
//! not with [`DoubleMarch`].
//!
//! GPUs support at most 16 grids and 16 different phase functions, and all densities must fit
//! into one binding of the device; the error names the grid that does not (`MediaError`).
//! Optical depths and distances above 1e18 count as 1e18. Curves of deep shadow maps, opacity
//! maps, Fourier maps and moments have no shader, and neither has the double march.

mod baseline;
mod emission;
#[cfg(all(feature = "methods", feature = "translucent"))]
mod exact_triangles;
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
pub use gather::{GatherMedia, MediaRays, PartsAndPoints};
#[cfg(feature = "wgpu")]
pub use gpu::{MAX_GRIDS, MediaError, UploadedMedia};
pub use memory::{MediaMemory, MediaOf};
#[cfg(all(feature = "methods", feature = "translucent"))]
pub(super) use method::methods;
#[cfg(all(feature = "methods", feature = "translucent"))]
pub use method::share_transmittance_map;

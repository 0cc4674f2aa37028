//! Hair as the eye sees it: strands are ribbons that face the eye, are lit, and are composed
//! with what is before and behind them.
//!
//! A piece of a strand covers the share `c` of a pixel. This is computed exactly, as the area
//! of its outline within the pixel, be it a thousandth of the pixel or all of it. Together with
//! the opacity of the strand it gives a *fragment* of the pixel: `α = c × opacity`, at the
//! distance `z` of the middle of the covered area. The pixel is
//!
//! ```text
//! L = Σ T(z_i) α_i F(z_i) L_i + ∫ T(z) dL_air + T(z_s) F(z_s) L_surface,
//! T(z) = Π_{z_j < z} (1 − α_j)
//! ```
//!
//! where `L_i` is the light that the strand scatters towards the eye and `F` the share that
//! fog, smoke and glass let through on the way. The light of fog and smoke before the hair is
//! added. Everything behind the hair, airlight included, is dimmed by it.
//!
//! # The curve of a pixel
//!
//! [`SeenHair`] sorts the fragments of a pixel, so that nothing depends on the order of
//! strands, and shades them with the exact `T`. For everything behind the hair it keeps an
//! adaptive transmittance curve of 16 nodes per pixel, as steps ([`SeenHair::cover`]). The
//! curve is exact for up to 8 fragments, and always exact behind the last one. A
//! [view](crate::scene::view::View::with_cover) with this cover shows surfaces behind hair, and
//! methods that [are told of it](crate::methods::share_cover) dim the air.
//!
//! # Light
//!
//! Each fragment asks which share of every light reaches it: through fog in closed form,
//! through hair and smoke by the light's transmittance map, and past triangles by a shadow ray.
//! In the map it asks about a point that is nearer to the light than the axis of the strand, by
//! two texels and the radius of the strand. So strands shade each other and not themselves.
//! [`Fibre`] says how a strand scatters the light.
//!
//! # Backends
//!
//! Which strands a pixel shows is found on the CPU. [`AddHairLight`] lights them there or on a
//! GPU (feature `wgpu`), which takes 96 bytes of memory for each fragment; more fragments than
//! a binding holds are lit one batch after the other. Backends agree to 1e-4 of the light of a
//! pixel, but where a strand is seen along its axis or is on the border of a triangle's shadow.
//! The shaders of GPUs know solid triangles alone, see `methods::exact::UploadedTracer`.
//!
//! Based on: M. Salvi, K. Vidimče, A. Lauritzen, A. Lefohn, "Adaptive Volumetric Shadow Maps",
//! Eurographics Symposium on Rendering 2010, for curves and self-shadows. The curves seen from
//! the eye are those of their "Adaptive Transparency" (HPG 2011), where the order of fragments
//! is not known. Here they are sorted, which costs less than shading them.
//!
//! # Error
//!
//! A ribbon is right to the rounding of f32. Two strands that cover parts of the same pixel
//! count as independent of each other, whether they overlap or lie side by side. The areas that
//! joined pieces of one strand cover are added. Fragments are ignored behind the first that
//! leaves less than 1e-4 of the light. Results depend neither on threads nor on the order of
//! strands.
//!
//! # Limits
//!
//! Light is scattered once; see [`Fibre::Marschner`] for what stands in for more. A strand has
//! one radiance over all of its width. It is a flat ribbon, with a gap on the outside of bends.
//! Light from the [`environment`](crate::environment), and light that fog scatters, does not
//! light hair. Hair that is nearer to the eye than its own thickness is not drawn.

mod fibre;
mod fragments;
#[cfg(feature = "wgpu")]
pub mod gpu;
#[cfg(feature = "wgpu")]
#[cfg(test)]
mod gpu_tests;
mod light;
#[cfg(test)]
mod tests;

pub use fibre::Fibre;
pub use fragments::SeenHair;
pub use light::{AddHairLight, HairMemory, LitHair};

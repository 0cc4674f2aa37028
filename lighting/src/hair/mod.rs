//! Hair as it is seen: strands as ribbons that face the eye, lit, and composed with what
//! is before and behind them.
//!
//! A piece of a strand covers the share `c` of a pixel, exactly: the area of its outline
//! there, be it a thousandth of the pixel or all of it. With the opacity of the strand
//! that is a *fragment* of the pixel, `α = c × opacity` at the distance `z` of the middle
//! of what is covered. The pixel is
//!
//! ```text
//! L = Σ T(z_i) α_i F(z_i) L_i + ∫ T(z) dL_air + T(z_s) F(z_s) L_surface,
//! T(z) = Π_{z_j < z} (1 − α_j)
//! ```
//!
//! with `L_i` what the strand scatters towards the eye and `F` what fog, smoke and glass
//! let through on the way. Fog and smoke before the hair are added, and what is behind
//! it, the light of the air too, is dimmed by the hair before it.
//!
//! # The curve of a pixel
//!
//! [`SeenHair`] sorts the fragments of a pixel, so that nothing depends on the order of
//! strands, and shades them with the exact `T`. What is kept for all that is behind hair is
//! an adaptive transmittance curve of 16 nodes per pixel, as steps
//! ([`SeenHair::cover`]): exact up to 8 fragments, and behind the last one always. A
//! [view](crate::scene::view::View::with_cover) with this cover shows surfaces behind hair,
//! and methods that [are told of it](crate::methods::share_cover) dim the air.
//!
//! # Light
//!
//! Each fragment asks every light that reaches it, through fog in closed form, through
//! hair and smoke by the map of transmittance of the light, and past triangles by a
//! shadow ray. It asks the map two texels and the radius of the strand nearer to the light
//! than the axis is: strands shade each other, and not themselves. What a strand does with
//! the light is told by [`Fibre`].
//!
//! Based on: M. Salvi, K. Vidimče, A. Lauritzen, A. Lefohn, "Adaptive Volumetric Shadow
//! Maps", Eurographics Symposium on Rendering 2010, for curves and self-shadows. The
//! curves seen from the eye are those of their "Adaptive Transparency" (HPG 2011), in
//! which the order of fragments is not known; here they are sorted, which costs less than
//! shading them does.
//!
//! # Error
//!
//! A ribbon is right to the rounding of f32. Two strands that cover parts of the same
//! pixel count as independent of each other, whether they overlap or lie side by side;
//! joined pieces of one strand do not: what they cover is added. Fragments behind which
//! less than 1e-4 of the light is left are the last ones. Results do not depend on
//! threads, nor on the order of strands.
//!
//! # Limits
//!
//! Light is scattered once; see [`Fibre::Marschner`] for what stands in for more. A strand
//! has one radiance over all of its width, and is a ribbon of no depth, with a gap on the
//! outside of bends. Light from all around
//! ([`environment`](crate::environment)) and by way of the fog does not light hair. What is nearer to the eye than the
//! thickness of the strand is not drawn.

mod fibre;
mod fragments;
mod light;
#[cfg(test)]
mod tests;

pub use fibre::Fibre;
pub use fragments::SeenHair;
pub use light::LitHair;

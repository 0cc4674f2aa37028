//! Maps on a GPU, and their parts for other shaders.
//!
//! [`BuildMap`] makes the curves of a [`TransmittanceMap`] with an invocation per texel:
//! its curve is in the memory of the invocation, takes the texel's segments in
//! their order, and is written when it is finished. What this takes in memory
//! beside the map does not depend on the number of segments. They come from
//! [`SegmentLists`], or from a shader of yours, [`ShaderSegments`]; and
//! [`CaptureSegments`] makes lists of segments that come in any order.
//! [`QueryMap`] answers receivers.
//!
//! # Parts for other shaders
//!
//! Plain text without bindings and entry points; all names begin with `avsm_`.
//! [`lookup_parts`] is what a shader needs that looks up the curves of a map, [`build_parts`]
//! what one needs that makes curves itself. Their pages have the signatures of the functions and
//! what the shader around them must write.
//!
//! # A whole shader
//!
//! Ground and a wall in the shadow of smoke, after `lookup_parts::<Packed<8>, 1>()`: the shader
//! of the example `smoke`, which has the Rust as well.
//!
#![doc = concat!("```wgsl\n", include_str!("../../examples/smoke/smoke.wgsl"), "\n```")]
//!
//! # Agreement with the CPU
//!
//! The steps are the same, but shaders have no f64: with `u = 2⁻²⁴`, a number
//! between two others is off by 9 u, and an insertion counts for 12 of the
//! CPU's in a curve's bound of roundings. Near-ties may be decided differently,
//! and then other nodes are removed; so what holds is that both curves are
//! within their own error bounds of the truth, and so within the sum of the two
//! of each other. Their mean errors are the same.
//!
//! The same curve looked up here and there differs by at most 2e-6
//! ([`LOOKUP_ERROR`]); of a [`PackedHalf`] also by a shift in depth of 2⁻²⁰ of its
//! range.
//!
//! Numbers below 2⁻¹²⁶ are 0 to shaders, depths among them. Where the CPU answers
//! ±∞ they answer ±[`f32::MAX`].
//!
//! # Limits
//!
//! A capacity of at most 66 nodes, so that `N W ≤ 64` for a [`Stream`], and 16
//! channels; at most five storage buffers and what [`ShaderSegments`] adds. Capacity
//! costs registers, and software drivers minutes to compile where it is for 64.

#[cfg(feature = "wgpu")]
mod build;
#[cfg(feature = "wgpu")]
mod capture;
mod constants;
mod parts;
#[cfg(feature = "wgpu")]
mod query;
#[cfg(test)]
#[cfg(feature = "wgpu")]
mod tests;

#[cfg(feature = "wgpu")]
pub use build::{SegmentsSlot, ShaderSegments};
pub use parts::{WgslRule, WgslStored, build_parts, lookup_parts};

#[cfg(doc)]
use crate::{
    BuildMap, CaptureSegments, PackedHalf, QueryMap, SegmentLists, Stream, TransmittanceMap,
};

/// A bound of what [`QueryMap`] adds to the error of a curve.
///
/// A share of the way between two nodes is off by 7 u, with `u = 2⁻²⁴`, a
/// difference, a product and a sum add 3 u: 10 u of a transmittance are 6e-7, of
/// an optical depth τ they are 10 u τ exp(−τ) < 3e-7, and the exponential
/// function is within 2e-7 here and 1.2e-7 on the CPU. Bilinear weights add 6
/// roundings.
pub const LOOKUP_ERROR: f32 = 2e-6;

/// The largest number of nodes that an invocation has room for.
pub(crate) const LARGEST_CAPACITY: usize = 66;

/// Invocations per workgroup of all shaders.
#[cfg(feature = "wgpu")]
const GROUP: u32 = 64;

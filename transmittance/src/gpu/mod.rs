//! Maps on a GPU, and their parts for other shaders.
//!
//! A map is made with an invocation per texel: its curve is in the memory of the invocation,
//! takes the texel's segments in their order, and is written when it is finished. There are
//! two ways to the segments:
//!
//! * [`build_from_candidates`] has them made where they are met. It lists what may be in the
//!   way (pieces of hair, particles, your own kinds) by square of texels, and every invocation
//!   asks a function of yours, a part of its shader, what each candidate of its lists takes
//!   from its ray. No fragment is in memory: lists have at most four entries per candidate,
//!   whatever their size and the map's. This is the one to start with.
//! * [`BuildMap`] takes segments that are in memory already, as [`SegmentLists`], or that a
//!   shader of yours knows by texel and number, [`ShaderSegments`]. [`CaptureSegments`] makes
//!   lists of segments that come in any order, as from a rasteriser, with memory for each.
//!
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
//! Ground and a wall in the shadow of smoke, after `lookup_parts::<Packed<8>, 1>()`:
//!
#![doc = concat!("```wgsl\n", include_str!("../../examples/smoke/smoke.wgsl"), "\n```")]
//!
//! The Rust around it, by wgpu 30 (feature `wgpu`). You choose wgpu's driver, as
//! [`gpu_backend::gpu`] says. `SMOKE` is the text above, and `light` the plain data of its first
//! uniform; the segments are those of the lists, 128 × 128 texels of them.
//!
#![cfg_attr(feature = "wgpu", doc = "```no_run")]
#![cfg_attr(not(feature = "wgpu"), doc = "```ignore")]
//! use transmittance::gpu::lookup_parts;
//! use transmittance::gpu_backend::gpu::{Argument, Context, Gpu, GpuMemory};
//! use transmittance::{BuildMap, Curve, Packed, SegmentLists, TransmittanceMap};
//! # const SMOKE: &str = "";
//! # fn frame(
//! #     (device, queue): (wgpu::Device, wgpu::Queue),
//! #     encoder: &mut wgpu::CommandEncoder,
//! #     lists: &SegmentLists<GpuMemory>,
//! #     light: [[f32; 4]; 2],
//! # ) -> Result<(), Box<dyn std::error::Error>> {
//!
//! // Once per device.
//! let context = Context::new(device, queue);
//! let parts = [&lookup_parts::<Packed<8>, 1>()[..], &[SMOKE]].concat();
//! let module = context.device().create_shader_module(wgpu::ShaderModuleDescriptor {
//!     label: Some("smoke"),
//!     source: wgpu::ShaderSource::Wgsl(parts.join("\n").into()),
//! });
//!
//! // Each frame: the map, and the bindings of the shader, `@binding(0)` first.
//! let gpu = Gpu::record(&context, encoder);
//! let mut map = TransmittanceMap::<_, Packed<8>>::new(&gpu, [128, 128])?;
//! gpu.build_map(&Curve::<8>::new(), lists, &mut map)?;
//! drop(gpu);
//! let arguments = [Argument::uniform(light), Argument::read(map.words())];
//! let stages = wgpu::ShaderStages::FRAGMENT;
//! let layout = context.scoped("smoke", || context.bind_group_layout("smoke", stages, &arguments))?;
//! let group = context.bind_group("smoke", &layout, &arguments)?;
//! # Ok(())
//! # }
//! ```
//!
//! `module` and `layout` go into a render pipeline of your own. The whole program is
//! `transmittance/examples/smoke` in the repository; there the lists are captured from fragments
//! that the renderer draws:
//!
//! ```console
//! $ cargo run -p crepuscular-transmittance --example smoke --features wgpu,gpu-backend/vulkan
//! ```
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
//! channels; at most five storage buffers and what [`ShaderSegments`] or [`ShaderCandidates`]
//! adds. Capacity costs registers, and software drivers minutes to compile where it is for 64.

#[cfg(feature = "wgpu")]
mod build;
#[cfg(feature = "wgpu")]
mod candidates;
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
#[cfg(feature = "wgpu")]
pub use candidates::{CandidatesSlot, Crowding, ShaderCandidates, build_from_candidates};
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

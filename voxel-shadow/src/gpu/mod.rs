//! Shadow volumes on a GPU, and their part for other shaders.
//!
//! [`SHADOW`] holds the queries as functions with the prefix `vsv_`, without
//! bindings: paste it after `epipolar::gpu::EPIPOLAR` and `PHI`, define `vsv_word`,
//! which reads the grid, and `epi_bound`. [`SamplingRecord`] is what it takes for
//! a [`Sampling`]. The page of each part has the signatures of its functions with their
//! units, and the source.
//!
//! Here [`Rectify`](crate::Rectify) takes a depth texture that a renderer has drawn, as
//! [`DepthLayers`], and anything else that fits the [`FirstBlockerSlot`]; [`DEPTH`] helps to
//! write that. [`RectifyAtlas`](crate::RectifyAtlas) takes shadow maps of many lights that
//! fit the [`AtlasBlockerSlot`], and [`RectifyMasked`](crate::RectifyMasked) holes of
//! triangles that fit the [`HolesSlot`].
//!
//! # A whole shader
//!
//! Fog with shadows from a lamp's cube map, after the parts `EPIPOLAR`, `PHI` and [`SHADOW`]
//! and those of the crate `airlight` for its table: the shader of the example `fog`,
//! which has the Rust as well.
//!
#![doc = concat!("```wgsl\n", include_str!("../../examples/fog/fog.wgsl"), "\n```")]
//!
//! # Agreement with the CPU
//!
//! Setting bits and extruding them are integer steps: the same bits for the same
//! index map. Rectified indices differ by one where a blocker is within
//! rounding of the border of a voxel, 1.6e-6 rad on either side: the share of
//! the indices is at most 3.2e-6 divided by the width of a voxel along α, and
//! what the source itself adds at silhouettes. Queries agree but for rays within
//! the same distance of another texel.
//!
//! Distances to the sky are [`f32::MAX`]; shaders may assume that infinities do not
//! occur, and so the numbers in buffers must be finite.
//!
//! # Limits
//!
//! Steps bind at most five storage buffers, and those that a part in a slot adds.

#[cfg(feature = "wgpu")]
mod atlas;
#[cfg(feature = "wgpu")]
#[cfg(test)]
mod atlas_tests;
#[cfg(feature = "wgpu")]
mod build;
#[cfg(feature = "wgpu")]
mod depth_layers;
mod parts;
#[cfg(feature = "wgpu")]
mod query;
#[cfg(feature = "wgpu")]
mod rectify;
mod sampling;
#[cfg(feature = "wgpu")]
#[cfg(test)]
mod tests;

#[cfg(feature = "wgpu")]
pub use atlas::AtlasBlockerSlot;
#[cfg(feature = "wgpu")]
pub use depth_layers::DepthLayers;
pub use parts::{DEPTH, SHADOW};
#[cfg(feature = "wgpu")]
pub use rectify::{FirstBlockerSlot, HolesSlot};
pub use sampling::SamplingRecord;

#[cfg(doc)]
use crate::Sampling;

/// Invocations per workgroup of all shaders but the scan.
#[cfg(feature = "wgpu")]
const GROUP: u32 = 64;

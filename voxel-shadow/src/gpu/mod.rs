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
//! Steps (feature `wgpu`) run on wgpu 30, for which you choose the driver, as
//! [`gpu_backend::gpu`] says. The parts and records (feature `wgsl`) need neither.
//!
//! # A whole shader
//!
//! Fog with shadows from a lamp's cube map. The shader is the text of these parts, in this
//! order, and of what is below:
//!
//! 1. [`epipolar::gpu::EPIPOLAR`] and [`epipolar::gpu::PHI`];
//! 2. [`SHADOW`], and [`DEPTH`] for `vsv_cube_face`;
//! 3. `SEGMENT`, `NUMERIC`, `SCALED` and `TABLE` of `airlight::gpu`, in the package
//!    `crepuscular-airlight` (feature `wgsl`). A `Table` knows its phase function, so that the
//!    part `PHASE` is not needed.
//!
#![doc = concat!("```wgsl\n", include_str!("../../examples/fog/fog.wgsl"), "\n```")]
//!
//! The Rust around it, for a renderer that has drawn `shadow_map`, a view of the six faces as an
//! array of depths. `FOG` is the text above; `frame` and `boxes` are the plain data of its first
//! two uniforms.
//!
#![cfg_attr(feature = "wgpu", doc = "```no_run")]
#![cfg_attr(not(feature = "wgpu"), doc = "```ignore")]
//! use airlight::gpu::{NUMERIC, SCALED, SEGMENT, TABLE};
//! use airlight::{PhaseFunction, Table};
//! use voxel_shadow::epipolar::gpu::{EPIPOLAR, LatticeRecord, PHI};
//! use voxel_shadow::epipolar::{Lattice, Light, Resolution, Space, Spacing, ViewVolume};
//! use voxel_shadow::gpu::{DEPTH, DepthLayers, SHADOW, SamplingRecord};
//! use voxel_shadow::gpu_backend::Backend;
//! use voxel_shadow::gpu_backend::gpu::{Argument, Context, Gpu};
//! use voxel_shadow::{BuildGrid, DepthViews, Grid, IndexMap, Rectify, Sampling};
//! # const FOG: &str = "";
//! # const NEAR: f32 = 0.05;
//! # fn frame(
//! #     (device, queue): (wgpu::Device, wgpu::Queue),
//! #     encoder: &mut wgpu::CommandEncoder,
//! #     shadow_map: &wgpu::TextureView,
//! #     (frame, boxes): ([[f32; 4]; 3], [[[f32; 4]; 2]; 16]),
//! #     [eye, forward, up, lamp]: [[f32; 3]; 4],
//! # ) -> Result<(), Box<dyn std::error::Error>> {
//!
//! // Once per device, phase function and resolution.
//! let context = Context::new(device, queue);
//! let parts = [EPIPOLAR, PHI, SHADOW, DEPTH, SEGMENT, NUMERIC, SCALED, TABLE, FOG];
//! let module = context.device().create_shader_module(wgpu::ShaderModuleDescriptor {
//!     label: Some("fog"),
//!     source: wgpu::ShaderSource::Wgsl(parts.join("\n").into()),
//! });
//! let table = Table::new(&PhaseFunction::Isotropic, 64)?;
//! let voxels = Resolution::new(512, 512, 256)?;
//! let gpu = Gpu::new(context.clone());
//! let cells = gpu.upload(&table.gpu_cells())?;
//! let (mut map, mut grid) = (IndexMap::new(&gpu, voxels)?, Grid::new(&gpu, voxels)?);
//!
//! // Each frame, after the pass that draws the shadow map and into the same encoder.
//! let space = Space::new(Light::point(lamp)?, eye)?;
//! let view = ViewVolume::perspective(forward, up, [0.7, 0.7], 0.0, 30.0)?;
//! let lattice = Lattice::new(space, &view, voxels, Spacing::Angle)?;
//! let views = DepthViews::cube(lamp, NEAR)?;
//! let gpu = Gpu::record(&context, encoder);
//! gpu.rectify(&lattice, &DepthLayers::new(&views, shadow_map), &mut map)?;
//! gpu.voxelise(&map, &mut grid)?;
//! gpu.extrude(&mut grid)?;
//! drop(gpu);
//!
//! // The bindings of the shader: the first argument is `@binding(0)`, and so on.
//! let depth = wgpu::TextureSampleType::Depth;
//! let arguments = [
//!     Argument::uniform(frame),
//!     Argument::uniform(boxes),
//!     Argument::uniform(LatticeRecord::new(&lattice)),
//!     Argument::table(lattice.bounds()),
//!     Argument::uniform(SamplingRecord::new(&Sampling::default())),
//!     Argument::read(grid.words()),
//!     Argument::uniform(table.gpu_uniforms()),
//!     Argument::read(&cells),
//!     Argument::texture_of(shadow_map, depth, wgpu::TextureViewDimension::D2Array),
//! ];
//! let stages = wgpu::ShaderStages::FRAGMENT;
//! let layout = context.scoped("fog", || context.bind_group_layout("fog", stages, &arguments))?;
//! let group = context.bind_group("fog", &layout, &arguments)?;
//! # Ok(())
//! # }
//! ```
//!
//! `module` and `layout` go into a render pipeline of your own, which is made once; `group` is
//! for this frame. [A pass of your own](gpu_backend::gpu#a-pass-of-your-own) says more. The whole program is `voxel-shadow/examples/fog` in the repository:
//!
//! ```console
//! $ cargo run -p crepuscular-voxel-shadow --example fog --features wgpu,gpu-backend/vulkan
//! ```
//!
//! # From frame to frame
//!
//! Keep the `Context`, which has the pipelines, the [`IndexMap`](crate::IndexMap),
//! the [`Grid`](crate::Grid) and the table. When the eye, the view or the light moves, make the
//! `Space`, the `Lattice` and its record anew, for a light the [`DepthViews`](crate::DepthViews)
//! too, and take the three steps again; they overwrite what the map and the grid held. When a caster moves, draw the shadow map and take the three steps
//! again with the same lattice. Another resolution needs another map and another grid.
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

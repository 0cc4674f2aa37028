//! Queries on a GPU, and their parts for other shaders; with the feature `wgpu`
//! also `PeeledMesh`, which finds the depths under texels there.
//!
//! The parts hold functions with the prefix `dag_`, without bindings. Paste
//! [`POINT`], [`PLAIN`] or [`PACKED`], and of [`EXTENT`], [`SPACE`] and
//! [`RAY`] what is needed, and define `dag_word`, which reads the words of a
//! [`ResidentDag`](crate::ResidentDag). [`DagRecord`] and [`SpaceRecord`] are
//! what the functions take. The page of each part has the signatures of its functions with
//! their units, and the source.
//!
//! # A whole shader
//!
//! Buildings in sunlight with a 9 × 9 filter, after `POINT`, `PACKED`, `EXTENT` and `SPACE`:
//!
#![doc = concat!("```wgsl\n", include_str!("../../examples/sunlight/sunlight.wgsl"), "\n```")]
//!
//! The Rust around it, by wgpu 30 (feature `wgpu`). You choose wgpu's driver, as
//! [`gpu_backend::gpu`] says. `SUNLIGHT` is the text above, `sun` the plain data of its uniform,
//! and `surfaces` a buffer of 16 bytes per pixel.
//!
#![cfg_attr(feature = "wgpu", doc = "```no_run")]
#![cfg_attr(not(feature = "wgpu"), doc = "```ignore")]
//! use gpu_backend::gpu::{Argument, Context, Gpu, GpuBuffer};
//! use shadow_dag::gpu::{DagRecord, EXTENT, PACKED, POINT, SPACE, SpaceRecord};
//! use shadow_dag::{Form, ShadowSet};
//! # const SUNLIGHT: &str = "";
//! # fn frame(
//! #     (device, queue): (wgpu::Device, wgpu::Queue),
//! #     file: &[u8],
//! #     sun: [f32; 4],
//! #     surfaces: &mut GpuBuffer<[f32; 4]>,
//! # ) -> Result<(), Box<dyn std::error::Error>> {
//!
//! // Once per file: its words go to the device.
//! let context = Context::new(device, queue);
//! let set = ShadowSet::read(file)?;
//! let grid = &set.grids().next().ok_or("a file has a grid")?;
//! let light = grid.light().ok_or("it was made from a mesh")?;
//! let space = SpaceRecord::new(light, grid.resolution()); // a uniform of the group 1
//! let shadows = grid.to_form(Form::Packed)?.upload(&Gpu::new(context.clone()))?;
//! let parts = [POINT, PACKED, EXTENT, SPACE, SUNLIGHT];
//! let module = context.device().create_shader_module(wgpu::ShaderModuleDescriptor {
//!     label: Some("sunlight"),
//!     source: wgpu::ShaderSource::Wgsl(parts.join("\n").into()),
//! });
//!
//! // Each frame: the group 0 of both passes. The first argument is `@binding(0)`, and so on.
//! let arguments = [
//!     Argument::write(surfaces),
//!     Argument::uniform(sun),
//!     Argument::uniform(DagRecord::new(&shadows)),
//!     Argument::read(shadows.words()),
//! ];
//! let stages = wgpu::ShaderStages::COMPUTE | wgpu::ShaderStages::FRAGMENT;
//! let layout = context.scoped("sun", || context.bind_group_layout("sun", stages, &arguments))?;
//! let group = context.bind_group("sun", &layout, &arguments)?;
//! # Ok(())
//! # }
//! ```
//!
//! Layouts go into pipelines of your own. The whole program is `shadow-dag/examples/sunlight` in
//! the repository:
//!
//! ```console
//! $ cargo run -p crepuscular-shadow-dag --example sunlight --features wgpu,gpu-backend/vulkan
//! ```
//!
//! # Agreement with the CPU
//!
//! Voxels, depths, boxes and counts of lit texels are integers, and those of
//! the CPU bit by bit. A filter is such a count, divided: within 3 units in
//! the last place (WGSL allows 2.5 for the quotient, and the numbers of texels
//! of filters wider than 4096 are rounded). A bilinear filter weighs four of
//! those with weights that are exact but for two subtractions: within 16 units
//! in the last place of 1.
//!
//! Rays are computed in f32, on the CPU in f64. A point of a ray is answered
//! from its own voxel or from one at most δ voxels beside it,
//!
//! ```text
//! δ = 2⁻²⁰ · N · S
//! ```
//!
//! of `N` voxels along each axis. `S` ≥ 1 is the largest sum, over the rows of
//! the matrix of the light and over both ends of the part that is in the grid,
//! of the sizes of all products of the row with `(origin, 1)` and with
//! `s · direction`, divided by `W`: 2 or so if the origin of the world is in
//! the map, and 100 if it is 100 maps away. Each of the products loses a unit
//! of 2⁻²⁴ by rounding the matrix and up to four by adding up, and a plane is
//! crossed where two such sums cancel, a quotient good to 2.5 units; 16 cover
//! them. Logarithmic slices add 2⁻²⁰ · N (1/L + 1), L = ln(far/near), along
//! the light: exponentials are off by 3 + 2L units, and logarithms by 2⁻²¹.
//!
//! # Limits
//!
//! A ray takes a step for each homogeneous volume, at most 3N of them. Numbers
//! in buffers must be finite. Four storage buffers at most.
//!
//! Some software drivers (lavapipe of Mesa 22.3) cannot compile [`EXTENT`] and [`SPACE`] in one
//! entry point; the shader above finds the voxels in the pass before.

mod parts;
// Depths are read back tile by tile, for which a browser does not wait.
#[cfg(all(feature = "wgpu", not(target_family = "wasm")))]
mod peel;
#[cfg(feature = "wgpu")]
mod query;
mod record;
#[cfg(feature = "wgpu")]
#[cfg(test)]
mod tests;

pub use parts::{EXTENT, PACKED, PLAIN, POINT, RAY, SPACE};
#[cfg(all(feature = "wgpu", not(target_family = "wasm")))]
pub use peel::PeeledMesh;
pub use record::{DagRecord, SpaceRecord};

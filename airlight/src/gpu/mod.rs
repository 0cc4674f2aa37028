//! Airlight on a GPU: parts for any shader.
//!
//! A part is WGSL text that holds only functions, structures and constants
//! whose names start with `air_`; concatenate those that are needed, in the
//! order of this table, with a shader of one's own.
//!
//! | part | what | needs |
//! |---|---|---|
//! | [`PHASE`] | phase functions | |
//! | [`SEGMENT`] | `air_Segment`, the shader's side of [`Segment`](crate::Segment), and `air_segment`, which makes one | |
//! | [`NUMERIC`] | arithmetic that does not overflow | `SEGMENT` |
//! | [`SCALED`] | a segment in a unit of its own | `NUMERIC` |
//! | [`TABLE`] | `air_table_airlight`: [`Table`](crate::Table) | `SCALED` |
//! | [`NODES`] | `air_nodes`, `air_next_node`: [`Quadrature::nodes`](crate::Quadrature::nodes) | `SCALED` |
//! | [`QUADRATURE`] | `air_quadrature_airlight`: [`Quadrature`](crate::Quadrature) | `PHASE`, `NODES` |
//! | [`SUN_TABLE`] | `air_sun_table_airlight`: [`SunTable`](crate::SunTable) | `NUMERIC` |
//! | [`FRAME_TABLE`] | `air_frame_look_up`: [`FrameTable`](crate::FrameTable) | `SEGMENT` |
//! | [`SURFACE`] | `air_lobe`, `air_gloss`: the tables of [`surface`](crate::surface) | |
//!
//! The page of each part has the signatures of its functions with their units and errors,
//! what the shader around it must write, and the source. What a page does not name is the
//! part's own business.
//!
//! Each evaluator reaches its data through a function or two that the shader around it
//! writes, so that the data may be bound anywhere.
//!
//! # A whole shader
//!
//! A lamp in fog over a floor, after the parts `PHASE`, `SEGMENT`, `NUMERIC`, `SCALED` and
//! `TABLE`:
//!
#![doc = concat!("```wgsl\n", include_str!("../../examples/lamp/lamp.wgsl"), "\n```")]
//!
//! The Rust around it, by wgpu 30 (feature `wgpu`). You choose wgpu's driver, as
//! [`gpu_backend::gpu`] says; it also says more of [passes of your
//! own](gpu_backend::gpu#a-pass-of-your-own). `LAMP` is the text above, and `frame` the plain data of its first
//! uniform.
//!
#![cfg_attr(feature = "wgpu", doc = "```no_run")]
#![cfg_attr(not(feature = "wgpu"), doc = "```ignore")]
//! use airlight::gpu::{NUMERIC, PHASE, SCALED, SEGMENT, TABLE};
//! use airlight::gpu_backend::Backend;
//! use airlight::gpu_backend::gpu::{Argument, Context, Gpu};
//! use airlight::{PhaseFunction, Table};
//! # const LAMP: &str = "";
//! # fn frame(
//! #     (device, queue): (wgpu::Device, wgpu::Queue),
//! #     frame: [[f32; 4]; 3],
//! # ) -> Result<(), Box<dyn std::error::Error>> {
//!
//! // Once per device and phase function.
//! let context = Context::new(device, queue);
//! let table = Table::new(&PhaseFunction::HenyeyGreenstein { g: 0.6 }, 64)?;
//! let cells = Gpu::new(context.clone()).upload(&table.gpu_cells())?;
//! let parts = [PHASE, SEGMENT, NUMERIC, SCALED, TABLE, LAMP];
//! let module = context.device().create_shader_module(wgpu::ShaderModuleDescriptor {
//!     label: Some("lamp"),
//!     source: wgpu::ShaderSource::Wgsl(parts.join("\n").into()),
//! });
//!
//! // Each frame: the first argument is `@binding(0)`, and so on.
//! let arguments = [
//!     Argument::uniform(frame),
//!     Argument::uniform(table.gpu_uniforms()),
//!     Argument::read(&cells),
//! ];
//! let stages = wgpu::ShaderStages::FRAGMENT;
//! let layout = context.scoped("lamp", || context.bind_group_layout("lamp", stages, &arguments))?;
//! let group = context.bind_group("lamp", &layout, &arguments)?;
//! # Ok(())
//! # }
//! ```
//!
//! `module` and `layout` go into a render pipeline of your own. With the feature `wgsl` alone,
//! [`Table::gpu_uniforms`](crate::Table::gpu_uniforms) and
//! [`Table::gpu_cells`](crate::Table::gpu_cells) are plain data for buffers that you make by any
//! other means. The whole program is `airlight/examples/lamp` in the repository:
//!
//! ```console
//! $ cargo run -p crepuscular-airlight --example lamp --features wgsl,gpu-backend/vulkan
//! ```
//!
//! # Batches
//!
//! With the feature `wgpu` an evaluator with a shader implements
//! `InShader<EvaluatorSlot>`;
//! then a GPU has the step [`EvaluateAirlight`](crate::EvaluateAirlight) for it,
//! with the data in `@group(1)`, uploaded with every batch. A phase function that is a closure
//! has no shader; a [`Table`](crate::Table) of it has one.
//!
//! # Agreement with the CPU
//!
//! Shaders have single precision only, and an exponent that is rounded by some
//! units of its last digit: through an optical depth τ results differ by about
//! `τ` millionths, 1e-4 at τ = 100, and by 1e-5 through thin media. A table may
//! be looked up in the neighbouring cell, and a quadrature may take a rule of
//! one node more or less, where a number lies on the border; both results are
//! then as good as the table and the tolerance are.
//!
//! # Limits
//!
//! `f32::MAX` stands for infinity, in lengths and in results: shaders may
//! assume that there are no infinities. Lengths and results below `2^-126` may
//! count as 0, rays that pass the light within `2^-100` of the distance of the
//! segment's start meet it, and what is farther away than `2^60` of that is not
//! looked at. Segments without a result (no light, no lengths, no extinction)
//! give 0.
//!
//! Some software drivers end loops after 65,535 iterations: a quadrature with
//! more than 1000 nodes per piece may lose pieces there.

#[cfg(feature = "wgpu")]
mod batch;
mod frame_table;
mod parts;
mod phase;
mod quadrature;
#[cfg(feature = "wgpu")]
mod sun_table;
mod table;
#[cfg(test)]
#[cfg(feature = "wgpu")]
mod tests;

#[cfg(feature = "wgpu")]
pub use batch::EvaluatorSlot;
pub use frame_table::FrameTableRecord;
pub use parts::{
    FRAME_TABLE, NODES, NUMERIC, PHASE, QUADRATURE, SCALED, SEGMENT, SUN_TABLE, SURFACE, TABLE,
};
pub use phase::PhaseRecord;
pub use quadrature::QuadratureUniforms;
pub use table::TableUniforms;

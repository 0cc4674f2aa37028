//! Airlight on a GPU: parts for any shader.
//!
//! A part is WGSL text that holds only functions, structures and constants
//! whose names start with `air_`; concatenate those that are needed, in the
//! order of this table, with a shader of one's own.
//!
//! | part | what | needs |
//! |---|---|---|
//! | [`PHASE`] | phase functions | |
//! | [`SEGMENT`] | `air_Segment`, the shader's side of [`Segment`](crate::Segment) | |
//! | [`NUMERIC`] | arithmetic that does not overflow | `SEGMENT` |
//! | [`SCALED`] | a segment in a unit of its own | `NUMERIC` |
//! | [`TABLE`] | `air_table_airlight`: [`Table`](crate::Table) | `SCALED` |
//! | [`NODES`] | `air_nodes`, `air_next_node`: [`Quadrature::nodes`](crate::Quadrature::nodes) | `SCALED` |
//! | [`QUADRATURE`] | `air_quadrature_airlight`: [`Quadrature`](crate::Quadrature) | `PHASE`, `NODES` |
//! | [`SUN_TABLE`] | `air_sun_table_airlight`: [`SunTable`](crate::SunTable) | `NUMERIC` |
//! | [`FRAME_TABLE`] | `air_frame_look_up`: [`FrameTable`](crate::FrameTable) | `SEGMENT` |
//! | [`SURFACE`] | `air_lobe`, `air_gloss`: the tables of [`surface`](crate::surface) | |
//!
//! Each evaluator reaches its data through a function or two that its part names at
//! the top and leaves to the shader around it, which binds the data where it
//! likes:
//!
//! | part | functions | what they return |
//! |---|---|---|
//! | `TABLE` | `air_table_uniforms`, `air_table_cell` | [`Table::gpu_uniforms`](crate::Table::gpu_uniforms), an entry of [`Table::gpu_cells`](crate::Table::gpu_cells) |
//! | `NODES` | `air_quadrature_uniforms`, `air_quadrature_entry` | [`Quadrature::gpu_uniforms`](crate::Quadrature::gpu_uniforms), an entry of [`Quadrature::gpu_entries`](crate::Quadrature::gpu_entries) |
//! | `SUN_TABLE` | `air_sun_table_rows`, `air_sun_table_value` | [`SunTable::gpu_rows`](crate::SunTable::gpu_rows), an entry of [`SunTable::gpu_values`](crate::SunTable::gpu_values) |
//! | `FRAME_TABLE` | `air_frame_cell` | an entry of [`FrameTable::gpu_cells`](crate::FrameTable::gpu_cells) |
//! | `SURFACE` | `air_surface_coefficient` | an entry of [`LobeTable::coefficients`](crate::surface::LobeTable::coefficients) or [`GlossTable::coefficients`](crate::surface::GlossTable::coefficients) |
//!
//! An integrand of one's own takes its nodes from `NODES`:
//!
//! ```wgsl
//! var nodes = air_nodes(sigma_t, segment);
//! loop {
//!     let node = air_next_node(&nodes);
//!     if node.done { break; }
//!     sum += node.weight * f(segment.x + node.distance);
//! }
//! ```
//!
//! For a light with a pattern `air_pattern_nodes` takes an `air_Pattern` as well,
//! which says how many nodes more a piece gets
//! ([`Quadrature::nodes_of`](crate::Quadrature::nodes_of)); the shader divides the
//! segment at the rims of the light and has the emission in its `f`.
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
pub use phase::PhaseRecord;
pub use quadrature::QuadratureUniforms;
pub use table::TableUniforms;

/// Phase functions: `air_phase`, `air_phase_from_foot`.
pub const PHASE: &str = include_str!("phase.wgsl");
/// A segment, and the largest number.
pub const SEGMENT: &str = include_str!("segment.wgsl");
/// Powers of two, products and distances that do not overflow.
pub const NUMERIC: &str = include_str!("numeric.wgsl");
/// A segment in a unit in which its squares are in range.
pub const SCALED: &str = include_str!("scaled.wgsl");
/// `air_table_airlight`.
pub const TABLE: &str = include_str!("table.wgsl");
/// `air_nodes` and `air_next_node`.
pub const NODES: &str = include_str!("nodes.wgsl");
/// `air_quadrature_airlight`.
pub const QUADRATURE: &str = include_str!("quadrature.wgsl");
/// `air_sun_table_airlight`.
pub const SUN_TABLE: &str = include_str!("sun_table.wgsl");
/// `air_frame_look_up`.
pub const FRAME_TABLE: &str = include_str!("frame_table.wgsl");
/// `air_lobe` and `air_gloss`.
pub const SURFACE: &str = include_str!("surface.wgsl");

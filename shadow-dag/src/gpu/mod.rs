//! Queries on a GPU, and their parts for other shaders; with the feature `wgpu`
//! also `PeeledMesh`, which finds the depths under texels there.
//!
//! The parts hold functions with the prefix `dag_`, without bindings. Paste
//! [`POINT`], [`PLAIN`] or [`PACKED`], and of [`EXTENT`], [`SPACE`] and
//! [`RAY`] what is needed, and define `dag_word`, which reads the words of a
//! [`ResidentDag`](crate::ResidentDag). [`DagRecord`] and [`SpaceRecord`] are
//! what the functions take.
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

#[cfg(feature = "wgpu")]
mod peel;
#[cfg(feature = "wgpu")]
mod query;
mod record;
#[cfg(feature = "wgpu")]
#[cfg(test)]
mod tests;

#[cfg(feature = "wgpu")]
pub use peel::PeeledMesh;
pub use record::{DagRecord, SpaceRecord};

/// WGSL of questions about single voxels and texels.
pub const POINT: &str = include_str!("point.wgsl");

/// WGSL of nodes of [`Form::Plain`](crate::Form::Plain).
pub const PLAIN: &str = include_str!("plain.wgsl");

/// WGSL of nodes of [`Form::Packed`](crate::Form::Packed).
pub const PACKED: &str = include_str!("packed.wgsl");

/// WGSL of boxes and filters.
pub const EXTENT: &str = include_str!("extent.wgsl");

/// WGSL of the space of a light.
pub const SPACE: &str = include_str!("space.wgsl");

/// WGSL of rays.
pub const RAY: &str = include_str!("ray.wgsl");

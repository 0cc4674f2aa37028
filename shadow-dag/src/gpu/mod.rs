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
//! the shader of the example `sunlight`, which has the Rust as well.
//!
#![doc = concat!("```wgsl\n", include_str!("../../examples/sunlight/sunlight.wgsl"), "\n```")]
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

//! Shadows of static geometry, precomputed: a few megabytes that say of every
//! voxel of a grid of up to 2²⁰ along each axis whether one light reaches it.
//!
//! The package is `crepuscular-shadow-dag` and the library `shadow_dag`: `Cargo.toml` has the
//! first name, and `use` the second.
//!
//! The grid lies in the space of the light: texels of a depth map, and slices
//! along its rays. Its voxels are kept as a directed acyclic graph of nodes no
//! two of which are equal; what is inside of closed solids, where nobody asks,
//! is filled so that as few nodes as possible are needed. The graph grows with
//! the length of the silhouettes and not with the area of the map.
//!
//! ```
//! use glam::IVec3;
//! use gpu_backend::Cpu;
//! use shadow_dag::{Builder, DepthMap, FilterSize, Form, Resolution, ShadowDag, Slices};
//!
//! // A slab over the left half of the map: entered at 0.25, left at 0.5.
//! let resolution = Resolution::new(64)?;
//! let slab = |inside: f32| -> Vec<f32> {
//!     (0..64 * 64).map(|i| if i % 64 < 32 { inside } else { f32::INFINITY }).collect()
//! };
//! let (enter, exit) = (slab(0.25), slab(0.5));
//! let map = DepthMap::new(resolution, Slices::Linear, &enter)?.with_exit(&exit)?;
//! let shadows = Builder::new().build(&Cpu::new(), &map)?;
//!
//! assert!(shadows.is_lit(IVec3::new(10, 10, 15)), "in front of the slab");
//! assert!(!shadows.is_lit(IVec3::new(10, 10, 32)), "behind it");
//! let filter = FilterSize::new(9)?;
//! assert_eq!(shadows.filter(IVec3::new(32, 32, 40), filter), 45.0 / 81.0);
//!
//! // Packed for storing; the bytes are the file.
//! let bytes = shadows.to_form(Form::Packed)?.into_bytes();
//! let read = ShadowDag::from_bytes(bytes.as_slice())?;
//! assert!(!read.is_lit(IVec3::new(10, 10, 32)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Light on a surface
//!
//! A point of the world finds its voxel by the [`LightSpace`] that a file carries.
//!
//! ```
//! use glam::dcamera::rh::view::look_to_mat4;
//! use glam::{DVec3, Vec3};
//! use gpu_backend::Cpu;
//! use shadow_dag::{Builder, FilterSize, LightSpace, Mesh, Resolution, ShadowSet};
//!
//! // A roof of 2 m, 1 m above the ground, under a sun in the zenith.
//! let corners = [[-1.0, 1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]];
//! let view = look_to_mat4(DVec3::new(0.0, 10.0, 0.0), DVec3::NEG_Y, DVec3::X);
//! let sun = LightSpace::orthographic(view, 8.0, 8.0, 0.0, 20.0)?;
//! let mesh = Mesh::new(Resolution::new(1024)?, sun, &corners, &[[0, 1, 2], [0, 2, 3]])?;
//! let file = Builder::new().bake(&Cpu::new(), &mesh)?.compress();
//!
//! let set = ShadowSet::read(&file)?; // of one light or many, compressed or not
//! let shadows = set.grids().next().expect("a file has a grid");
//! let (sun, filter) = (shadows.light().expect("it was made from a mesh"), FilterSize::new(9)?);
//! let light = |point: Vec3| {
//!     let position = sun.voxel(shadows.resolution(), point).expect("in front of the sun");
//!     shadows.filter(filter.bias(position, sun.normal(point, Vec3::Y)), filter)
//! };
//! assert_eq!([light(Vec3::ZERO), light(Vec3::new(2.0, 0.0, 0.0))], [0.0, 1.0]);
//! let edge = light(Vec3::new(1.0, 0.0, 0.0));
//! assert!((edge - 0.5).abs() < 0.07);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is here
//!
//! * A [`Builder`] makes shadows from a [`DepthSource`], which hands out the slices at
//!   which the rays enter and leave solids, tile by tile: from a [`DepthMap`]
//!   in memory, or whatever else implements the trait. Maps need never exist
//!   as a whole. [`Rule`] says how voxels inside of solids are filled.
//! * [`Surfaces`] are triangles that cast shadows; whether they enclose
//!   something, [`Surfaces::watertightness`] says. A [`Mesh`] is how a light sees
//!   them: it hands out such tiles, and [`Builder::bake`] makes its shadows
//!   without any map, in a time that grows with the silhouettes of what is
//!   closed, and with the surface of what is not. Large planes under a parallel
//!   light cost little either way.
//! * A [`Bake`] is the same work tile by tile: it can be watched and stopped,
//!   what is finished can be saved, and another process can resume it. A
//!   [`SetBake`] does so for the grids of several lights, all tiles in one queue; a
//!   [`Share`] of it can be baked elsewhere, and [`ShadowSet::merge`] joins the parts.
//! * A [`KeptGrid`] follows a scene in which something moves: a [`Rebuild`] makes the
//!   tiles that changed, over several frames.
//! * [`ShadowDag`] answers: [single voxels](ShadowDag::is_lit),
//!   [filtered shadows](ShadowDag::filter) of any width,
//!   [lit parts of a ray](ShadowDag::lit_intervals), the
//!   [depth](ShadowDag::depth) of a texel, the least and the most that is lit
//!   in a [box](ShadowDag::visibility), and many of these at once.
//! * [`ShadowDag::upload`] takes shadows to the memory of a backend, where
//!   [`Query`] answers questions in batches: on the CPU, and with the feature
//!   `wgpu` on GPUs, where the depths of a [`Mesh`] can be found too, except in a browser. The
//!   feature `wgsl` alone has the questions as parts for shaders, without wgpu; both
//!   are in the module `gpu`.
//! * [`LightSpace`] takes points, normals and rays of the world to the grid of
//!   a parallel or perspective light; [`Slices`] are equal or grow with the
//!   distance from the light. [`FilterSize::bias`] keeps a surface from
//!   shadowing itself, and [`FilterSize::clearance`] says how much more it takes on slopes.
//! * [`Form`] is how nodes are stored: plain, or packed into 0.25 to 0.33 of the
//!   bytes for closed scenes and 0.38 to 0.49 for open ones. Either is a file
//!   as it lies in memory; [`ShadowDag::from_bytes`] uses it in place and
//!   believes nothing that it has not checked. For storing,
//!   [`ShadowDag::compress`] takes about half of the packed bytes, and
//!   [`ShadowDag::read`] packs them again. [`ShadowDag::sizes`] says where
//!   the bytes are. A [`ShadowSet`] is a file of the shadows of several lights.
//!
//! # Features
//!
//! | feature | what |
//! |---|---|
//! | `rayon` (default) | shadows are built and asked on several threads, with the same results |
//! | `wgsl` | the module `gpu` with parts and records for shaders of your own, without wgpu |
//! | `wgpu` | [`Query`] and the depths of a [`Mesh`] on GPUs as well, and `wgsl` |
//!
//! `wgpu` compiles no driver: the module `gpu` of `crepuscular-backend` says how to choose one.
//!
//! # Limits
//!
//! One light for each grid. The scene is static, or changes now and then ([`KeptGrid`]).
//! Shadows are hard but for the filter, and a surface is known to half a voxel. Voxels inside
//! of closed solids have no meaning. What lies beside the map, or in front of its first
//! slice, counts as lit.
//!
//! Results are the same bit for bit on any number of threads, in any form and
//! through any file.
//!
//! # Based on
//!
//! * Sintorn, Kämpe, Olsson and Assarsson, Compact Precomputed Voxelized
//!   Shadows, SIGGRAPH 2014
//! * Kämpe, Sintorn and Assarsson, Fast, Memory-Efficient Construction of
//!   Voxelized Shadows, I3D 2015

mod bake;
mod build;
mod bytes;
mod chain;
mod checkpoint;
mod column;
mod compressed;
mod dag;
mod depths;
mod error;
mod file;
mod file_error;
mod fineness;
mod footprint;
mod form;
#[cfg(feature = "wgsl")]
pub mod gpu;
mod graph;
mod identity;
mod interval;
mod layout;
mod light_space;
mod merge;
mod mesh;
mod nodes;
mod patches;
mod pool;
mod progress;
mod query;
mod range_coder;
mod rebuild;
mod region;
mod resident;
mod resolution;
mod rule;
mod set;
mod set_bake;
mod set_checkpoint;
mod share;
mod sizes;
mod slices;
#[cfg(test)]
mod tests;
mod tiles;
mod top;

/// Backends and their memory, which this crate's functions take.
pub use glam;
pub use gpu_backend;

pub use bake::Bake;
pub use build::Builder;
pub use checkpoint::CheckpointError;
pub use dag::ShadowDag;
pub use depths::{DepthMap, DepthSource, Exits, TileRect};
pub use error::Error;
pub use file_error::FileError;
pub use form::Form;
pub use light_space::LightSpace;
pub use merge::MergeError;
pub use mesh::{Holes, Mesh, Surfaces, Watertightness};
pub use progress::Progress;
pub use query::{FilterSize, LitIntervals, Query, Ray, RayRecord, Visibility};
pub use rebuild::{KeptGrid, Rebuild};
pub use resident::{Resident, ResidentDag};
pub use resolution::Resolution;
pub use rule::Rule;
pub use set::{LightEntry, SetError, ShadowSet};
pub use set_bake::{LightGrids, SetBake};
pub use share::Share;
pub use sizes::{LevelSize, Sizes};
pub use slices::{Logarithmic, Slices};

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

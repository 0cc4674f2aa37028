//! Voxelized shadow volumes: which parts of an eye ray see a light, read from
//! one texel.
//!
//! The package is `crepuscular-voxel-shadow` and the library `voxel_shadow`: `Cargo.toml` has the
//! first name, and `use` the second.
//!
//! Space is divided along the [epipolar coordinates](epipolar) of an eye and a
//! light. Each texel is an eye ray, each of its bits a piece of that ray: 1 where
//! it is in shadow. A frame takes three steps on any backend and then answers
//! any number of queries:
//!
//! 1. [`Rectify`] a shadow map: for every light ray the first voxel in shadow
//!    ([`IndexMap`]). [`RectifyTriangles`] does the same without a shadow map, [`RectifyMasked`] of
//!    triangles with holes.
//! 2. [`BuildGrid::voxelise`]: set the bits of those voxels in a [`Grid`].
//! 3. [`BuildGrid::extrude`] them away from the light: an OR-scan. [`BuildGrid::build`] does both.
//!
//! ```
//! use epipolar::{Lattice, Light, LightRay, Resolution, Space, Spacing, ViewVolume};
//! use glam::Vec3;
//! use gpu_backend::Cpu;
//! use voxel_shadow::{BuildGrid, Grid, IndexMap, Rectify, Sampling, ShadowVolume};
//!
//! // A lamp over a disc, seen from the side.
//! let (eye, lamp) = (Vec3::new(0.0, 1.0, 8.0), Vec3::new(0.0, 4.0, 0.0));
//! let disc = |ray: &LightRay| {
//!     let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
//!     let distance = (2.0 - origin.y) / direction.y;
//!     let hit = origin + distance * direction;
//!     let inside = distance > 0.0 && hit.x.hypot(hit.z) < 1.0;
//!     if inside { distance } else { f32::INFINITY }
//! };
//!
//! let space = Space::new(Light::point(lamp)?, eye)?;
//! let view = ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [1.0, 1.0], 0.1, 30.0)?;
//! let voxels = Resolution::new(256, 256, 128)?;
//! let lattice = Lattice::new(space, &view, voxels, Spacing::Angle)?;
//!
//! let cpu = Cpu::new();
//! let mut map = IndexMap::new(&cpu, voxels)?;
//! let mut grid = Grid::new(&cpu, voxels)?;
//! cpu.rectify(&lattice, &disc, &mut map)?;
//! cpu.build(&map, &mut grid)?;
//!
//! let volume = ShadowVolume::new(&lattice, &grid, Sampling::default())?;
//! // A ray that passes 1 m under the disc: lit, shadowed for 3 m, lit.
//! let mut lit = Vec::new();
//! volume.ray_shadow(Vec3::NEG_Z, 20.0).lit_intervals(&mut lit);
//! let lit: Vec<_> = lit.iter().filter(|part| part.visibility > 0.5).collect();
//! assert!((lit[0].end - 6.5).abs() < 0.2);
//! assert!((lit[lit.len() - 1].start - 9.5).abs() < 0.2);
//!
//! // What fog sends from there: the crate `airlight` knows how much arrives from a part.
//! use airlight::{Evaluator, PhaseFunction, Segment, Table};
//! let table = Table::new(&PhaseFunction::Isotropic, 64)?;
//! let ray = Segment::from_ray(eye, Vec3::NEG_Z, lamp, 20.0);
//! let from = |part: &Segment| table.airlight(0.1, part);
//! let parts = lit.iter().map(|lit| lit.visibility * from(&ray.part(lit.start, lit.end)));
//! let airlight: f32 = parts.sum();
//! assert!(airlight < 0.6 * from(&ray), "the shadow is where most of the light would be");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Queries
//!
//! * [`ShadowVolume::ray_shadow`] at an eye ray gives a [`RayShadow`]: its lit fraction,
//!   lit intervals, weighted sums, the visibility at a distance.
//! * [`ShadowVolume::visibility`] of a point on a surface.
//! * [`ShadowVolume::lit_intervals`] and [`ShadowVolume::ray_shadows`] answer for many rays in
//!   less time.
//! * [`Query`] is the step that answers for many rays or points, on any backend.
//! * [`Sampling`] has the biases, the interpolation and the width of the axis.
//!
//! # Shadow maps of one's own
//!
//! [`DepthViews`] takes the depths that a renderer has drawn, of a spotlight, a cube around a lamp or the
//! cascades of a sun, reversed or not; on a GPU `gpu::DepthLayers` reads them in the
//! renderer's texture. What is no depth, such as a map of distances, answers
//! [`FirstBlocker`] as a closure, and in shaders the slot of that name.
//!
//! # Many lights
//!
//! [`AtlasGrid`] has the grids of many lights side by side, each in its own
//! epipolar space. [`RectifyAtlas`] and [`BuildAtlas`] make all of them in one pass
//! each, and [`AtlasGrid::volume`] is the [`ShadowVolume`] of one of them. An area
//! light is many points; let their spaces be [rotated](epipolar::Space::rotated)
//! against each other, so that the errors of their voxels average.
//!
//! # Features
//!
//! | feature | what |
//! |---|---|
//! | `rayon` (default) | steps of the CPU run on several threads, with the same results |
//! | `wgsl` | the module `gpu` with parts and records for shaders of your own, without wgpu |
//! | `wgpu` | all steps on GPUs as well, and `wgsl`: [`Rectify`] and its kind, [`BuildGrid`], [`Query`] |
//!
//! `wgpu` compiles no driver: see [`gpu_backend`] for how to choose one.
//!
//! # In a renderer
//!
//! The module `gpu` has a whole fog shader with the Rust around it, and says what to keep from
//! frame to frame. How much light arrives from a lit part is the business of the package
//! `crepuscular-airlight`; `lighting::fog_pass` of `crepuscular-lighting` does everything in one
//! call.
//!
//! # Limits
//!
//! Lights at a point, with or without a cone, or directional ones. A volume
//! is valid for the eye and the view of its lattice. Details smaller than a voxel
//! are lost or doubled; the quality is that of the coarsest of α, θ, φ and the
//! shadow map. Bits on different backends differ only where a rectified index does
//! (see `gpu`, feature `wgsl`).
//!
//! Based on: Wyman, Voxelized Shadow Volumes, HPG 2011; Wyman and Dai, Imperfect
//! Voxelized Shadow Volumes, HPG 2013.

mod atlas;
mod build;
mod depth_views;
mod error;
#[cfg(feature = "wgsl")]
pub mod gpu;
mod grid;
mod index_map;
mod intervals;
mod query;
mod rectify;
mod runs;
mod shadow;
mod triangles;
mod weights;

pub use atlas::{AtlasBlocker, AtlasGrid, AtlasMap, BuildAtlas, RectifyAtlas};
pub use build::BuildGrid;
pub use depth_views::{DepthViews, MAX_VIEWS};
pub use epipolar;
pub use error::Error;
pub use gpu_backend;
pub use grid::Grid;
pub use index_map::IndexMap;
pub use query::Query;
pub use rectify::{FirstBlocker, Rectify};
pub use runs::{LitInterval, Run, Runs};
pub use shadow::{RayShadow, Sampling, ShadowVolume};
pub use triangles::{Holes, RectifyMasked, RectifyTriangles};
pub use weights::Weights;

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

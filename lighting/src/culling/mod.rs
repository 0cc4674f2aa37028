//! Which rays of a picture a light may reach.
//!
//! A light with a range, or one that shines into a cone, reaches few of the rays of a
//! picture. [`RayTiles`] puts the rays that start at one eye into tiles of 4 × 4 pixels,
//! tiles into blocks of 4 × 4 tiles, and these twice more, each in a cone around it, and
//! finds the rays that a light may reach without asking every one of them. So the cost of
//! a picture grows with the lights that reach its rays and not with those that there are.
//!
//! * [`RayTiles::reached`]: the rays of one light.
//! * [`TileLights`]: the lights of each tile, for all that happens along rays.
//! * [`Clusters`]: the lights of each tile and slice of depth, for surfaces.
//! * [`PointLists`]: the lights of each point that is lit, from clusters or without.
//!
//! Based on: Olsson, Billeter and Assarsson, Clustered Deferred and Forward Shading, HPG
//! 2012; and Kämpe, Sintorn and Assarsson, Fast, Memory-Efficient Construction of
//! Voxelized Shadows, I3D 2015, section 4, whose lights are culled by tiles.
//!
//! # How a cone meets a light
//!
//! The rays of a tile lie within an angle δ around its axis `t`. A point of any of them at
//! the distance x from the eye is no farther than `κ x`, κ = 2 sin(δ/2), from the point
//! `x t` of the axis. So a ray of the tile can only be lit at x if the light, grown by `κ x`
//! on all sides, holds `x t`. For a ball of radius R around the light at `c`, and for a
//! cone of half angle β around the axis `a` from `c` on, with `z = (x t − c) · a` and
//! `r = |x t − c − z a|`, that is
//!
//! ```text
//! |x t − c| ≤ R + κ x             r cos β ≤ z sin β + κ x
//! ```
//!
//! both quadratic inequalities of x whose solutions are intervals, as distances from a
//! line are convex. The part of the axis in both is where the tile may be lit; it is
//! compared with how far the rays of the tile go, and its start with the length of each
//! ray. Rays need no slices of depth that way. Points of surfaces do, where a tile has many
//! lights before and behind them: a light may reach a cluster if its part of the tile meets
//! the cluster's distances.
//!
//! # What is guaranteed
//!
//! No ray that a light reaches is ever left out of those that are kept, and no light out of
//! the list of a ray or a point that it reaches. How many are kept for nothing depends on
//! how large a light is beside a tile: 1.1 to 1.3 times as many as it reaches, where it
//! covers a hundred pixels.
//!
//! Lights without end (suns, and lamps without a range) reach every ray. Lists are in the
//! order of the lights, whatever the tile: sums over them have the same bits as sums over
//! all lights, and a light that crosses the border of a tile or a cluster changes nothing
//! that it does not light. A list has no limit, and all lists together have one of
//! [`MOST_LISTED`].
//!
//! # In a picture
//!
//! Pairs whose source can answer for [many lights](crate::methods::many_lights) gather
//! them tile by tile, all in one pass. Every other [pair](crate::methods::PerLight) of a
//! visibility and an evaluator goes light by light: [`PickPixels`] takes the light that the
//! rays of one have gathered so far out of the picture, and puts it back when that of this
//! light has been added to it. Each pixel sums up its lights in their order, so that culling
//! changes no bit. Both do so from eight lights with a range or a cone on; not where
//! surfaces are see-through or rays share work, which goes by the numbers of rays. Light by
//! light, not a light that may reach more than three quarters of the rays.
//!
//! ```
//! use glam::Vec3;
//! use gpu_backend::Cpu;
//! use lighting::culling::{Clusters, RayTiles, TileLights};
//! use lighting::scene::{Camera, Emission, Emitter};
//! use lighting::Ray;
//!
//! let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0)?;
//! let pixel = |i: u32| camera.direction((i % 64) as f32 + 0.5, (i / 64) as f32 + 0.5, 64, 32);
//! let rays: Vec<Ray> = (0..64 * 32)
//!     .map(|i| Ray::new(Vec3::ZERO, pixel(i), 20.0).expect("a sound ray"))
//!     .collect();
//! let tiles = RayTiles::new(&Cpu::new(), &rays, 64, None).expect("rays from one eye");
//!
//! let at = Vec3::new(0.0, 0.0, -10.0);
//! let lamp = Emitter::point(at, Vec3::ONE, 0.5, Emission::Isotropic)?;
//! let reached = tiles.reached(&lamp).expect("a light with a range");
//! assert!((10..100).contains(&reached.len()));
//!
//! let middle = 16 * 64 + 32;
//! let lights = TileLights::new(&Cpu::new(), &tiles, &[lamp])?;
//! assert_eq!(lights.of_ray(middle, 20.0).collect::<Vec<_>>(), [0]);
//! assert_eq!(lights.of_ray(0, 20.0).count(), 0);
//! let clusters = Clusters::new(&Cpu::new(), lights)?;
//! assert_eq!(clusters.at(middle, 20.0).count(), 0, "a wall far behind the lamp");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod clusters;
#[cfg(feature = "wgpu")]
mod gpu;
mod lights;
mod pick;
mod points;
mod reach;
mod tiles;

#[cfg(test)]
pub(crate) mod tests;

pub use clusters::Clusters;
pub use lights::{MOST_LISTED, TileLights, TooManyLights};
pub use pick::PickPixels;
pub use points::PointLists;
pub use reach::{is_bounded, is_worthwhile};
pub use tiles::RayTiles;

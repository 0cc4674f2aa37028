//! Which rays of a picture a light may reach.
//!
//! A light with a range, or one that shines into a cone, reaches few of the rays of a picture.
//! [`RayTiles`] puts the rays that start at one eye into tiles of 4 × 4 pixels, the tiles into
//! blocks of 4 × 4, and these into larger blocks twice more, each with a cone around its rays.
//! It finds the rays that a light may reach without testing every one. So the cost of a picture
//! grows with the number of lights that reach its rays, not with the number of lights.
//!
//! * [`RayTiles::reached`]: the rays of one light.
//! * [`TileLights`]: the lights of each tile, for everything that happens along rays.
//! * [`Clusters`]: the lights of each tile and slice of depth, for surfaces.
//! * [`PointLists`]: the lights of each point that is to be lit, from clusters or without.
//!
//! Based on: Olsson, Billeter and Assarsson, Clustered Deferred and Forward Shading, HPG
//! 2012; and Kämpe, Sintorn and Assarsson, Fast, Memory-Efficient Construction of
//! Voxelized Shadows, I3D 2015, section 4, whose lights are culled by tiles.
//!
//! # How a cone meets a light
//!
//! The rays of a tile lie within an angle δ around its axis `t`. A point on any of them at the
//! distance x from the eye is within `κ x`, κ = 2 sin(δ/2), of the point `x t` on the axis. So
//! a ray of the tile can only be lit at x if `x t` is inside the light's volume grown by `κ x`
//! on all sides. For a ball of radius R around the light at `c`, and for a cone of half angle β
//! around the axis `a` with its apex at `c`, with `z = (x t − c) · a` and `r = |x t − c − z
//! a|`, this means
//! `r = |x t − c − z a|`, that is
//!
//! ```text
//! |x t − c| ≤ R + κ x             r cos β ≤ z sin β + κ x
//! ```
//!
//! Both are quadratic inequalities in x whose solutions are intervals, because the distance
//! from a line is convex. The tile may be lit where both hold. This interval is compared with
//! the length of the tile's rays, and its start with the length of each ray. Rays therefore
//! need no slices of depth. Points of surfaces do, where a tile has many lights in front of
//! them and behind them: a light may reach a cluster if its interval in the tile overlaps the
//! distances of the cluster.
//!
//! # What is guaranteed
//!
//! A ray that a light reaches is never left out of those that are kept, nor a light out of the
//! list of a ray or a point that it reaches. How many are kept in vain depends on the size of a
//! light relative to a tile: where a light covers a hundred pixels, 1.1 to 1.3 times as many
//! rays are kept as it reaches.
//!
//! Lights without bounds (suns, and lamps without a range or a cone) reach every ray. Lists are
//! in the order of the lights, so sums over a list have the same bits as sums over all lights,
//! and a light that crosses the border of a tile or a cluster changes nothing that it does not
//! light. The length of a single list is not limited; that of all lists together is, to
//! [`MOST_LISTED`].
//!
//! # In a picture
//!
//! Pairs whose source answers for [many lights](crate::methods::many_lights) at once gather
//! them tile by tile, in one pass. Every other [pair](crate::methods::PerLight) of a visibility
//! and an evaluator gathers light by light: [`PickPixels`] takes the pixels that a light may
//! reach out of the picture, with the light gathered so far, and puts them back when this light
//! has been added. Each pixel sums up its lights in their order, so culling changes no bit.
//!
//! Both happen if there are at least eight lights with a range or a cone, but not where
//! surfaces are see-through or rays share their work, because both refer to rays by number.
//! Light by light, a light that may reach more than three quarters of the rays is not culled.
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

//! Epipolar space: coordinates in which eye rays and light rays are
//! axis-aligned.
//!
//! The package is `crepuscular-epipolar` and the library `epipolar`: `Cargo.toml` has the first
//! name, and `use` the second.
//!
//! An eye and a light define an axis. The planes through it are numbered by an
//! angle θ; within each, a point has an angle α at the eye and an angle φ at
//! the light. An eye ray is a line of constant (α, θ), a light ray one of constant
//! (θ, φ), so that shadows extend along one coordinate of a grid and the light on
//! an eye ray is read along another.
//!
//! ```
//! use epipolar::{Lattice, Light, Resolution, Space, Spacing, ViewVolume};
//! use glam::Vec3;
//!
//! let eye = Vec3::new(0.0, 1.7, 0.0);
//! let lamp = Light::point(Vec3::new(2.0, 3.0, -6.0))?;
//! let space = Space::new(lamp, eye)?;
//! let view = ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [0.8, 0.45], 0.1, 40.0)?;
//! let voxels = Resolution::new(256, 256, 128)?;
//! let lattice = Lattice::new(space, &view, voxels, Spacing::Angle)?;
//!
//! // Which texel is an eye ray, and which of its bits is a point on it?
//! let point = Vec3::new(0.3, 1.0, -4.0);
//! let place = space.coordinates(point);
//! let row = lattice.alpha_position(place.ray.alpha);
//! let column = lattice.theta_position(place.ray.theta);
//! let bit = lattice.phi_position(place.phi);
//! assert!(row >= 0.0 && row < 256.0 && column >= 0.0 && column < 256.0);
//! assert!(bit >= 0.0 && bit < 128.0);
//!
//! // And back.
//! let again = Vec3::from(space.point(&place).expect("a point beside the axis"));
//! assert!((again - point).length() < 1e-5);
//! # Ok::<(), epipolar::Error>(())
//! ```
//!
//! * [`Space`] is the coordinate system of an eye and a [`Light`], with
//!   conversions both ways. Angles are [`Angle`]s, vectors that keep their
//!   digits next to the axis.
//! * [`Ranges`] are the tightest intervals of the three coordinates for what a
//!   [`ViewVolume`] can see.
//! * [`Lattice`] divides ranges into voxels: texels along α and θ
//!   ([`Resolution`]), bits along φ ([`Spacing`]).
//! * [`Lattice::locate_rays`] finds the positions of eye rays, a block at a time.
//! * [`Locate`] is the step that finds the positions of many points, on any
//!   backend.
//! * `gpu` (feature `wgsl`) has the same for shaders.
//!
//! # Features
//!
//! | feature | what |
//! |---|---|
//! | `rayon` (default) | [`Locate`] runs on several threads, with the same results |
//! | `wgsl` | the module `gpu` with parts and records for shaders of your own, without wgpu |
//! | `wgpu` | [`Locate`] on GPUs as well, and `wgsl` |
//!
//! `wgpu` compiles no driver: the module `gpu` of `crepuscular-backend` says how to choose one.
//!
//! # Limits
//!
//! Metres, right-handed. Vectors come and go as arrays, which vectors of every
//! version of glam convert to and from. Coordinates up to [`FARTHEST`], eye and light at least
//! [`SMALLEST_DISTANCE`] apart. Angles have a relative error of 4e-7, next to the
//! axis as well. On the axis θ means nothing and three angles do not tell where a
//! point is; users of a lattice treat that line on its own. Where the light is so
//! close to the eye that shadows between light rays and eye rays are thinner than
//! two voxels, a lattice has none ([`Lattice::blocked_from`]).
//!
//! Based on: Wyman, Voxelized Shadow Volumes, HPG 2011; Wyman and Dai, Imperfect
//! Voxelized Shadow Volumes, HPG 2013.

mod angle;
mod cone;
mod error;
mod footprint;
#[cfg(feature = "wgsl")]
pub mod gpu;
mod guess;
mod lattice;
mod light;
mod limits;
mod locate;
mod numeric;
mod ranges;
mod rays;
mod resolution;
mod space;
mod spacing;
mod view;

pub use angle::Angle;
pub use error::Error;
pub use footprint::Footprint;
pub use gpu_backend;
pub use lattice::Lattice;
pub use light::Light;
pub use limits::{FARTHEST, SMALLEST_DISTANCE};
pub use locate::Locate;
pub use ranges::Ranges;
pub use rays::{RAYS, RayBlock};
pub use resolution::Resolution;
pub use space::{Coordinates, EyeRay, LightRay, Phi, Space};
pub use spacing::Spacing;
pub use view::ViewVolume;

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

//! Precomputed voxelized shadows of what does not move: in the air, and filtered
//! on surfaces.
//!
//! Based on: Sintorn, Kämpe, Olsson and Assarsson, Compact Precomputed
//! Voxelized Shadows, SIGGRAPH 2014; Kämpe, Sintorn and Assarsson, Fast,
//! Memory-Efficient Construction of Voxelized Shadows, I3D 2015. They filter
//! shadows on surfaces; the same voxels also tell which parts of an eye ray are
//! lit, by a step for each homogeneous volume on its way.
//!
//! [`BakedShadow::bake`] makes the grids of one light from a scene, once.
//! A [`BakedShadow`] is a [`VisibilitySource`](crate::VisibilitySource) that
//! [`Gather`](crate::Gather) takes, and [`BakedShadow::filtered`] a
//! [`SurfaceShadow`](crate::visibility::SurfaceShadow); those of many lights at once are
//! [`FilteredShadows`], on any backend. What moves gets an
//! ordinary shadow map of its own beside it:
//!
//! ```
//! use glam::Vec3;
//! use gpu_backend::{Backend, Cpu};
//! use lighting::airlight::Quadrature;
//! use lighting::precomputed::{BakedShadow, Builder, FilterSize, Resolution};
//! use lighting::scene::{Geometry, Medium, Mesh, PhaseFunction, Scene};
//! use lighting::shadow_map::{Casters, RenderShadowMap};
//! use lighting::visibility::{Both, March, Spacing, SurfaceShadow};
//! use lighting::{Emitter, Gather, LitRays, Ray};
//!
//! let triangle = |x: f32| {
//!     let corner = |dx: f32, dz: f32| Vec3::new(x + dx, 2.0, -5.0 + dz);
//!     let scene = Scene::from(Mesh {
//!         positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)],
//!         triangles: vec![[0, 1, 2]],
//!         ..Mesh::default()
//!     });
//!     Geometry::new(&scene)
//! };
//! let (scenery, guest) = (triangle(-2.0)?, triangle(2.0)?);
//! let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE)?;
//! let fog = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic)?;
//! let cpu = Cpu::new();
//!
//! let (baked, watertightness) =
//!     BakedShadow::bake(&cpu, &scenery, &sun, Resolution::new(512)?, Builder::new())?;
//! assert_eq!(watertightness.open_parts, 1, "a triangle encloses nothing");
//! let map = cpu.shadow_map(&Casters::upload(&cpu, &guest)?, &sun, 256)?;
//! let march = March::new(&map, 64, Spacing::Distance);
//! let shadow = Both(&baked, march);
//!
//! let rays = [Ray::new(Vec3::new(-9.0, 1.0, -5.5), Vec3::X, 18.0).expect("a sound ray")];
//! let rays = cpu.upload(&rays)?;
//! let mut radiance = cpu.zeros::<[f32; 4]>(1)?;
//! let quadrature = Quadrature::with_tolerance(fog.phase(), 1e-4)?;
//! let lit = LitRays::new(&rays, &sun, &fog).joined();
//! cpu.gather(&lit, &shadow, &quadrature, &mut radiance)?;
//! assert!(radiance[0][0] > 0.0);
//!
//! let floor = baked.filtered(FilterSize::new(9)?);
//! assert_eq!(floor.visibility(Vec3::new(-2.0, 0.0, -5.0), Vec3::Y).x, 0.0);
//! assert_eq!(floor.visibility(Vec3::new(2.0, 0.0, -5.0), Vec3::Y).x, 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`BakedShadow::upload`] takes them to any backend. Files hold the shadows of
//! one light or several, see [`ShadowSet`]; [`bake`] makes them with breaks.
//!
//! # Accuracy
//!
//! A shadow's edge is off by at most a texel across the rays of the light and
//! half a slice along them; details smaller than a texel are there where the
//! ray through its centre meets them. What is inside of closed solids has no
//! meaning. A light inside of a solid lights nothing.

mod filtered;
#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
#[cfg(feature = "methods")]
mod method;
#[cfg(all(feature = "methods", feature = "wgpu"))]
mod method_gpu;
mod shadow;
mod space;
#[cfg(test)]
mod tests;

pub use filtered::{FilteredShadow, FilteredShadows};
#[cfg(feature = "methods")]
pub(super) use method::methods;
#[cfg(feature = "methods")]
pub use method::{FROM_FILE, PRECOMPUTED, share_precomputed};
pub use shadow::{BakedError, BakedShadow, BakedShadows, bake, surfaces};
pub use shadow_dag::{
    Builder, Error, FilterSize, Form, LightGrids, Resolution, SetError, ShadowSet, Surfaces,
    Watertightness,
};
pub use space::{light_grids, light_spaces};

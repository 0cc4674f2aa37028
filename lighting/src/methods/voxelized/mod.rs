//! Voxelized shadow volumes as a source of lit intervals: a few fetches give the visibility
//! along all of a ray.
//!
//! Based on: Wyman, Voxelized Shadow Volumes, HPG 2011; Wyman and Dai, Imperfect Voxelized
//! Shadow Volumes, HPG 2013. They gather the average visibility of a ray times the airlight of
//! the whole ray, which is [`Detail::Average`] here. The same bits also tell where the lit
//! parts are.
//!
//! A [`VoxelVolume`] holds the voxels of one light for one view. [`VoxelVolume::update`] makes
//! them anew from a shadow map, in each frame or for each light in turn.
//! [`VoxelVolume::source`] gives the source that [`Gather`](crate::Gather) takes.
//!
//! ```
//! use glam::Vec3;
//! use gpu_backend::{Backend, Cpu, Download};
//! use lighting::airlight::Quadrature;
//! use lighting::scene::Emission;
//! use lighting::scene::{Camera, Geometry, Medium, Mesh, PhaseFunction, Scene};
//! use lighting::shadow_map::{Casters, RenderShadowMap};
//! use lighting::voxelized::{Detail, Eye, Resolution, VoxelVolume};
//! use lighting::{Emitter, Gather, LitRays, Ray};
//!
//! // A triangle under a lamp, in fog.
//! let scene = Scene::from(Mesh {
//!     positions: vec![Vec3::new(-1.0, 2.0, -6.0), Vec3::new(1.0, 2.0, -6.0), Vec3::new(0.0, 2.0, -4.0)],
//!     triangles: vec![[0, 1, 2]],
//!     ..Mesh::default()
//! });
//! let lamp = Emitter::point(Vec3::new(0.0, 4.0, -5.0), Vec3::splat(50.0), f32::INFINITY, Emission::Isotropic)?;
//! let fog = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic)?;
//! let camera = Camera::look_at(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 2.0, -5.0), 1.0)?;
//! let rays = [Ray::new(camera.eye(), Vec3::new(0.0, 0.0, -1.0), 20.0).expect("a sound ray")];
//!
//! let cpu = Cpu::new();
//! let casters = Casters::upload(&cpu, &Geometry::new(&scene)?)?;
//! let map = cpu.shadow_map(&casters, &lamp, 512)?;
//! let mut voxels = VoxelVolume::new(&cpu, Resolution::new(256, 256, 256)?)?;
//! let eye = Eye::of_camera(&camera, [16, 9], &rays, &fog);
//! voxels.update(&cpu, &lamp, &eye, &map)?;
//!
//! let rays = cpu.upload(&rays)?;
//! let mut radiance = cpu.zeros::<[f32; 4]>(1)?;
//! let quadrature = Quadrature::with_tolerance(fog.phase(), 1e-4)?;
//! let shadow = voxels.source(Detail::Runs);
//! let lit = LitRays::new(&rays, &lamp, &fog);
//! cpu.gather(&lit, &shadow, &quadrature, &mut radiance)?;
//! assert!(cpu.download(&radiance)?[0][0] > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//!
//! All rays must start at the eye; one that does not gets the answer for a ray from the eye.
//! Ends of intervals are off by about a voxel, and by more where a ray passes the light at a
//! distance of a few voxels. Details smaller than a voxel, or than a texel of the shadow map,
//! are lost.

#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
#[cfg(feature = "methods")]
mod method;
mod source;
#[cfg(test)]
mod tests;
mod volume;

pub use crate::path::depth_range;
pub use epipolar::{Resolution, Spacing};
#[cfg(feature = "methods")]
pub(super) use method::methods;
pub use source::{Detail, VoxelShadow};
pub use volume::{BuildVoxels, Eye, VoxelError, VoxelVolume};
pub use voxel_shadow::Sampling;

pub(crate) use volume::State;

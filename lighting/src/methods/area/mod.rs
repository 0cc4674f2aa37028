//! Area lights as many virtual lights, each with its voxelized shadow volume.
//!
//! Based on: Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013. An area
//! light is sampled as virtual point lights; low-resolution shadow maps of all of
//! them are [rendered into one buffer](crate::shadow_map::ShadowMapAtlas),
//! rectified in one pass and extruded in another ([`LightVolumes`]), and one
//! [gather](GatherMany) sums their airlight.
//!
//! ```text
//! L(x, ω) = Σ_i ∫ σ_s e^{−σ_t u} V_i(u) p(ω, ω_i) L_i(u) du         (4)
//! ```
//!
//! # Departures
//!
//! * The shadow maps may be exact: triangles rendered as for a single light. The
//!   paper's [imperfect maps](crate::shadow_map::RenderImperfectMaps) are the other
//!   choice, with a level of detail for each light that it misses. Their holes are filled
//!   only where that is asked for ([`FillHoles`](crate::shadow_map::FillHoles), method
//!   `area-imperfect filled`): splats overlap so far that filling adds more false shadow
//!   than it takes false light away.
//! * The paper multiplies the average of the visibility bits with the airlight of the
//!   whole ray, whose error has a floor. That is [`Detail::Average`]; here the bits
//!   also tell where the lit parts are ([`Detail::Runs`]), or weigh the light of
//!   each voxel ([`Detail::Voxels`]), which converges.
//! * The last line of the paper's pseudocode scales the airlight by 1 − e^{−τ}, which
//!   is not in its equation 4 (the integral holds the attenuation already), and it is
//!   not done here.
//! * Surfaces that are [lit from the same voxels](LightManySurfaces), interpolated or
//!   not, are Lambertian and not those of Phong.
//! * Points have the cosine emission of the surface they stand for, in which the
//!   evaluator integrates along the ray.
//!
//! ```
//! use glam::Vec3;
//! use gpu_backend::{Backend, Cpu};
//! use lighting::airlight::Quadrature;
//! use lighting::area::{GatherMany, LightVolumes, ManyLights};
//! use lighting::scene::{AreaLight, Camera, Geometry, Medium, Mesh, Pattern, PhaseFunction, Scene};
//! use lighting::shadow_map::{Casters, RenderShadowMapAtlas};
//! use lighting::voxelized::{Detail, Eye, Resolution};
//! use lighting::{Interleaving, Ray};
//!
//! // A triangle under a panel, in fog.
//! let scene = Scene::from(Mesh {
//!     positions: vec![Vec3::new(-1.0, 2.0, -6.0), Vec3::new(1.0, 2.0, -6.0), Vec3::new(0.0, 2.0, -4.0)],
//!     triangles: vec![[0, 1, 2]],
//!     ..Mesh::default()
//! });
//! let panel = AreaLight {
//!     corner: Vec3::new(-1.0, 4.0, -6.0),
//!     edges: [2.0 * Vec3::X, 2.0 * Vec3::Z],
//!     radiance: Vec3::splat(10.0),
//!     ..AreaLight::default()
//! };
//! let lights = panel.virtual_lights(Pattern::Lattice, 16)?;
//! let fog = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic)?;
//! let camera = Camera::look_at(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 2.0, -5.0), 1.0)?;
//! let rays = [Ray::new(camera.eye(), Vec3::new(0.0, 0.0, -1.0), 20.0).expect("a sound ray")];
//!
//! let cpu = Cpu::new();
//! let casters = Casters::upload(&cpu, &Geometry::new(&scene)?)?;
//! let maps = cpu.shadow_map_atlas(&casters, &lights, 128)?;
//! let mut voxels = LightVolumes::new(&cpu, Resolution::new(128, 128, 128)?, lights.len())?;
//! voxels.update(&cpu, &lights, &Eye::of_camera(&camera, [16, 9], &rays, &fog), &maps)?;
//!
//! let rays = cpu.upload(&rays)?;
//! let mut radiance = cpu.zeros::<[f32; 4]>(1)?;
//! let quadrature = Quadrature::with_tolerance(fog.phase(), 1e-4)?;
//! let many = ManyLights { rays: &rays, emitters: &lights, medium: &fog, detail: Detail::Runs, interleaving: Interleaving::NONE };
//! cpu.gather_many(&many, &voxels, &quadrature, &mut radiance)?;
//! assert!(radiance[0][0] > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How fine
//!
//! The paper finds 128 texels and voxels along each axis enough for many lights, because
//! their errors average. Measured, they do not: what is left is the same for all lights.
//! On the scene `pergola` lit runs of exact maps err by so much of the mean radiance,
//! with maps and voxels of the same number along each axis:
//!
//! | lights | 32 | 64 | 128 | 256 |
//! |---|---|---|---|---|
//! | 16 | 4.5 % | 1.4 % | 1.2 % | 0.67 % |
//! | 64 | 3.7 % | 1.4 % | 0.48 % | 0.28 % |
//! | 128 | 3.7 % | 1.3 % | 0.43 % | 0.18 % |
//! | 256 | 3.8 % | 1.3 % | 0.39 % | 0.17 % |
//!
//! Halving the voxels costs 2.2 to 3.3 times the error, from 64 lights on nearly whatever
//! their number. More than 64 lights are worth while from 128 voxels on, and more than
//! 128 from 256 on. With α, θ and the maps as above and always 128 bits of φ the errors
//! of 128 lights are the same to two digits but at 256, where they are 0.20 %. The
//! paper's average errs by 18 % there at any of these resolutions.
//!
//! The method of the list has one resolution, 128, whatever the number of lights. A coarser
//! one would save next to nothing: of a frame of 960 × 540 pixels the voxels of 256 lights
//! take less than one part in two hundred of the time, than one in twenty with the work
//! shared by windows of 3 × 3 pixels, and than one in seven with a quarter of the pixels
//! besides.
//!
//! # A light that moves
//!
//! Lights are sampled anew in each frame, and nothing is kept from one to the next. While
//! the light of `pergola` moves 1 cm a frame, the change from frame to frame errs by
//! 0.34 % of the mean with 64 lights and by 0.19 % with 128, where a frame alone errs by
//! 0.41 and 0.35 %: less than if frames were independent. With 16 lights and fewer it errs
//! as frames that are (bench `area`, id `moving`).
//!
//! # Speed
//!
//! On two cores, `pergola` at 960 × 540 with 256 lights, exact maps made before (bench
//! `area`, ids `baseline` and `froxels`; errors on 1306 of the pixels):
//!
//! | gather | error | time | rays of `area-rays` for the same error | faster than these |
//! |---|---|---|---|---|
//! | lit runs | 0.66 % | 33 s | more than 1024 | 4.1 × |
//! | lit runs, 3 × 3 | 0.91 % | 4.0 s | more than 1024 | 34 × |
//! | lit runs, 3 × 3, a quarter | 1.9 % | 1.1 s | 301 | 35 × |
//! | the paper's average | 17 % | 22 s | 12 | 0.07 × |
//!
//! Froxels stop at 22 % there, in 0.05 to 0.15 s; four lights by lit runs, shared and at a
//! quarter of the pixels, err by 4.7 % in 0.1 s.
//!
//! # Limits
//!
//! Those of [`voxelized`](crate::voxelized), for each of the lights. What fits into
//! a buffer of a device bounds the number of lights that are gathered together; the
//! method of the list takes more in groups.

mod gather;
#[cfg(feature = "wgpu")]
mod gpu;
#[cfg(feature = "wgpu")]
mod gpu_surfaces;
#[cfg(feature = "wgpu")]
#[cfg(test)]
mod gpu_tests;
#[cfg(feature = "methods")]
mod groups;
#[cfg(feature = "methods")]
mod method;
mod surfaces;
#[cfg(test)]
mod surfaces_tests;
#[cfg(test)]
mod tests;
#[cfg(feature = "wgpu")]
mod turns;
mod volumes;

pub use gather::{GatherMany, ManyLights};
#[cfg(feature = "methods")]
pub(super) use method::methods;
pub use surfaces::{LightManySurfaces, ManyOnSurfaces, SurfaceLookup};
#[cfg(feature = "wgpu")]
pub use turns::AirlightTurns;
pub use volumes::{BuildLightVolumes, LightVolumes, SurfaceVoxels};

#[cfg(doc)]
use crate::voxelized::Detail;

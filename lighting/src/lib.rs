//! Light and shadow in fog: single scattering along eye rays.
//!
//! The package is `crepuscular-lighting` and the library `lighting`: `Cargo.toml` has the first
//! name, and `use` the second.
//!
//! # Which crate for what
//!
//! | you want | take |
//! |---|---|
//! | fog with shadows in a renderer's frame, in one call | `lighting::fog_pass` of `crepuscular-lighting`, features `wgpu` and `voxel-shadow` |
//! | the same in a shader of your own | `voxel_shadow::gpu` of `crepuscular-voxel-shadow` and `airlight::gpu` of `crepuscular-airlight` |
//! | the glow of a lamp without shadows | `crepuscular-airlight` |
//! | shadows of what stands still, from a file | `crepuscular-shadow-dag` |
//! | shadows of smoke, hair and glass | `crepuscular-transmittance` |
//! | methods compared on a scene of yours | this crate, or the program `crepuscular` |
//!
//! # How it works
//!
//! Everything here answers one of two questions about an eye ray:
//!
//! 1. *Which parts of the ray see the light?* A [`VisibilitySource`] yields the lit intervals of
//!    a ray. Sources find them
//!    * exactly, from the triangles ([`visibility::Exact`]);
//!    * step by step in a shadow map (`visibility::March`), in one that is filtered
//!      (`methods::prefiltered`), only where shadow volumes are (`methods::hybrid`), or with the
//!      colours of a cookie (`methods::textured`);
//!    * run by run in a shadow map (`methods::epipolar`), or between the faces of a mesh that is
//!      made from it (`methods::light_volumes`);
//!    * in a voxelized shadow volume (`voxelized::VoxelShadow`);
//!    * by a walk through precomputed shadows (`precomputed::BakedShadow`).
//!
//!    [`visibility::Both`] joins two of them.
//! 2. *How much light arrives from an interval?* An [`AirlightEvaluator`] integrates the
//!    scattered light over an interval: [`airlight::Quadrature`], any evaluator of the crate
//!    `airlight` in [`airlight::Analytic`], [`airlight::EquiAngular`], [`airlight::Midpoint`].
//!
//! The light that reaches the eye through the air is (1) × (2), summed over the lights.
//! [`Gather`] computes it for a bundle of rays. Any source works with any evaluator.
//!
//! ```
//! use glam::Vec3;
//! use gpu_backend::{Backend, Cpu, Download};
//! use lighting::scene::{Emission, Medium, PhaseFunction};
//! use lighting::{Emitter, Gather, LitRays, Ray, airlight, visibility};
//!
//! let cpu = Cpu::new();
//! let fog = Medium::new(Vec3::splat(0.1), Vec3::splat(0.01), PhaseFunction::Isotropic)?;
//! let lamp = Emitter::point(Vec3::new(1.0, 0.0, -4.0), Vec3::splat(50.0), f32::INFINITY, Emission::Isotropic)?;
//! let rays = [Ray::new(Vec3::ZERO, Vec3::NEG_Z, 10.0).expect("a sound ray")];
//!
//! let rays = cpu.upload(&rays)?;
//! let mut radiance = cpu.zeros::<[f32; 4]>(1)?;
//! let nothing_in_the_way = visibility::Unshadowed;
//! let quadrature = airlight::Quadrature::with_tolerance(fog.phase(), 1e-4)?;
//! let lit = LitRays::new(&rays, &lamp, &fog);
//! cpu.gather(&lit, &nothing_in_the_way, &quadrature, &mut radiance)?;
//! assert!(cpu.download(&radiance)?[0][0] > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Modules and features
//!
//! | module | feature | what |
//! |---|---|---|
//! | [`scene`] | `gltf`, `ply`, `obj`, `hair`, `vol`, `nvdb`, `vdb`, `procedural`, `trace` | the crate `crepuscular-scene`: meshes, hair, smoke, lights, camera, medium; files, procedural scenes, a BVH; [`scene::Geometry`] and [`Emitter`] are what algorithms see |
//! | [`visibility`] | `shadow-map`, `trace`, `translucent` | sources of lit intervals, and shadows on surfaces |
//! | [`airlight`] | | evaluators of intervals |
//! | [`plan`] | | which passes a picture needs, and why the others do not run |
//! | `prediction` | `methods` | what each method will cost and how large its error will be, from a short probe |
//! | [`methods::heterogeneous`] | `translucent` for the list | smoke, and fog that thins out with altitude, as they are seen and lit |
//! | [`methods::many_lights`] | | many lights in one pass |
//! | [`methods`] | `methods` for the list | every way of making an image of airlight, a folder each, and the list of them |
//! | `shadow_map` | `shadow-map` | orthographic, perspective and cube shadow maps |
//! | `voxelized` | `voxel-shadow` | voxelized shadow volumes as a visibility source |
//! | `froxels` | `shadow-map` | volumetric fog in froxels (the cells of a grid over the view), as game engines light it |
//! | `area` | `area` | area lights as many voxelized shadow volumes |
//! | `raytraced_area` | `trace` | area lights by shadow rays and exact runs: the baseline |
//! | `precomputed` | `shadow-dag` | precomputed voxelized shadows, in the medium and, filtered, on surfaces |
//! | `translucent` | `translucent` | transmittance maps: hair, smoke and glass as lights see them |
//! | `hair` | `translucent`, `trace` | hair as the eye sees it: lit ribbons, before and behind fog and smoke |
//! | `surface` | `trace` | the light of the surfaces at the ends of rays |
//! | [`direct_light`] | | the light of many lights that reaches surfaces directly, on any backend |
//! | [`surface_scattering`] | `shadow-map` for shadows | light that the fog scatters onto these surfaces |
//! | `indirect` | `shadow-map`, `trace` | surface scattering and the environment for a whole view, on any backend |
//! | [`culling`] | | which rays of a picture a light may reach, and which lights may reach a ray or a surface |
//! | [`environment`] | | light from all around, seen through fog and on surfaces |
//! | `fog_pass` | `wgpu`, `voxel-shadow` | the fog of a renderer's frame by one object: its own depths and shadow maps in, a texture out |
//! | `gpu` | `wgpu` | the shaders of all this, and how to add to them |
//!
//! # Conventions and limits
//!
//! Coordinates are right-handed, in metres, with +Y up; cameras and lights look along their
//! local −Z. Light is linear RGB radiance.
//!
//! Media scatter light once. They are homogeneous, except in [`methods::heterogeneous`], which
//! sees smoke and fog that thins out with altitude. Blockers are opaque, masked or see-through
//! (see [`Caster`](scene::Caster)), or hair and smoke (the module `translucent`). Airlight
//! grows without bound along the line through a point light: a ray that passes the light at
//! less than 1e-4 of the light's distance from the eye counts as one that passes at that
//! distance, where the airlight is finite.

pub mod airlight;
pub mod culling;
pub mod direct_light;
pub mod environment;
mod eye_panes;
#[cfg(all(feature = "wgpu", feature = "voxel-shadow"))]
pub mod fog_pass;
mod gather;
#[cfg(feature = "wgpu")]
pub mod gpu;
#[cfg(all(feature = "translucent", feature = "trace"))]
pub mod hair;
#[cfg(feature = "trace")]
mod hull;
#[cfg(all(feature = "shadow-map", feature = "trace"))]
pub mod indirect;
mod interleaving;
pub mod methods;
mod path;
pub mod plan;
#[cfg(feature = "methods")]
pub mod prediction;
#[cfg(feature = "shadow-map")]
pub mod shadow_map;

#[cfg(feature = "trace")]
pub mod surface;
mod surface_point;
pub mod surface_scattering;
pub mod visibility;

pub use gpu_backend;
pub use scene;

pub use airlight::AirlightEvaluator;
pub use eye_panes::EyePanes;
pub use gather::{Gather, LitRays, Touching, Watch};
pub use interleaving::{Interleaving, Part};
#[cfg(feature = "area")]
pub use methods::area;
#[cfg(feature = "shadow-map")]
pub use methods::froxels;
#[cfg(feature = "shadow-dag")]
pub use methods::precomputed;
#[cfg(feature = "trace")]
pub use methods::raytraced_area;
#[cfg(feature = "translucent")]
pub use methods::translucent;
#[cfg(feature = "voxel-shadow")]
pub use methods::voxelized;
pub use path::LightPath;
pub use scene::{Emitter, Interval, Ray};
pub use surface_point::SurfacePoint;
pub use visibility::{LitInterval, VisibilitySource};

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
